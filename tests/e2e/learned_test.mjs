// The inspected pixel and what was learned behind it: the server's numbers, the states over the
// picture, the lobe on a sphere, as rods in the scene and as a tree of cells, pass by pass.
import assert from 'node:assert/strict';
import { after, afterEach, before, test } from 'node:test';
import { screenshot, start_all, wait_for_same_image, wait_for_tiles } from './support.mjs';

const kJob = { scene: 'thesis-room', width: 128, height: 128, samples: 32 };
let all;
let page;
const jobs = {};
before(async () => {
  all = await start_all();
  for (const method of ['huang', 'adaptive']) {
    jobs[method] = await all.server.post({ ...kJob, method });
    await all.server.wait_until(jobs[method], ({ state }) => state === 'succeeded');
  }
  page = await open('huang');
});
after(() => all?.close());
afterEach(() => all.browser.expect_no_errors());

async function open(method, more = '', options = {}) {
  const shown = await all.browser.page(`${all.server.url}/#job=${jobs[method]}${more}`,
    { height: 2200, ...options });
  await wait_for_tiles(shown, 0);
  return shown;
}
const pixel = async (id, x, y, more = '') =>
  (await all.server.get(`/v1/jobs/${id}/pixel?x=${x}&y=${y}${more}`)).json();
const value = (name, on = page) => on.locator('.pixel-table tr')
  .filter({ has: on.locator('th', { hasText: name }) }).locator('td').first();
const significant = (v, digits = 3) => (v === 0 ? '0' : Math.abs(v) >= 1e5 || Math.abs(v) < 1e-4
  ? v.toExponential(digits - 1) : String(+v.toPrecision(digits)));

test('a click asks for the pixel, and the answer is shown', async () => {
  const box = await page.locator('.stage').boundingBox();
  const at = (share) => (Math.floor(128 * share) + 0.5) / 128;
  await page.mouse.click(box.x + box.width * at(0.5), box.y + box.height * at(0.9));
  await page.locator('.pixel-table').waitFor();
  const expected = await pixel(jobs.huang, 64, 115);
  assert.equal(await page.evaluate(() => location.hash.includes('at=64,115')), true);
  assert.equal(await value('Radiance').textContent(),
    expected.radiance.map((v) => significant(v, 4)).join('  '));
  assert.equal(await value('Samples').textContent(), String(expected.samples));
  if (expected.standard_error !== null) {
    assert.equal(await value('Standard error').textContent(), significant(expected.standard_error));
  }
  assert.equal(await value('Place that learns (state)').textContent(), expected.state.id);
  const told = page.locator('#announcer').filter({ hasText: 'Pixel 64, 115: ' });
  await told.waitFor();
});

test('by keyboard: two fields, or arrows on the picture', async () => {
  await page.locator('#pixel-x').fill('30');
  await page.locator('#pixel-y').fill('100');
  const near = await pixel(jobs.huang, 30, 100);
  await value('Radiance').filter({ hasText: significant(near.radiance[0], 4) }).waitFor();
  await page.locator('.stage').focus();
  await page.keyboard.press('ArrowRight');
  await page.keyboard.press('ArrowUp');
  assert.equal(await page.locator('#pixel-x').inputValue(), '31');
  assert.equal(await page.locator('#pixel-y').inputValue(), '99');
  await page.locator('.pixel-close').click();
  assert.equal(await page.locator('.pixel-table').isVisible(), false);
});

test('the directions of huang are on a sphere and in the scene', async () => {
  const expected = await pixel(jobs.huang, 64, 115);
  const { length } = expected.lobe.directions; // those of the 26 that the surface sees
  assert.ok(length >= 9 && length <= 26, `${length} directions`);
  await page.locator('#pixel-x').fill('64');
  await page.locator('#pixel-y').fill('115');
  const lobe = page.locator(`.lobe[data-job="${jobs.huang}"]`);
  await lobe.locator('figcaption').filter({ hasText: `64, 115: ${length} directions` }).waitFor();
  assert.ok(await lobe.locator('img').evaluate(async (image) => {
    await image.decode();
    return image.naturalWidth > 100;
  }));
  assert.equal(await lobe.locator('.lobe-cells').isVisible(), false);
  const ink = await page.locator('.pane.left .marks').evaluate((canvas) => {
    const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
    return data.filter((v, i) => i % 4 === 3 && v > 0).length;
  });
  assert.ok(ink > 800, `${ink} pixels of rods`);
  await screenshot(page, 'lobe-huang-1280');
});

test('adaptive shows its tree of cells', async () => {
  const other = await open('adaptive', '&at=64,115');
  const expected = await pixel(jobs.adaptive, 64, 115);
  assert.ok(expected.lobe.cells.length >= 1);
  const lobe = other.locator(`.lobe[data-job="${jobs.adaptive}"]`);
  await lobe.locator('figcaption').filter({ hasText: `a tree of ` }).waitFor();
  const colors = await lobe.locator('.lobe-cells').evaluate((canvas) => {
    const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
    const seen = new Set();
    for (let i = 0; i < data.length; i += 4) seen.add(`${data[i]},${data[i + 1]},${data[i + 2]}`);
    return seen.size;
  });
  assert.ok(colors >= Math.min(3, expected.lobe.cells.length), `${colors} colours`);
  await screenshot(other, 'lobe-adaptive-1280');
  await other.context().close();
});

test('states lie over the picture, and the pointer tells their size and visits', async () => {
  await page.locator('#overlay').selectOption('state');
  await page.waitForFunction(() => {
    const image = document.querySelector('.pane.left img.overlay');
    return !image.hidden && image.complete && image.naturalWidth > 0;
  });
  const box = await page.locator('.stage').boundingBox();
  await page.mouse.move(box.x + box.width * 0.5, box.y + box.height * 0.9);
  await page.locator('#readout').filter({ hasText: /place [0-9a-f]{8} · .* m · .* visits/ })
    .waitFor();
  await screenshot(page, 'learned-states-1280');
});

test('samples and variance are views too, with their scale in words', async () => {
  for (const view of ['samples', 'noise']) {
    await page.locator('#overlay').selectOption(view);
    await wait_for_same_image(page, '.pane.left img.overlay',
      `/v1/jobs/${jobs.huang}/view.png?view=${view}`);
    assert.ok((await page.locator('.view-caption').textContent()).length > 5);
  }
  await page.locator('#overlay').selectOption('');
});

test('the lobe is that of the moment that is shown', async () => {
  const { moments } = await (await all.server.get(`/v1/jobs/${jobs.huang}/metrics`)).json();
  const early = moments.find(({ picture, table }) => picture && table);
  assert.ok(early.number < moments.at(-1).number);
  const of_then = await pixel(jobs.huang, 64, 115, `&moment=${early.number}`);
  const of_now = await pixel(jobs.huang, 64, 115);
  const densest = ({ lobe }) => Math.max(...lobe.directions.map(({ pdf_w }) => pdf_w));
  const words = (one) => `${densest(one).toPrecision(3)} per steradian`;
  assert.notEqual(words(of_then), words(of_now));
  const caption = page.locator(`.lobe[data-job="${jobs.huang}"] figcaption`);
  await caption.filter({ hasText: words(of_now) }).waitFor();
  const pictured = moments.filter(({ picture }) => picture);
  await page.locator('#moment').fill(String(pictured.indexOf(early)));
  await caption.filter({ hasText: words(of_then) }).waitFor();
});

test('on a phone nothing scrolls sideways', async () => {
  const phone = await open('huang', '&at=64,115&overlay=state', { width: 390, height: 844 });
  await phone.locator('.lobe figcaption').waitFor();
  assert.equal(await phone.evaluate(() => document.documentElement.scrollWidth), 390);
  await screenshot(phone, 'learned-390');
  await phone.context().close();
});
