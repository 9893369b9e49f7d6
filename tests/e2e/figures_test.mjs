// The thesis' figures made live: every card has its pictures, halves are put together of two jobs,
// the published method says how far off it is, and a reload finds all of it again.
import assert from 'node:assert/strict';
import { after, afterEach, before, test } from 'node:test';
import { screenshot, start_all } from './support.mjs';

let all;
let page;
before(async () => {
  all = await start_all();
  page = await all.browser.page(`${all.server.url}/#figures`);
});
after(() => all?.close());
afterEach(() => all.browser.expect_no_errors());

const card = (number, on = page) => on.locator(`.figure-card[data-figure="${number}"]`);
const kPictures = { 5: [1, 1], 6: [1, 1], 8: [1], 9: [1], 10: [2, 2], 11: [2, 2], 12: [2, 2],
  13: [2, 2] };

async function posted_parts() {
  const { jobs } = await (await all.server.get('/v1/jobs?limit=200')).json();
  return jobs.map(({ request }) => request.labels.part).sort();
}

async function wait_for_figures(on) {
  for (const [number, counts] of Object.entries(kPictures)) {
    const boxes = card(number, on).locator('.figure-box');
    for (const [i, count] of counts.entries()) {
      await boxes.nth(i).locator('img').nth(count - 1).waitFor();
      assert.equal(await boxes.nth(i).locator('img').count(), count);
    }
  }
}

test('what waited for its lesson when the page was closed is posted by the next one', async () => {
  const first = await all.browser.page(`${all.server.url}/#figures`);
  // Closed before the lesson's end, in effect: the halves that read it are not posted.
  await first.route('**/v1/jobs', (route) =>
    (route.request().postDataJSON()?.labels.part.startsWith('huang')
      ? route.abort() : route.continue()));
  await first.locator('.figures-size').selectOption('128');
  await card(10, first).locator('.figure-make').click();
  await first.locator('.figures-status').filter({ hasText: 'cannot be reached' }).waitFor();
  await first.context().close();
  assert.deepEqual(await posted_parts(), ['lesson', 'none-8']);

  // Two at once: each posts, and together they make one job of each part.
  const both = await Promise.all([0, 1].map(() => all.browser.page(`${all.server.url}/#figures`)));
  await Promise.all(both.map(async (on) => {
    await on.locator('.figures-size').selectOption('128');
    for (const box of [0, 1]) await card(10, on).locator('.figure-box').nth(box).locator('img')
      .nth(1).waitFor();
    await on.context().close();
  }));
  assert.deepEqual(await posted_parts(), ['huang-8', 'huang-published-8', 'lesson', 'none-8']);
});

test('all figures are made by this server', async () => {
  await page.locator('.figures-size').selectOption('128');
  await page.locator('.figures-all').click();
  await wait_for_figures(page);
  const { jobs } = await (await all.server.get('/v1/jobs?limit=200')).json();
  const of_part = (part) => jobs.find(({ request }) => request.labels.part === part);
  assert.equal(jobs.length, new Set(jobs.map(({ request }) => request.labels.part)).size);
  const [published, corrected] = ['huang-published-80-b', 'huang-80-b'].map(of_part);
  assert.deepEqual([published.request.method, corrected.request.method],
    ['huang-published', 'huang']);
  assert.equal(published.table_in, of_part('lesson-b').table_out); // both read the same table
  assert.equal(corrected.table_in, published.table_in);
  assert.deepEqual([published.request.samples, published.request.nee], [80, false]);
  assert.deepEqual(published.request.camera, of_part('none-80-b').request.camera);
  await screenshot(page, 'figures-1280');
});

test('the published method is too bright here too, and says by how much', async () => {
  const notes = card(12).locator('.figure-note');
  await notes.nth(0).filter({ hasText: /times as bright|% brighter/ }).waitFor();
  await notes.nth(1).filter({ hasText: 'The right half is' }).waitFor();
  const [published, corrected] = await Promise.all([0, 1].map(async (i) => {
    const link = await notes.nth(i).locator('a').getAttribute('href');
    const shown = new URLSearchParams(link.slice(1));
    const answer = await all.server.get(
      `/v1/compare?a=${shown.get('job')}&b=${shown.get('with')}`);
    return (await answer.json()).difference.mean_ratio;
  }));
  assert.ok(published > 1.3, `published: ${published}`);
  assert.ok(Math.abs(corrected - 1) < 0.2, `corrected: ${corrected}`);
});

test('a reload finds the figures, and makes nothing anew', async () => {
  const count = async () => (await (await all.server.get('/v1/jobs?limit=200')).json()).jobs.length;
  const jobs = await count();
  await page.reload();
  await page.locator('.figures-size').selectOption('128');
  await wait_for_figures(page);
  assert.ok(await card(10).locator('.figure-make').isDisabled());
  assert.equal(await count(), jobs);
  const phone = await all.browser.page(`${all.server.url}/#figures`, { width: 390, height: 844 });
  await phone.locator('.figures-size').selectOption('128');
  await wait_for_figures(phone);
  assert.equal(await phone.evaluate(() => document.documentElement.scrollWidth), 390);
  await screenshot(phone, 'figures-390');
  await phone.context().close();
});

test('a figure opens side by side', async () => {
  await card(12).locator('.figure-note a').first().click();
  await page.locator('.view-divider').waitFor();
  const labels = await page.locator('.half-label:visible').allTextContents();
  assert.equal(labels[0], 'no learning');
  assert.match(labels[1], /^huang as published/);
});
