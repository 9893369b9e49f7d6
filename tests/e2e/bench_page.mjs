// Printed figures, no test: how soon the page paints, and how smoothly a picture of two megapixels
// pans, and how smoothly sixteen groups of lights are mixed. `node tests/e2e/bench_page.mjs` with
// QRAYD and QRAY_E2E_DIR as ctest sets them; with the argument `mixing` that alone.
// Drawn by the processor (SwiftShader): a machine with a graphics processor does better.
import { createHash } from 'node:crypto';
import { start_all, wait_for_tiles } from './support.mjs';

const kLoads = 15;
const kPanSteps = 240;
const quantile = (values, q) =>
  values.toSorted((a, b) => a - b)[Math.floor(q * (values.length - 1))];

const all = await start_all();
if (process.argv[2] !== 'mixing') {
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
  console.log(`panning 1920 x 1080 at 200 %: ${(frames.length / seconds).toFixed(0)} frames/s ` +
    `over ${seconds.toFixed(1)} s; a frame's median ${quantile(frames, 0.5).toFixed(1)} ms, 95th ` +
    `of a hundred ${quantile(frames, 0.95).toFixed(1)} ms, longest ` +
    `${Math.max(...frames).toFixed(1)} ms`);
  await page.context().close();
}

// Sixteen groups of lights at 1920 x 1080, one slider moving.
const kGroups = 16;
const lamps = Array.from({ length: kGroups }, (_, i) => `lamp ${i}`);
const room = {
  name: 'sixteen lamps',
  camera: { position: [0, 1, 4], target: [0, 1, 0], vertical_fov_deg: 40 },
  materials: [{ name: 'white', type: 'diffuse', reflectance: 0.7 },
    ...lamps.map((name, i) => ({ name, type: 'diffuse', reflectance: 0,
      emission: [9, 9 - i / 2, 1 + i / 2] }))],
  meshes: [
    { material: 'white', quad: { origin: [-3, 0, 3], edge1: [6, 0, 0], edge2: [0, 0, -6] } },
    ...lamps.map((name, i) => ({ name, material: name,
      sphere: { center: [i / 4 - 2, 1 + (i % 3) / 3, -(i % 5) / 4], radius: 0.06 } }))],
};
const bytes = new TextEncoder().encode(JSON.stringify(room));
const sha256 = createHash('sha256').update(bytes).digest('hex');
await fetch(`${all.server.url}/v1/assets/${sha256}`, { method: 'PUT', body: bytes });
const { name } = await (await fetch(`${all.server.url}/v1/scenes`, { method: 'POST',
  headers: { 'content-type': 'application/json' },
  body: JSON.stringify({ files: { 'scene.json': sha256 } }) })).json();
const mixed = await all.server.post({ scene: name, method: 'none', samples: 1, width: 1920,
  height: 1080, light_groups: 'each' });
await all.server.wait_until(mixed, ({ state }) => state === 'succeeded');
const mixing = await all.browser.page(
  `${all.server.url}/#job=${mixed}&mix=${Array(kGroups).fill('1').with(1, '2').join(';')}`);
await mixing.waitForFunction(async () => (await import('/app.js')).viewer.pictures[0].groups_came);
await mixing.waitForTimeout(4000); // textures are on their way, and the picture in full size
const moved = await mixing.evaluate(() => new Promise((resolve) => {
  const slider = document.querySelectorAll('.mixer-groups [type=range]')[3];
  const times = [];
  let script_ms = 0;
  let last = performance.now();
  const step = (now) => {
    times.push(now - last);
    last = now;
    slider.value = 3 * Math.sin(times.length / 20);
    const begin = performance.now();
    slider.dispatchEvent(new Event('input', { bubbles: true }));
    script_ms += performance.now() - begin;
    if (times.length < 400) requestAnimationFrame(step);
    else resolve({ first: Math.max(...times.slice(0, 5)), frames: times.slice(5),
      script_ms: script_ms / times.length,
      drawn: document.querySelector('canvas.picture').width });
  };
  requestAnimationFrame(step);
}));
console.log(`mixing ${kGroups} groups at 1920 x 1080, drawn ${moved.drawn} px wide: ` +
  `${(1000 * moved.frames.length / moved.frames.reduce((a, b) => a + b)).toFixed(0)} frames/s; a ` +
  `frame's median ${quantile(moved.frames, 0.5).toFixed(1)} ms, 95th of a hundred ` +
  `${quantile(moved.frames, 0.95).toFixed(1)} ms; the first ${moved.first.toFixed(0)} ms; script ` +
  `${moved.script_ms.toFixed(1)} ms`);
await all.close();
process.exit(0);
