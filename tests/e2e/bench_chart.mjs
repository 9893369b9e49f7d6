// Printed figures, no test: how smoothly a chart of sixteen curves with bands follows the pointer
// and zooms. `node tests/e2e/bench_chart.mjs` with QRAYD and QRAY_E2E_DIR as ctest sets them.
// Drawn by the processor (SwiftShader): a machine with a graphics processor does better.
import { start_all } from './support.mjs';

const kCurves = 16;
const kPoints = 24;
const kFrames = 300;
const quantile = (values, q) =>
  values.toSorted((a, b) => a - b)[Math.floor(q * (values.length - 1))];

const all = await start_all();
const page = await all.browser.page(`${all.server.url}/#tables`);
const measured = await page.evaluate(async ([curves, points, count]) => {
  const { ErrorChart } = await import('/error_chart.js');
  const root = document.createElement('div');
  root.className = 'chart';
  document.querySelector('#tables-page').append(root);
  const chart = new ErrorChart(root, () => {}, () => {}, { zooms: true, legend: false });
  // Each has times of its own, as runs that are bounded by time have.
  await chart.show(Array.from({ length: curves }, (_, line) => {
    const xs = Array.from({ length: points }, (__, i) => 0.1 * 1.25 ** i * (1 + line / 100));
    return { label: `method ${line}`, points: xs.map((x) => [x, (1 + line / 8) / x]),
      spread: xs.map((x) => [0.8 * (1 + line / 8) / x, 1.3 * (1 + line / 8) / x]) };
  }), 'seconds', 'relMSE');
  const run = (act) => new Promise((resolve) => {
    const frames = [];
    let script_ms = 0;
    let last = performance.now();
    const step = (now) => {
      frames.push(now - last);
      last = now;
      const begin = performance.now();
      act(frames.length);
      script_ms += performance.now() - begin;
      if (frames.length < count) requestAnimationFrame(step);
      else resolve({ frames: frames.slice(5), script_ms: script_ms / count });
    };
    requestAnimationFrame(step);
  });
  const { over } = chart.plot;
  const box = over.getBoundingClientRect();
  const idle = await run(() => {});
  const hover = await run((i) => over.dispatchEvent(new MouseEvent('mousemove', { bubbles: true,
    clientX: box.left + box.width * (0.5 + 0.4 * Math.sin(i / 20)),
    clientY: box.top + box.height * (0.5 + 0.4 * Math.cos(i / 13)) })));
  const zoom = await run((i) => {
    const part = 0.3 + 0.25 * Math.sin(i / 20);
    chart.plot.setScale('x', { min: 0.1 + part, max: 20 * (1.2 - part) });
  });
  return { idle, hover, zoom };
}, [kCurves, kPoints, kFrames]);
for (const [name, { frames, script_ms }] of Object.entries(measured)) {
  console.log(`${kCurves} curves, ${name}: ` +
    `${(1000 * frames.length / frames.reduce((a, b) => a + b)).toFixed(0)} frames/s; a frame's ` +
    `median ${quantile(frames, 0.5).toFixed(1)} ms, 95th of a hundred ` +
    `${quantile(frames, 0.95).toFixed(1)} ms; script ${script_ms.toFixed(2)} ms`);
}
await all.close();
process.exit(0);
