// Live over the stage: frames follow mouse, touch and keys, switches and a second view, a light
// switched off, a job of what is seen, a job's picture that is pulled, a server without room, and a
// closed page that leaves nothing behind. Leaves screenshots.
import assert from 'node:assert/strict';
import { after, afterEach, before, test } from 'node:test';
import { screenshot, start_all, wait_for, wait_for_tiles } from './support.mjs';

let all;
let page;
before(async () => {
  all = await start_all();
  page = await all.browser.page(`${all.server.url}/#scene=cornell-box`);
  await frame_with(page);
});
after(() => all?.close());
afterEach(() => all.browser.expect_no_errors());

// Waits for a frame of this stage, if one is given, that shows a later camera than `after`.
const frame_with = (at, { stage = null, after = -1, session = 'main' } = {}) =>
  wait_for(at, async (wanted) => {
    const frame = (await import('/app.js')).live_gate.live?.[wanted.session]?.frame;
    return Boolean(frame) && frame.camera > wanted.after &&
      [null, frame.stage].includes(wanted.stage);
  }, { stage, after, session });

// What the left canvas shows: means of red, green and blue.
const colour = (at) => at.evaluate(() => {
  const canvas = document.querySelector('.live-left');
  const copy = new OffscreenCanvas(16, 16).getContext('2d');
  copy.drawImage(canvas, 0, 0, 16, 16);
  const { data } = copy.getImageData(0, 0, 16, 16);
  const mean = (k) => data.filter((_, i) => i % 4 === k).reduce((a, b) => a + b, 0) / 256;
  return [mean(0), mean(1), mean(2)];
});
const newest_camera = (at) => at.evaluate(async () =>
  (await import('/app.js')).live_gate.live.main.info.id).then(async (id) =>
  (await all.server.get(`/v1/live/${id}`)).json());

test('the picture is there, and says that it comes to rest', async () => {
  await frame_with(page, { stage: 'settling' });
  await page.locator('.live-label').filter({ hasText: 'at rest' }).waitFor();
  assert.ok((await colour(page)).every((v) => v > 8));
  const [stage, picture, side] = await Promise.all(['.stage', '.live-left', '.live-side']
    .map((part) => page.locator(part).boundingBox()));
  assert.deepEqual(picture, stage); // fills it
  assert.ok(side.x >= stage.x + stage.width, 'measures stand beside the picture');
  await screenshot(page, 'live-1280');
});

test('a drag orbits, the wheel goes nearer, keys fly; the focus stays', async () => {
  const before = (await newest_camera(page)).camera.position;
  const stage = await page.locator('.live-layer').boundingBox();
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

  await page.locator('.live-layer').focus();
  await page.keyboard.down('KeyD');
  await frame_with(page, { after: nearer.camera_number });
  await page.keyboard.up('KeyD');
  const flown = await newest_camera(page);
  assert.notDeepEqual(flown.camera.target, nearer.camera.target);
  assert.equal(await page.evaluate(() => document.activeElement.className), 'live-layer');
  await wait_for(page, async () =>
    Number.isFinite((await import('/app.js')).live_gate.live.main.latency_ms(0.95)));
});

test('switches reach the session', async () => {
  await page.locator('.live-switches [value=recovery]').uncheck();
  await page.waitForFunction(() =>
    document.querySelector('.live-label').textContent.includes('without recovery'));
  assert.equal((await newest_camera(page)).recovery, false);
  await page.locator('.live-switches [value=recovery]').check();
});

test('a second view without what helps stands beside the first', async () => {
  await page.locator('#live-beside').selectOption('all');
  await frame_with(page, { session: 'other' });
  await page.locator('.live-layer').focus();
  await page.keyboard.press('KeyA', { delay: 60 });
  assert.equal(await page.locator('.live-other-label').textContent(), 'without any of them');
  await page.waitForFunction(() => document.querySelectorAll('.live-measures tr:first-child td')
    .length === 2);
  await frame_with(page, { after: 1, session: 'other' });
  const widest = () => document.documentElement.scrollWidth - innerWidth;
  assert.ok(await page.evaluate(widest) <= 0, 'both views\' measures fit');
  await screenshot(page, 'live-split');
  await page.locator('#live-beside').selectOption('');
  await wait_for(page, async () => (await import('/app.js')).live_gate.live.other === null);
});

test('a light switched off is off', async () => {
  await page.locator('.live-lights input').uncheck();
  await page.waitForFunction(() => {
    const copy = new OffscreenCanvas(8, 8).getContext('2d');
    copy.drawImage(document.querySelector('.live-left'), 0, 0, 8, 8);
    return copy.getImageData(0, 0, 8, 8).data.every((v, i) => i % 4 === 3 || v === 0);
  });
  const { request } = await all.server.job(await render()); // the job is dark too
  assert.deepEqual([request.light_groups, request.mix], ['material', '0']);
  await page.goBack(); // and the way back leads to the light as it was
  await frame_with(page);
  assert.equal(await page.locator('.live-lights input').isChecked(), false);
  await page.locator('.live-lights input').check();
});

// Resolves to the id of the job that is shown then.
async function render() {
  await page.locator('.live-render').click();
  await page.waitForFunction(() => location.hash.includes('job='));
  return shown_of(page).get('job');
}
const shown_of = (at) => new URLSearchParams(new URL(at.url()).hash.slice(1));

// Of the box, which is .56 m deep and open towards the camera.
test('a wall stops the camera, and one key lets it through', async () => {
  await page.locator('.live-layer').focus();
  await page.locator('.live-walls').uncheck();
  const step = (z) => page.evaluate(async (depth) => {
    const { camera } = (await import('/app.js')).live_gate.live;
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
  await page.locator('.live-walls').check();
  await step(2);
  const stopped = await until((z) => z > 0.21);
  assert.ok(stopped > 0.5 && stopped < 0.56, `stopped at ${stopped}`);
  await wait_for(page, async () => {
    const { camera } = (await import('/app.js')).live_gate.live.camera;
    return camera.position[2] < 0.56;
  });
  await page.locator('.live-layer').press('g');
  assert.equal(await page.locator('.live-walls').isChecked(), false);
  await step(2);
  await until((z) => z > 1.9);
  await page.locator('.live-home').click();
  await page.locator('.live-walls').check();
});

test('a job renders the view, and shows it in the place of the live one', async () => {
  const { id: session, camera } = await newest_camera(page);
  const { request } = await all.server.job(await render());
  request.camera.position.forEach((v, i) => assert.ok(Math.abs(v - camera.position[i]) < 1e-4));
  await wait_for_tiles(page, 0);
  assert.equal(await page.locator('.live-layer').isVisible(), false);
  await ended(session);
  await page.goBack();
  await frame_with(page);
});

const ended = async (session) => {
  while ((await fetch(`${all.server.url}/v1/live/${session}`)).status !== 404)
    await new Promise((resolve) => setTimeout(resolve, 50));
};
const pull = async (at, dx) => {
  const stage = await at.locator('.stage').boundingBox();
  const [x, y] = [stage.x + stage.width / 2, stage.y + stage.height / 2];
  await at.mouse.move(x, y);
  await at.mouse.down();
  await at.mouse.move(x + dx, y, { steps: 8 });
  await at.mouse.up();
};

test('the picture of a job, pulled, is live; it stays until the first frame', async () => {
  const camera = { position: [0.3, 0.27, -0.6], target: [0.278, 0.27, 0.28] };
  const id = await all.server.post({ scene: 'cornell-box', width: 96, height: 96, samples: 2,
    method: 'none', camera });
  await all.server.wait_until(id, ({ state }) => state === 'succeeded');
  const other = await all.browser.page(`${all.server.url}/#job=${id}`);
  await wait_for_tiles(other, 0);
  await other.evaluate(() => { // what is seen below the layer until it is there
    globalThis.seen = [];
    const layer = document.querySelector('.live-layer');
    new MutationObserver(() => globalThis.seen.push(layer.hidden))
      .observe(layer, { attributes: true, attributeFilter: ['hidden'] });
  });
  await pull(other, 60);
  assert.equal(await other.locator('.pane canvas.picture').first().isVisible(), true);
  await frame_with(other);
  await other.locator('.live-layer').waitFor();
  assert.deepEqual(await other.evaluate(() => globalThis.seen.filter((is) => !is)), [false]);
  const turned = async () => {
    const { id: session, camera: seen } = await newest_camera(other);
    return [session, seen.position];
  };
  await other.waitForFunction(() => /live=[^o]/.test(location.hash));
  const [, position] = await turned();
  const distance = (a, b) => Math.hypot(...a.map((v, i) => v - b[i]));
  assert.ok(Math.abs(distance(position, camera.target) - distance(camera.position, camera.target))
    < 1e-3, 'it orbits the target of the job\'s camera');
  assert.ok(distance(position, camera.position) > 0.1);
  await screenshot(other, 'live-job-1280');

  await other.reload(); // a link of the view
  await frame_with(other);
  await other.locator('.live-layer').waitFor();
  const [session, again] = await turned();
  assert.ok(distance(again, position) < 1e-3, `${again} for ${position}`);
  await other.locator('.live-layer').press('Escape');
  await other.locator('.live-layer').waitFor({ state: 'hidden' });
  assert.deepEqual([...shown_of(other).keys()], ['job']);
  assert.equal(await other.evaluate(() => document.activeElement.className),
    'live-toggle quiet');
  await ended(session);
  await other.context().close();
});

test('a finger that drags the picture to the side turns it, live', async () => {
  const id = await all.server.post({ scene: 'cornell-box', width: 96, height: 96, samples: 2,
    method: 'none' });
  await all.server.wait_until(id, ({ state }) => state === 'succeeded');
  const phone = await all.browser.page(`${all.server.url}/#job=${id}`, { width: 390, height: 844,
    hasTouch: true, isMobile: true });
  await wait_for_tiles(phone, 0);
  const box = await phone.locator('.stage').boundingBox();
  const session = await phone.context().newCDPSession(phone);
  const touch = (type, ...touchPoints) =>
    session.send('Input.dispatchTouchEvent', { type, touchPoints });
  const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
  await touch('touchStart', { x, y });
  for (let dx = 4; dx <= 80; dx += 4) await touch('touchMove', { x: x + dx, y });
  await touch('touchEnd');
  await phone.locator('.live-layer').waitFor();
  await phone.waitForFunction(() => /live=[^o&]/.test(location.hash)); // the camera has turned
  await phone.context().close();
});

test('a server without room says so, and the picture of the job stays', async () => {
  const full = await start_all({ more: ['--live-sessions', '1'] });
  try {
    const id = await full.server.post({ scene: 'cornell-box', width: 96, height: 96, samples: 2,
      method: 'none' });
    await full.server.wait_until(id, ({ state }) => state === 'succeeded');
    await fetch(`${full.server.url}/v1/live`, { method: 'POST',
      headers: { 'content-type': 'application/json' },
      body: JSON.stringify({ scene: 'cornell-box', width: 64, height: 64 }) });
    const other = await full.browser.page(`${full.server.url}/#job=${id}`);
    await wait_for_tiles(other, 0);
    await pull(other, 60);
    await other.locator('.live-status').filter({ hasText: 'no room for a live view' }).waitFor();
    assert.equal(await other.locator('.pane canvas.picture').first().isVisible(), true);
    assert.equal(await other.locator('.live-layer').isVisible(), false);
    assert.deepEqual([...shown_of(other).keys()], ['job']);
    await screenshot(other, 'live-refused');
    full.browser.expect_no_errors();
  } finally {
    await full.close();
  }
});

test('a link of when it was a page of its own still leads to the scene', async () => {
  const old = await all.browser.page(`${all.server.url}/live.html#scene=cornell-box`);
  assert.equal(new URL(old.url()).pathname, '/');
  await frame_with(old);
  await old.context().close();
});

test('a camera that is kept is there again, until it is forgotten', async () => {
  await page.locator('.live-layer').press('Shift+ArrowLeft', { delay: 80 });
  await page.waitForFunction(() => /live=[^o]/.test(location.hash));
  let kept, before;
  do {  // the server hears of a key after the page
    before = kept;
    await page.waitForTimeout(200);
    kept = (await newest_camera(page)).camera.position;
  } while (String(kept) !== String(before));
  page.once('dialog', (dialog) => dialog.accept('by the wall'));
  await page.locator('.live-keep').click();
  await page.locator('.live-home').click();
  const near = async (to, is) => {
    for (;;) {
      const { position } = (await newest_camera(page)).camera;
      if (Math.hypot(...position.map((v, i) => v - to[i])) < 1e-3 === is) return;
      await page.waitForTimeout(50);
    }
  };
  await near(kept, false);
  await page.reload();
  await frame_with(page);
  await page.locator('.live-camera').selectOption('by the wall');
  await near(kept, true);
  await page.locator('.live-forget').click();
  assert.equal(await page.locator('.live-camera-tool').isVisible(), false);
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
  const phone = await all.browser.page(`${all.server.url}/#scene=cornell-box`,
    { width: 390, height: 844, hasTouch: true, colorScheme: 'dark' });
  await frame_with(phone);
  await phone.locator('.live-layer').waitFor();
  const widest = await phone.evaluate(() => document.documentElement.scrollWidth);
  assert.ok(widest <= 390, `${widest} px wide`);
  await screenshot(phone, 'live-390');
  await phone.close();
});

test('over a line that is too slow for HDR, frames come as JPEG and look the same', async () => {
  const far = await all.browser.page(`${all.server.url}/#scene=cornell-box`);
  await frame_with(far, { stage: 'settling' });
  const before = await colour(far);
  const line = await far.context().newCDPSession(far);
  await line.send('Network.enable');
  await line.send('Network.emulateNetworkConditions', { offline: false, latency: 5,
    downloadThroughput: 2_000_000, uploadThroughput: 2_000_000 });
  await far.reload(); // streams that are open already stay fast
  const state = () => far.evaluate(async () => {
    const main = (await import('/app.js')).live_gate.live?.main;
    return { received: main.received, number: main.frame.number };
  });
  const is_jpeg = async (number) => {
    const main = (await import('/app.js')).live_gate.live?.main;
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
  await ended(id);
});
