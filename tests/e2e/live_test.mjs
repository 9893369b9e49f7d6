// The live page: frames follow mouse, touch and keys, switches and a second view, a light switched
// off, a job of what is seen, and a closed page that leaves nothing behind. Leaves screenshots.
import assert from 'node:assert/strict';
import { after, afterEach, before, test } from 'node:test';
import { screenshot, start_all, wait_for } from './support.mjs';

let all;
let page;
before(async () => {
  all = await start_all();
  page = await all.browser.page(`${all.server.url}/live.html#scene=cornell-box`);
  await frame_with(page);
});
after(() => all?.close());
afterEach(() => all.browser.expect_no_errors());

// Waits for a frame of this stage, if one is given, that shows a later camera than `after`.
const frame_with = (at, { stage = null, after = -1, session = 'main' } = {}) =>
  wait_for(at, async (wanted) => {
    const frame = (await import('/live.js')).live[wanted.session]?.frame;
    return Boolean(frame) && frame.camera > wanted.after &&
      [null, frame.stage].includes(wanted.stage);
  }, { stage, after, session });

// What the left canvas shows: means of red, green and blue.
const colour = (at) => at.evaluate(() => {
  const canvas = document.getElementById('left');
  const copy = new OffscreenCanvas(16, 16).getContext('2d');
  copy.drawImage(canvas, 0, 0, 16, 16);
  const { data } = copy.getImageData(0, 0, 16, 16);
  const mean = (k) => data.filter((_, i) => i % 4 === k).reduce((a, b) => a + b, 0) / 256;
  return [mean(0), mean(1), mean(2)];
});
const newest_camera = (at) => at.evaluate(async () => (await import('/live.js')).live.main.info.id)
  .then(async (id) => (await all.server.get(`/v1/live/${id}`)).json());

test('the picture is there, and says that it comes to rest', async () => {
  await frame_with(page, { stage: 'settling' });
  await page.locator('#stage-label').filter({ hasText: 'at rest' }).waitFor();
  assert.ok((await colour(page)).every((v) => v > 8));
  const [stage, picture, side] = await Promise.all(['#stage', '#left', '.live-side']
    .map((part) => page.locator(part).boundingBox()));
  assert.deepEqual(picture, stage); // fills it
  assert.ok(side.x >= stage.x + stage.width, 'measures stand beside the picture');
  await screenshot(page, 'live-1280');
});

test('a drag orbits, the wheel goes nearer, keys fly; the focus stays', async () => {
  const before = (await newest_camera(page)).camera.position;
  const stage = await page.locator('#stage').boundingBox();
  const [x, y] = [stage.x + stage.width / 2, stage.y + stage.height / 2];
  await page.mouse.move(x, y);
  await page.mouse.down();
  await page.mouse.move(x + 40, y + 5, { steps: 4 });
  await page.mouse.up();
  await frame_with(page, { after: 0 });
  const orbited = await newest_camera(page);
  assert.notDeepEqual(orbited.camera.position, before);
  const distance = ({ position, target }) => Math.hypot(...position.map((v, i) => v - target[i]));
  await page.mouse.wheel(0, -100);
  await frame_with(page, { after: orbited.camera_number });
  const nearer = await newest_camera(page);
  assert.ok(distance(nearer.camera) < distance(orbited.camera));

  await page.locator('#stage').focus();
  await page.keyboard.down('KeyD');
  await frame_with(page, { after: nearer.camera_number });
  await page.keyboard.up('KeyD');
  const flown = await newest_camera(page);
  assert.notDeepEqual(flown.camera.target, nearer.camera.target);
  assert.equal(await page.evaluate(() => document.activeElement.id), 'stage');
  await wait_for(page, async () =>
    Number.isFinite((await import('/live.js')).live.main.latency_ms(0.95)));
});

test('switches reach the session', async () => {
  await page.locator('#recovery').uncheck();
  await page.waitForFunction(() =>
    document.getElementById('stage-label').textContent.includes('without recovery'));
  assert.equal((await newest_camera(page)).recovery, false);
  await page.locator('#recovery').check();
});

test('a second view without what helps stands beside the first', async () => {
  await page.locator('#compare').selectOption('all');
  await frame_with(page, { session: 'other' });
  await page.locator('#stage').focus();
  await page.keyboard.press('KeyA', { delay: 60 });
  assert.equal(await page.locator('#other-label').textContent(), 'without any of them');
  await page.waitForFunction(() => document.querySelectorAll('#measures tr:first-child td')
    .length === 2);
  await frame_with(page, { after: 1, session: 'other' });
  const widest = () => document.documentElement.scrollWidth - innerWidth;
  assert.ok(await page.evaluate(widest) <= 0, 'both views\' measures fit');
  await screenshot(page, 'live-split');
  await page.locator('#compare').selectOption('');
  await wait_for(page, async () => (await import('/live.js')).live.other === null);
});

test('a light switched off is off', async () => {
  await page.locator('#lights input').uncheck();
  await page.waitForFunction(() => {
    const copy = new OffscreenCanvas(8, 8).getContext('2d');
    copy.drawImage(document.getElementById('left'), 0, 0, 8, 8);
    return copy.getImageData(0, 0, 8, 8).data.every((v, i) => i % 4 === 3 || v === 0);
  });
  await page.locator('#render').click(); // the job is dark too
  await page.locator('#rendered a').waitFor();
  const { request } = await all.server.job(await page.locator('#rendered a').textContent());
  assert.deepEqual([request.light_groups, request.mix], ['material', '0']);
  await page.locator('#rendered').evaluate((place) => place.replaceChildren());
  await page.locator('#lights input').check();
});

// Of the box, which is .56 m deep and open towards the camera.
test('a wall stops the camera, and one key lets it through', async () => {
  await page.locator('#stage').focus();
  await page.locator('#walls').uncheck();
  const step = (z) => page.evaluate(async (depth) => {
    const { camera } = await import('/live.js');
    const position = [0.2, 0.45, depth];
    camera.go_to({ ...camera.camera, position, target: [0.2, 0.45, depth + 1] });
  }, z);
  const depth = async () => (await newest_camera(page)).camera.position[2];
  const until = async (good) => {
    for (;;) {
      const z = await depth();
      if (good(z)) return z;
      await page.waitForTimeout(50);
    }
  };
  await step(0.2);
  await until((z) => Math.abs(z - 0.2) < 1e-3);
  await page.locator('#walls').check();
  await step(2);
  const stopped = await until((z) => z > 0.21);
  assert.ok(stopped > 0.5 && stopped < 0.56, `stopped at ${stopped}`);
  await wait_for(page, async () => (await import('/live.js')).camera.camera.position[2] < 0.56);
  await page.locator('#stage').press('g');
  assert.equal(await page.locator('#walls').isChecked(), false);
  await step(2);
  await until((z) => z > 1.9);
  await page.locator('#home').click();
  await page.locator('#walls').check();
});

test('a job renders the view', async () => {
  await page.locator('#render').click();
  const link = page.locator('#rendered a');
  await link.waitFor();
  const id = await link.textContent();
  const { request } = await all.server.job(id);
  const { camera } = await newest_camera(page);
  request.camera.position.forEach((v, i) => assert.ok(Math.abs(v - camera.position[i]) < 1e-4));
});

test('an equirectangular picture is looked around in', async () => {
  const id = await all.server.post({ scene: 'cornell-box', width: 256, height: 128, samples: 4,
    method: 'none',
    camera: { position: [0.278, 0.45, 0.28], target: [0.278, 0.45, 1],
      projection: 'equirectangular' } });
  await all.server.wait_until(id, ({ state }) => state === 'succeeded');
  const around = await all.browser.page(`${all.server.url}/#job=${id}`);
  await around.locator('.panel-around').first().click();
  // Of the middle. The page's own call must be the one that makes the canvas' context.
  const middle = () => around.evaluate(() => {
    const canvas = document.getElementById('picture');
    if (!canvas) return [0, 0, 0];
    const copy = new OffscreenCanvas(1, 1).getContext('2d');
    copy.drawImage(canvas, canvas.width / 2 - 4, canvas.height / 2 - 4, 8, 8, 0, 0, 1, 1);
    return [...copy.getImageData(0, 0, 1, 1).data];
  });
  await around.waitForURL(/around/);
  for (let tries = 0; tries < 600 && (await middle())[0] <= 8; ++tries)
    await around.waitForTimeout(100);
  // The left wall is red, the right one green.
  const stage = await around.locator('#stage').boundingBox();
  const drag = async (dx) => {
    const [x, y] = [stage.x + stage.width / 2 - dx / 2, stage.y + stage.height / 2];
    await around.mouse.move(x, y);
    await around.mouse.down();
    await around.mouse.move(x + dx, y, { steps: 4 });
    await around.mouse.up();
  };
  const quarter = Math.PI / 2 / 1.2 * stage.height;
  await drag(quarter / 2);
  await drag(quarter / 2);
  const [red, green] = await middle();
  await screenshot(around, 'around');
  assert.ok(red > 2 * green, `left: ${red} ${green}`);
  for (let i = 0; i < 4; ++i) await drag(-quarter / 2);
  const [less_red, more_green] = await middle();
  assert.ok(more_green > less_red, `right: ${less_red} ${more_green}`);
  await around.close();
});

test('nothing scrolls sideways on a phone, where a finger orbits', async () => {
  const phone = await all.browser.page(`${all.server.url}/live.html#scene=cornell-box`,
    { width: 390, height: 844, hasTouch: true, colorScheme: 'dark' });
  await frame_with(phone);
  await phone.locator('#waiting').waitFor({ state: 'hidden' });
  const widest = await phone.evaluate(() => document.documentElement.scrollWidth);
  assert.ok(widest <= 390, `${widest} px wide`);
  await screenshot(phone, 'live-390');
  await phone.close();
});

test('over a line that is too slow for HDR, frames come as JPEG and look the same', async () => {
  const far = await all.browser.page(`${all.server.url}/live.html#scene=cornell-box`);
  await frame_with(far, { stage: 'settling' });
  const before = await colour(far);
  const line = await far.context().newCDPSession(far);
  await line.send('Network.enable');
  await line.send('Network.emulateNetworkConditions', { offline: false, latency: 5,
    downloadThroughput: 2_000_000, uploadThroughput: 2_000_000 });
  await far.reload(); // streams that are open already stay fast
  const state = () => far.evaluate(async () => {
    const { main } = (await import('/live.js')).live;
    return { received: main.received, number: main.frame.number };
  });
  const is_jpeg = async (number) => {
    const { main } = (await import('/live.js')).live;
    return main?.encoding === 'jpeg' && main.frame?.encoding === 'jpeg' &&
      main.frame.number >= number;
  };
  await wait_for(far, is_jpeg, 0);
  const first = await state();
  await wait_for(far, is_jpeg, first.number + 4);
  const last = await state();
  const frame_bytes = (last.received - first.received) / (last.number - first.number);
  assert.ok(frame_bytes < 250_000, `${frame_bytes} bytes a frame: 2 MB/s are 8 frames`);
  await frame_with(far, { stage: 'settling' });
  (await colour(far)).forEach((value, channel) =>
    assert.ok(Math.abs(value - before[channel]) < 8, `${value} for ${before[channel]}`));
  await far.context().close();
});

test('a closed page leaves no session', async () => {
  const { id } = await newest_camera(page);
  await page.close();
  for (;;) {
    const answer = await fetch(`${all.server.url}/v1/live/${id}`);
    if (answer.status === 404) break;
    await new Promise((resolve) => setTimeout(resolve, 50));
  }
});
