// Two jobs against each other: flip, side by side with one zoom, equal samples and equal time, maps
// of the difference, and how much brighter a biased method is.
import assert from 'node:assert/strict';
import { after, afterEach, before, test } from 'node:test';
import { screenshot, start_all, wait_for, wait_for_picture, wait_for_same_image,
  wait_for_tiles } from './support.mjs';

const kJob = { scene: 'cornell-box', nee: false, width: 96, height: 96 };
let all;
let page;
let plain;
let published;
before(async () => {
  all = await start_all();
  plain = await all.server.post({ ...kJob, method: 'none', samples: 128 });
  published = await all.server.post({ ...kJob, method: 'huang-published', samples: 32 });
  for (const id of [plain, published]) {
    await all.server.wait_until(id, ({ state }) => state === 'succeeded');
  }
  page = await all.browser.page(`${all.server.url}/#job=${published}&with=${plain}`);
  for (const index of [0, 1]) await wait_for_tiles(page, index);
});
after(() => all?.close());
afterEach(() => all.browser.expect_no_errors());

const seen = (name) => page.locator(`.pane.${name}`)
  .evaluate((pane) => getComputedStyle(pane).visibility === 'visible');
const metrics = async (id, ref = '') =>
  (await all.server.get(`/v1/jobs/${id}/metrics${ref && `?ref=${ref}`}`)).json();
const wait_for_moments = (left, right) => wait_for(page, async ([a, b]) => {
  const { viewer } = await import('/app.js');
  return viewer.pictures[0].moment === a && viewer.pictures[1].moment === b;
}, [left, right]);

test('a biased method says how much brighter it is', async () => {
  const answer = await all.server.get(`/v1/compare?a=${published}&b=${plain}`);
  const { difference } = await answer.json();
  assert.ok(difference.mean_ratio > 1.2, `${difference.mean_ratio}`);
  const words = difference.mean_ratio >= 1.995 ? `${difference.mean_ratio.toPrecision(2)} times`
    : `${(100 * (difference.mean_ratio - 1)).toFixed(0)} % brighter`;
  await page.locator('.view-right-label').filter({ hasText: `biased: ${words}` }).waitFor();
  await page.locator(`.panel[data-job="${published}"] .panel-bias-words`)
    .filter({ hasText: `Here it is ${words}` }).waitFor();
});

test('F flips between the two, and a reload keeps the side', async () => {
  await page.locator('.stage').focus();
  await page.keyboard.press('f');
  assert.deepEqual([await seen('left'), await seen('right')], [false, true]);
  await page.keyboard.press('f');
  assert.deepEqual([await seen('left'), await seen('right')], [true, false]);
  await page.reload();
  await wait_for_tiles(page, 1);
  assert.deepEqual([await seen('left'), await seen('right')], [true, false]);
});

test('side by side, both pictures show the same part', async () => {
  await page.locator('#mode').selectOption('row');
  const boxes = await Promise.all(['left', 'right'].map((name) =>
    page.locator(`.pane.${name}`).boundingBox()));
  assert.ok(boxes[1].x >= boxes[0].x + boxes[0].width);
  await page.locator('.view-zoom-in').click();
  const parts = await Promise.all(['left', 'right'].map((name) =>
    page.locator(`.pane.${name} .sheet`).evaluate((one) => getComputedStyle(one).transform)));
  assert.equal(parts[0], parts[1]);
  assert.match(parts[0], /^matrix\(2, 0, 0, 2,/);
  await screenshot(page, 'side-by-side-1280');
  await page.getByRole('button', { name: 'Fit' }).click();
});

test('at equal samples each shows its moment of as many', async () => {
  await page.locator('#mode').selectOption('split');
  await page.locator('#equal').selectOption('samples');
  const [a, b] = await Promise.all([published, plain].map(async (id) =>
    (await metrics(id)).moments.filter(({ picture }) => picture)));
  const budget = Math.min(a.at(-1).samples, b.at(-1).samples);
  const within = (moments) => moments.filter(({ samples }) => samples <= budget).at(-1);
  assert.ok(within(b).samples < b.at(-1).samples); // or nothing would be matched
  await wait_for_moments(within(b).number, within(a).number);
  await wait_for_picture(page, 0, ({ job, cursor }) => job === plain && cursor > 0);
  await page.locator('.view-left-label').filter({ hasText: `${within(b).samples} samples` })
    .waitFor();
});

test('at equal time each shows what it had by then', async () => {
  await page.locator('#equal').selectOption('seconds');
  const [left, right] = await Promise.all([plain, published].map(async (id) =>
    (await metrics(id)).moments.filter(({ picture }) => picture)));
  const apart = (a, b) => Math.max(a.seconds / b.seconds, b.seconds / a.seconds);
  const least = Math.min(...left.flatMap((a) => right.map((b) => apart(a, b))));
  await page.waitForFunction(() => location.hash.includes('equal=seconds'));
  const shown = () => page.evaluate(async () => {
    const { viewer } = await import('/app.js');
    return viewer.pictures.map(({ moment }) => moment);
  });
  const numbers = await shown();
  const [a, b] = [left, right].map((moments, i) =>
    moments.find(({ number }) => number === numbers[i]));
  assert.ok(apart(a, b) <= Math.max(1.1, least) + 1e-9, `${a.seconds} s and ${b.seconds} s`);
  await page.reload();
  await wait_for_moments(a.number, b.number);
  await page.locator('#equal').selectOption('');
  await wait_for_moments(null, null);
});

test('maps show where they differ, with what their colours mean', async () => {
  for (const [mode, map] of [['signed', 'signed'], ['flip-map', 'flip']]) {
    await page.locator('#mode').selectOption(mode);
    await wait_for_same_image(page, '.pane.left img.overlay',
      `/v1/compare.png?a=${published}&b=${plain}&map=${map}`);
    assert.ok((await page.locator('.view-caption').textContent()).length > 10);
    assert.equal(await seen('right'), false);
    await screenshot(page, `map-${map}-1280`);
  }
});

test('the arrow keys\' pixel is told of both', async () => {
  await page.locator('#mode').selectOption('split');
  await page.locator('.stage').focus();
  await page.keyboard.press('ArrowRight');
  await page.keyboard.press('Shift+ArrowDown');
  assert.deepEqual([await page.locator('#pixel-x').inputValue(),
    await page.locator('#pixel-y').inputValue()], ['48', '58']);
  await page.waitForFunction(() => document.querySelectorAll('.pixel-table thead, .pixel-table tr')
    .length > 4);
  assert.equal(await page.locator('.pixel-table tr').first().locator('th').count(), 2);
});
