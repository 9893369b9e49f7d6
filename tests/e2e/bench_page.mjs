// Printed figures, no test: how soon the page paints, and how smoothly a picture of two megapixels
// pans. `node tests/e2e/bench_page.mjs` with QRAYD and QRAY_E2E_DIR as ctest sets them.
// Drawn by the processor (SwiftShader): a machine with a graphics processor does better.
import { start_all, wait_for_tiles } from './support.mjs';

const kLoads = 15;
const kPanSteps = 240;
const quantile = (values, q) =>
  values.toSorted((a, b) => a - b)[Math.floor(q * (values.length - 1))];

const all = await start_all();
const job = await all.server.post({ scene: 'cornell-box', method: 'none', samples: 1, width: 1920,
  height: 1080 });
await all.server.wait_until(job, ({ state }) => state === 'succeeded');

const paints = [];
for (let i = 0; i < kLoads; ++i) {
  const page = await all.browser.page(all.server.url);
  paints.push(await page.evaluate(() => new Promise((resolve) => {
    new PerformanceObserver((list) => resolve(list.getEntries().find(({ name }) =>
      name === 'first-contentful-paint').startTime)).observe({ type: 'paint', buffered: true });
  })));
  await page.context().close();
}
console.log(`first contentful paint over loopback, ${kLoads} loads: median ` +
  `${quantile(paints, 0.5).toFixed(0)} ms, slowest ${Math.max(...paints).toFixed(0)} ms`);

const page = await all.browser.page(`${all.server.url}/#job=${job}&zoom=2`);
await wait_for_tiles(page, 0, 500);
const box = await page.locator('.stage').boundingBox();
const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
await page.mouse.move(x, y);
await page.mouse.down();
await page.evaluate(() => {
  globalThis.frames_ms = [];
  let last = performance.now();
  const tick = (now) => {
    globalThis.frames_ms.push(now - last);
    last = now;
    requestAnimationFrame(tick);
  };
  requestAnimationFrame(tick);
});
const start = performance.now();
for (let i = 1; i <= kPanSteps; ++i) {
  await page.mouse.move(x + 150 * Math.sin(i / 20), y + 80 * Math.sin(i / 13));
}
const seconds = (performance.now() - start) / 1000;
await page.mouse.up();
const frames = (await page.evaluate(() => globalThis.frames_ms)).slice(2);
console.log(`panning 1920 x 1080 at 200 %: ${(frames.length / seconds).toFixed(0)} frames/s over ` +
  `${seconds.toFixed(1)} s; a frame's median ${quantile(frames, 0.5).toFixed(1)} ms, 95th of a ` +
  `hundred ${quantile(frames, 0.95).toFixed(1)} ms, longest ${Math.max(...frames).toFixed(1)} ms`);
await all.close();
process.exit(0);
