// Where the page is stands in its address: zoom, centre, curves, the inspected pixel. Zoom and pan
// by mouse and keyboard, the numbers of close pixels, and the curves' colours.
import assert from 'node:assert/strict';
import { after, afterEach, before, test } from 'node:test';
import { display_values } from './rgb9e5.mjs';
import { canvas_pixels, screenshot, Server, start_all, wait_for_tiles } from './support.mjs';

const kSide = 64;
let all;
let page;
let job;
let tiles;
before(async () => {
  all = await start_all();
  job = await all.server.post({ scene: 'cornell-box', method: 'none', samples: 8, width: kSide,
    height: kSide });
  await all.server.wait_until(job, ({ state }) => state === 'succeeded');
  page = await all.browser.page(`${all.server.url}/#job=${job}`);
  await wait_for_tiles(page, 0);
  const answer = await all.server.get(`/v1/jobs/${job}/tiles?since=0`);
  tiles = display_values(await answer.arrayBuffer()).linear;
});
after(() => all?.close());
afterEach(() => all.browser.expect_no_errors());

const hash_has = (text) => page.waitForFunction((part) => location.hash.includes(part), text);
const zoom = (of = page) => of.locator('.view-zoom-value').textContent();
// What is shown at so many times the size that fits.
const times = async (factor, of = page) => {
  const { width } = await of.locator('.pane.left').boundingBox();
  return `${Math.round(100 * factor * width / kSide)}\u00a0%`;
};
const sheet = () => page.locator('.pane.left .sheet').evaluate((one) =>
  getComputedStyle(one).transform);

test('keys zoom, a drag moves the picture, and a reload shows the same part', async () => {
  await page.locator('.stage').focus();
  await page.keyboard.press('+');
  await page.keyboard.press('+');
  assert.equal(await zoom(), await times(4));
  await hash_has('zoom=4&cx=');
  const address = await page.evaluate(() => location.hash);
  const before_drag = await sheet();
  const box = await page.locator('.stage').boundingBox();
  const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
  await page.mouse.move(x, y);
  await page.mouse.down();
  await page.mouse.move(x + 40, y + 20, { steps: 4 });
  await page.mouse.up();
  assert.notEqual(await sheet(), before_drag);
  await page.waitForFunction((old) => location.hash !== old, address);
  const here = await sheet();
  await page.reload();
  await wait_for_tiles(page, 0);
  assert.equal(await zoom(), await times(4));
  const numbers = (text) => text.match(/-?[\d.]+/g).map(Number);
  numbers(await sheet()).forEach((v, i) => assert.ok(Math.abs(v - numbers(here)[i]) < 1,
    `${i}: ${v} against ${numbers(here)[i]}`));
});

test('the part that is seen is rendered first, by a job of its own', async () => {
  assert.equal(await zoom(), await times(4));
  await page.locator('#part-first').click();
  await page.waitForFunction((old) => !location.hash.includes(`job=${old}`), job);
  const first = new URLSearchParams(new URL(page.url()).hash.slice(1)).get('job');
  const { request } = await all.server.job(first);
  const { x, y, width, height } = request.region;
  for (const side of [width, height]) assert.ok(side >= kSide / 4 && side <= kSide / 4 + 2, side);
  assert.ok(x >= 0 && x + width <= kSide && y >= 0 && y + height <= kSide, `${x} ${y}`);
  assert.equal(request.samples, 8);
  await all.server.wait_until(first, ({ state }) => state === 'succeeded');
  await page.locator('.panel-facts').filter({ hasText: `${width} × ${height} pixels, ${x} from` })
    .waitFor();
  await page.getByRole('button', { name: 'Fit' }).click();
  assert.ok(await page.locator('#part-first').isDisabled()); // the part is all of it
  await page.goto(`${all.server.url}/#job=${job}`);
  await wait_for_tiles(page, 0);
});

test('pixels that are close wear their numbers', async () => {
  const ink = () => page.locator('.pane.left .marks').evaluate((canvas) => {
    const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
    return data.filter((_, i) => i % 4 === 3 && data[i] > 0).length;
  });
  assert.equal(await ink(), 0);
  await page.locator('.stage').focus();
  for (let i = 0; i < 4; ++i) await page.keyboard.press('+');
  await page.waitForFunction(() => document.querySelector('.pane.left .marks').width > 1);
  assert.ok(await ink() > 500);
  await screenshot(page, 'numbers-1280');
  await page.getByRole('button', { name: 'Fit' }).click();
  await page.waitForFunction(() => document.querySelector('.pane.left .marks').width === 1);
});

test('the wheel zooms at once; where the whole picture is seen it scrolls back', async () => {
  await page.evaluate(() => document.activeElement.blur());
  await page.getByRole('button', { name: 'Fit' }).click();
  const whole = await zoom();
  const box = await page.locator('.stage').boundingBox();
  await page.mouse.move(box.x + 30, box.y + 30);
  await page.mouse.wheel(0, -240);
  await page.waitForFunction((text) =>
    document.querySelector('.view-zoom-value').textContent !== text, whole);
  assert.equal(parseInt(await zoom(), 10), 2 * parseInt(whole, 10));
  await page.mouse.wheel(0, 240);
  await page.waitForFunction((text) =>
    document.querySelector('.view-zoom-value').textContent === text, whole);
  const at = () => page.evaluate(() => document.getElementById('picture-pane').scrollTop);
  assert.equal(await at(), 0);
  await page.mouse.wheel(0, 60);
  await page.waitForFunction(() => document.getElementById('picture-pane').scrollTop > 0);
  assert.equal(await zoom(), whole);
  await page.evaluate(() => document.getElementById('picture-pane').scrollTo(0, 0));
});

// The curves again, from the tiles and the published formulas.
const srgb = (v) => (v <= 0.0031308 ? 12.92 * v : 1.055 * v ** (1 / 2.4) - 0.055);
const clamp = (v) => Math.min(Math.max(v, 0), 1);
const kCurves = {
  srgb: (v) => srgb(clamp(v)),
  gamma: (v) => clamp(v) ** (1 / 1.8),
  filmic: (v) => srgb(clamp(v * (2.51 * v + 0.03) / (v * (2.43 * v + 0.59) + 0.14))),
};

test('the curves are what their formulas say', async () => {
  for (const [name, curve] of Object.entries(kCurves)) {
    await page.locator('#curve').selectOption(name);
    if (name === 'gamma') await page.locator('#gamma').fill('1.8');
    const shown = await canvas_pixels(page, 0);
    for (let i = 0; i < kSide * kSide; ++i) {
      for (let c = 0; c < 3; ++c) {
        const expected = 255 * curve(tiles[3 * i + c]);
        assert.ok(Math.abs(shown[4 * i + c] - expected) <= 1.01,
          `${name}, pixel ${i}, channel ${c}: ${shown[4 * i + c]}, expected ${expected}`);
      }
    }
  }
});

test('false colour rises with luminance, and says what its colours mean', async () => {
  await page.locator('#curve').selectOption('false');
  await page.locator('.view-false-scale').waitFor();
  assert.match(await page.locator('.view-false-scale').innerText(), /Luminance\s+0\.0039\s+16/);
  const shown = await canvas_pixels(page, 0);
  const pixels = Array.from({ length: kSide * kSide }, (_, i) => {
    const [r, g, b] = tiles.subarray(3 * i, 3 * i + 3);
    const lightness = 0.2126 * shown[4 * i] + 0.7152 * shown[4 * i + 1] + 0.0722 * shown[4 * i + 2];
    return [0.2126 * r + 0.7152 * g + 0.0722 * b, lightness];
  }).sort((a, b) => a[0] - b[0]);
  pixels.forEach(([, lightness], i) =>
    i && assert.ok(lightness >= pixels[i - 1][1] - 1.5, `${pixels[i - 1]} and ${pixels[i]}`));
  await screenshot(page, 'false-colour-1280');
});

test('a link restores the whole view', async () => {
  const hash = `#job=${job}&ev=1.5&curve=filmic&zoom=3&cx=4000&cy=6000&at=10,20`;
  const other = await all.browser.page(all.server.url + '/' + hash);
  await wait_for_tiles(other, 0);
  assert.equal(await other.locator('#exposure').inputValue(), '1.5');
  assert.equal(await other.locator('#curve').inputValue(), 'filmic');
  assert.equal(await zoom(other), await times(3, other));
  assert.equal(await other.locator('#pixel-x').inputValue(), '10');
  assert.equal(await other.locator('#pixel-y').inputValue(), '20');
  assert.equal(await other.evaluate(() => location.hash), hash);
  await other.context().grantPermissions(['clipboard-read', 'clipboard-write']);
  await other.getByRole('button', { name: 'Copy link' }).click();
  await other.locator('#share-status').filter({ hasText: 'Copied.' }).waitFor();
  assert.equal(await other.evaluate(() => navigator.clipboard.readText()),
    all.server.url + '/' + hash);
  await other.context().close();
});

test('keys are listed by ?, and can be switched off', async () => {
  await page.locator('.stage').focus();
  await page.keyboard.press('?');
  await page.locator('#keys[open]').waitFor();
  assert.ok(await page.locator('#keys dt').count() >= 10);
  await screenshot(page, 'keys-1280');
  await page.locator('#keys input[type=checkbox]').uncheck();
  await page.keyboard.press('Escape');
  await page.locator('.stage').focus();
  await page.keyboard.press('c');
  assert.equal(await page.locator('#curve').inputValue(), 'false');
  await page.locator('#show-keys').click();
  await page.locator('#keys input[type=checkbox]').check();
  await page.getByRole('button', { name: 'Close' }).click();
  await page.locator('.stage').focus();
  await page.keyboard.press('c');
  await hash_has('job=');
  assert.equal(await page.locator('#curve').inputValue(), 'srgb');
  await page.locator('#find').focus(); // typed letters stay letters
  await page.keyboard.press('c');
  assert.equal(await page.locator('#curve').inputValue(), 'srgb');
});

test('a server that starts again finds the page where it was', async () => {
  const hash = `#job=${job}&ev=1&zoom=2&cx=4000&cy=6000&at=10,20`;
  await page.goto(`${all.server.url}/${hash}`);
  await page.reload();
  await wait_for_tiles(page, 0);
  const shown = await canvas_pixels(page, 0);
  const { port } = all.server;
  await all.server.stop();
  await page.locator('#notice').waitFor();
  all.server = await Server.start(all.folder, { port });
  await page.locator('#notice').waitFor({ state: 'hidden' });
  assert.equal(await page.evaluate(() => location.hash), hash);
  assert.equal(await zoom(), await times(2));
  assert.deepEqual(await canvas_pixels(page, 0), shown);
});
