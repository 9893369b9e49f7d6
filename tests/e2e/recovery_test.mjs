// A job of a quarter of the pixels: its samples, the recovered picture and the same job with all
// pixels in a row; what marks a recovered picture; refused sizes at their field.
import assert from 'node:assert/strict';
import { after, afterEach, before, test } from 'node:test';
import { canvas_pixels, pictures, post_by_form, screenshot, start_all, unfold, wait_for_state,
  wait_for_tiles } from './support.mjs';

const kSide = 96;
let all;
let page;
let shown;
before(async () => {
  all = await start_all();
  page = await all.browser.page(all.server.url);
});
after(() => all?.close());
afterEach(() => all.browser.expect_no_errors());

const black_pixels = async (index) => {
  const rgba = await canvas_pixels(page, index);
  let black = 0;
  for (let i = 0; i < rgba.length; i += 4) black += rgba[i] + rgba[i + 1] + rgba[i + 2] === 0;
  return black / (rgba.length / 4);
};

test('an odd width is refused at its field', async () => {
  const width = page.locator('#width');
  await unfold(page);
  await page.locator('#pixels').selectOption('quarter');
  await width.fill('95');
  await page.locator('#job-form button[type=submit]').click();
  await page.locator('#width-error').filter({ hasText: /even/ }).waitFor();
  assert.equal(await width.getAttribute('aria-invalid'), 'true');
});

test('samples, recovered picture and all pixels stand in a row', async () => {
  shown = await post_by_form(page, { scene: 'cornell-box', method: 'none', budget: 'samples',
    amount: 8, width: kSide, height: kSide, pixels: 'quarter', recover: 'auto', full: true });
  await wait_for_state(page, shown.job, 'Done');
  await wait_for_state(page, shown.with, 'Done');
  for (const index of [0, 1, 2]) await wait_for_tiles(page, index);
  assert.deepEqual((await pictures(page)).map(({ job }) => job),
    [shown.job, shown.job, shown.with]);
  const labels = await page.locator('.half-label:visible').allTextContents();
  assert.deepEqual(labels, ['no learning · its samples', 'no learning · recovered', 'no learning']);
  assert.ok(await black_pixels(0) >= 0.75);
  assert.ok(await black_pixels(1) < 0.2);
  assert.equal(await page.locator('.view-divider').isVisible(), false);
  const { request } = await all.server.job(shown.with);
  assert.deepEqual([request.pixels, request.recover], ['all', 'none']);
  await screenshot(page, 'recovery-1280');
});

test('a recovered picture is marked, and its samples can be had', async () => {
  const panel = page.locator(`.panel[data-job="${shown.job}"]`);
  assert.equal(await panel.locator('.panel-badge').textContent(), 'recovered');
  assert.ok(await panel.locator('.panel-recovered-note').isVisible());
  assert.equal(await panel.locator('.panel-bias-note').isVisible(), false);
  const [exr, samples] = await Promise.all(['exr', 'samples'].map(async (name) => {
    const link = await panel.locator(`.panel-${name}`).getAttribute('href');
    return (await all.server.get(link)).arrayBuffer();
  }));
  assert.notDeepEqual(new Uint8Array(exr), new Uint8Array(samples));
  const other = page.locator(`.panel[data-job="${shown.with}"]`);
  assert.equal(await other.locator('.panel-badge').isVisible(), false);
  assert.equal(await other.locator('.panel-samples').isVisible(), false);
});

test('alone it is split from its samples, and on a phone nothing scrolls sideways', async () => {
  await page.locator('#compare').selectOption('');
  await page.waitForFunction(() => !location.hash.includes('with='));
  assert.equal(await page.locator('.view-divider').isVisible(), true);
  assert.equal(await page.locator('.panel:visible').count(), 1);
  const address = `${all.server.url}/#job=${shown.job}&with=${shown.with}`;
  const phone = await all.browser.page(address, { width: 390, height: 844 });
  await wait_for_tiles(phone, 2);
  assert.equal(await phone.evaluate(() => document.documentElement.scrollWidth), 390);
  await screenshot(phone, 'recovery-390');
  await phone.context().close();
});
