// How fast the live view is, in a real browser on this machine:
//   QRAYD=build/release/bin/qrayd QRAY_E2E_DIR=build/release/e2e node tests/bench/live_page.mjs \
//     [scene] [seconds]
// flies for `seconds`, a camera each animation frame, and prints frames a second, and the time from
// a camera's change to its frame on the screen.
import { start_all, wait_for } from '../e2e/support.mjs';

const [scene = 'thesis-room', seconds = '10'] = process.argv.slice(2);
const all = await start_all();
try {
  const page = await all.browser.page(`${all.server.url}/#scene=${scene}`);
  await wait_for(page, async () => Boolean((await import('/app.js')).live_gate.live?.main?.frame));
  const measured = await page.evaluate(async (time_ms) => {
    const { live } = (await import('/app.js')).live_gate;
    const { camera } = live;
    const begin = { frames: live.main.frame.number, at: performance.now() };
    let shown = 0;
    let last = live.main.frame;
    const sums = {};
    let side = 0;
    await new Promise((resolve) => {
      const fly = () => {
        const now = performance.now() - begin.at;
        if (now > time_ms) return resolve();
        camera.step([0.01 * Math.cos(now / 1500), 0.003 * Math.sin(now / 900)],
          [0, 0, 0.01 * Math.sin(now / 2000)]);
        if (live.main.frame !== last) {
          last = live.main.frame;
          ++shown;
          side += last.percent;
          for (const [name, ms] of Object.entries(last.ms)) sums[name] = (sums[name] ?? 0) + ms;
        }
        return requestAnimationFrame(fly);
      };
      fly();
    });
    const seconds_flown = (performance.now() - begin.at) / 1000;
    return {
      'rendered/s': (live.main.frame.number - begin.frames) / seconds_flown,
      'shown/s': shown / seconds_flown,
      'latency median ms': live.main.latency_ms(0.5),
      'latency p95 ms': live.main.latency_ms(0.95),
      'rendered at %': side / shown,
      ...Object.fromEntries(Object.entries(sums).map(([name, sum]) => [`${name} ms`, sum / shown])),
    };
  }, Number(seconds) * 1000);
  for (const [name, value] of Object.entries(measured))
    console.log(`${name.padEnd(20)} ${value.toFixed(1)}`);
} finally {
  await all.close();
}
