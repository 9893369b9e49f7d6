// A newcomer's first minute: a click on a scene shows it live, a drag turns it, a second click
// renders what is seen. Leaves a screenshot of each step, and tells how long it took.
import assert from 'node:assert/strict';
import { after, afterEach, before, test } from 'node:test';
import { screenshot, start_all, wait_for, wait_for_state, wait_for_tiles } from './support.mjs';

let all;
before(async () => {
  all = await start_all();
});
after(() => all?.close());
afterEach(() => all.browser.expect_no_errors());

test('from an empty page to a picture of one’s own view', async (context) => {
  const page = await all.browser.page(all.server.url, { thumbnails: true });
  await page.locator('.scene-card[data-scene=thesis-room] canvas.drawn').waitFor();
  await screenshot(page, 'minute-1-open');
  const begin = performance.now();
  const seconds = () => ((performance.now() - begin) / 1000).toFixed(1);
  await page.locator('.scene-card[data-scene=thesis-room]').click();
  await page.locator('.live-layer').waitFor();
  const told = [`live after ${seconds()} s`];
  const { position } = await page.evaluate(async () =>
    (await import('/app.js')).live_gate.live.camera.camera);

  const box = await page.locator('.live-layer').boundingBox();
  const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
  await page.mouse.move(x, y);
  await page.mouse.down();
  await page.mouse.move(x - 60, y + 12, { steps: 12 });
  await page.mouse.up();
  await wait_for(page, async () => {
    const { main } = (await import('/app.js')).live_gate.live;
    return main.frame.camera > 3 && main.frame.stage !== 'moving';
  });
  await screenshot(page, 'minute-2-live');
  await page.locator('.live-render').click();
  await page.waitForFunction(() => location.hash.includes('job='));
  const id = new URLSearchParams(new URL(page.url()).hash.slice(1)).get('job');
  await wait_for_tiles(page, 0);
  told.push(`its job's first tiles after ${seconds()} s`);
  await wait_for_state(page, id, 'Done');
  told.push(`done after ${seconds()} s`);
  const { request, stats } = await all.server.job(id);
  assert.ok(stats.recovery, 'it is recovered');
  assert.ok(Math.hypot(...request.camera.position.map((v, i) => v - position[i])) > 0.1);
  await page.locator('.view-divider').waitFor();
  await screenshot(page, 'minute-3-picture');
  context.diagnostic(told.join(', '));
  await page.context().close();
});
