// Groups of lights on the page: sliders that change the picture at once, the mix in the address and
// in the downloads, and a job that is lit so.
import assert from 'node:assert/strict';
import { after, afterEach, before, test } from 'node:test';
import { screenshot, start_all } from './support.mjs';

const kJob = { scene: 'studio', method: 'none', samples: 8, width: 96, height: 72,
  light_groups: 'scene' };
const kGroups = 6;
let all;
let page;
let job;
before(async () => {
  all = await start_all();
  job = await all.server.post(kJob);
  await all.server.wait_until(job, ({ state }) => state === 'succeeded');
  page = await all.browser.page(`${all.server.url}/#job=${job}`);
  await page.locator('#mixer summary').click();
  await page.locator('.mixer-groups li').nth(kGroups - 1).waitFor();
});
after(() => all?.close());
afterEach(() => all.browser.expect_no_errors());

// What the stage draws: RGBA bytes, and the radiance of a pixel in the middle.
const drawn = () => page.evaluate(async () => {
  const { viewer } = await import('/app.js');
  const [picture] = viewer.pictures;
  return { bytes: [...picture.read_pixels()], middle: picture.radiance(48, 36) };
});
const row = (n) => page.locator('.mixer-groups li').nth(n);
const slide = (n, stops) => row(n).locator('[type=range]').evaluate((input, value) => {
  input.value = value;
  input.dispatchEvent(new Event('input', { bubbles: true }));
}, stops);
const settled = (test_of, value) => page.waitForFunction(test_of, value);
const mix_of = async () => decodeURIComponent(new URLSearchParams(
  new URL(page.url()).hash.slice(1)).get('mix') ?? '');
const groups_there = () => settled(async () => {
  const { viewer } = await import('/app.js');
  return viewer.pictures[0].groups_came;
});

test('each group has a switch, a slider and a colour with a name', async () => {
  const { groups } = await (await all.server.get(`/v1/jobs/${job}/light-groups`)).json();
  assert.equal(groups.length, kGroups);
  const names = await page.locator('.mixer-groups label').allTextContents();
  assert.deepEqual(names, groups);
  await screenshot(page, 'mix-1280');
});

test('a mix of the lights is the picture that the server makes of it', async () => {
  const before = await drawn();
  await slide(0, 2);
  await row(1).locator('[type=checkbox]').uncheck();
  assert.equal(await mix_of(), '4;0;1;1;1;1');
  await groups_there();
  const after = await drawn();
  assert.notDeepEqual(after.bytes, before.bytes);
  const png = await (await all.server.get(`/v1/jobs/${job}/image.png?mix=4;0;1;1;1;1`))
    .arrayBuffer();
  const from_server = await page.evaluate(async (numbers) => {
    const bitmap = await createImageBitmap(new Blob([new Uint8Array(numbers)]));
    const canvas = new OffscreenCanvas(bitmap.width, bitmap.height);
    const context = canvas.getContext('2d');
    context.drawImage(bitmap, 0, 0);
    return [...context.getImageData(0, 0, bitmap.width, bitmap.height).data];
  }, [...new Uint8Array(png)]);
  // RGB9E5 has 9 bits a channel of the greatest.
  const far = after.bytes.filter((v, i) => Math.abs(v - from_server[i]) > 4).length;
  assert.ok(far < after.bytes.length / 200, `${far} of ${after.bytes.length} bytes differ`);
});

test('while a slider moves a large picture is drawn as it is shown, then in full', async () => {
  const large = await all.server.post({ ...kJob, samples: 1, width: 1024, height: 768 });
  await all.server.wait_until(large, ({ state }) => state === 'succeeded');
  const mix = '1;1;1;1;1;4';
  await page.goto('about:blank');
  await page.goto(`${all.server.url}/#job=${large}&mix=${encodeURIComponent(mix)}`);
  await row(kGroups - 1).waitFor();
  await groups_there();
  // Laid out beside its panel, where a pixel of the screen shows two of the picture a side.
  await settled(() =>
    Math.round(1024 / document.querySelector('canvas.picture').clientWidth) === 2);
  const moving = await page.evaluate(async (places) => {
    const { viewer } = await import('/app.js'); // no tile comes from what is drawn to what is read
    const canvas = document.querySelector('canvas.picture');
    const slider = document.querySelectorAll('.mixer-groups [type=range]')[5];
    for (let moves = 0; moves === 0 || (canvas.width !== 512 && moves < 20); ++moves) {
      slider.value = 1 + moves / 10;
      slider.dispatchEvent(new Event('input', { bubbles: true }));
      await new Promise(requestAnimationFrame); // the viewer's own comes first
    }
    const copy = new OffscreenCanvas(canvas.width, canvas.height).getContext('2d');
    copy.drawImage(canvas, 0, 0);
    return { width: canvas.width, pixels: places.map(([x, y]) => ({
      drawn: [...copy.getImageData(x, y, 1, 1).data.subarray(0, 3)],
      texels: [[0, 0], [1, 0], [0, 1], [1, 1]].map(([dx, dy]) =>
        viewer.pictures[0].radiance(2 * x + dx, 2 * y + dy)) })) };
  }, Array.from({ length: 24 }, (_, i) => [20 * i + 11, 15 * i + 9]));
  assert.equal(moving.width, 512);
  for (const { drawn: shown, texels } of moving.pixels) {
    shown.forEach((value, channel) => {
      const mean = texels.reduce((sum, texel) => sum + texel[channel], 0) / 4;
      const v = Math.min(mean, 1);
      const expected = 255 * (v <= 0.0031308 ? 12.92 * v : 1.055 * v ** (1 / 2.4) - 0.055);
      assert.ok(Math.abs(value - expected) <= 1, `${value} for ${expected}`);
    });
  }
  await settled(() => document.querySelector('canvas.picture').width === 1024);
  await page.goto('about:blank');
  await page.goto(`${all.server.url}/#job=${job}&mix=${encodeURIComponent('4;0;1;1;1;1')}`);
  await row(kGroups - 1).waitFor();
  await groups_there();
});

test('the readout and the downloads are of the mix', async () => {
  const href = await page.locator('.panel-exr').first().getAttribute('href');
  assert.match(decodeURIComponent(href), /mix=4;0;1;1;1;1/);
  const { middle } = await drawn();
  for (let n = 0; n < kGroups; ++n) await slide(n, n === 1 ? 0 : 3);
  const { middle: brighter } = await drawn();
  assert.ok(brighter[0] > middle[0], `${brighter} over ${middle}`);
  await page.goto(`${all.server.url}/#job=${job}&mix=8;0;1;1;1;1`);
});

test('a colour tints a group, and what is switched off keeps it', async () => {
  await row(2).locator('[type=color]').fill('#ff8000');
  assert.match(await mix_of(), /^8;0;1,0\.2\d+,0;/);
  await row(2).locator('[type=checkbox]').uncheck();
  assert.match(await mix_of(), /^8;0;0;/);
  await row(2).locator('[type=checkbox]').check();
  assert.match(await mix_of(), /^8;0;1,0\.2\d+,0;/);
});

test('the address brings the mix back', async () => {
  await page.goto('about:blank');
  await page.goto(`${all.server.url}/#job=${job}&mix=${encodeURIComponent('1;0;0.5;1;1;2,1,1')}`);
  await row(kGroups - 1).waitFor();
  await groups_there();
  assert.equal(await row(1).locator('[type=checkbox]').isChecked(), false);
  assert.equal(await row(2).locator('[type=range]').inputValue(), '-1');
  assert.equal(await row(5).locator('[type=range]').inputValue(), '1');
});

test('the lights as rendered come back by a button', async () => {
  await page.locator('.mixer-reset').click();
  assert.equal(await mix_of(), '');
  assert.equal(await row(1).locator('[type=checkbox]').isChecked(), true);
});

test('a new job is lit by the mix', async () => {
  await slide(0, -2);
  await page.locator('.mixer-post').click();
  await page.waitForFunction((old) => !location.hash.includes(old), job);
  const id = new URLSearchParams(new URL(page.url()).hash.slice(1)).get('job');
  const lit = await all.server.wait_until(id, ({ state }) => state === 'succeeded');
  assert.equal(lit.request.mix, '0.25;1;1;1;1;1');
});

test('the sliders fit on a phone', async () => {
  await page.setViewportSize({ width: 390, height: 844 });
  await page.goto('about:blank');
  await page.goto(`${all.server.url}/#job=${job}&mix=2;1;1;1;1;1`);
  await page.locator('.mixer-groups li').first().waitFor();
  assert.equal(await page.evaluate(() => document.documentElement.scrollWidth), 390);
  await screenshot(page, 'mix-390');
});
