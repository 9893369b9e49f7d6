// A job's life seen from the page: cancel, reload in mid-job, a lost server, tables that are kept
// and used again, and the badge of the biased method.
import assert from 'node:assert/strict';
import { after, afterEach, before, test } from 'node:test';
import { pictures, post_by_form, Server, start_all, state_shown, wait_for_state,
  wait_for_tiles } from './support.mjs';

const kLong = { scene: 'cornell-box', budget: 'seconds', amount: 60, width: 192, height: 192 };
const kShort = { scene: 'cornell-box', budget: 'samples', amount: 8, width: 96, height: 96 };

let all;
let page;
before(async () => {
  all = await start_all();
  page = await all.browser.page(all.server.url);
});
after(() => all?.close());
afterEach(() => all.browser.expect_no_errors());

const fact = (job, name) => page.locator(`.panel[data-job="${job}"] .facts > div`)
  .filter({ has: page.locator('dt', { hasText: new RegExp(`^${name}$`) }) }).locator('dd');

test('a reload in mid-job shows the same job and goes on', async () => {
  const { job } = await post_by_form(page, kLong);
  const before_reload = await wait_for_tiles(page, 0);
  await page.reload();
  let after_reload = await wait_for_tiles(page, 0);
  assert.equal(after_reload.job, job);
  // The first answer may hold but the tiles that changed longest ago.
  while (after_reload.cursor < before_reload.cursor)
    after_reload = await wait_for_tiles(page, 0, after_reload.tile_updates);
  const later = await wait_for_tiles(page, 0, after_reload.tile_updates);
  assert.ok(later.cursor > after_reload.cursor);
  assert.match(await state_shown(page, job), /^(Learning|Rendering)$/);
});

test('cancel stops the job, says so, and keeps the picture so far', async () => {
  const [{ job }] = await pictures(page);
  await page.getByRole('button', { name: 'Cancel' }).click();
  await wait_for_state(page, job, 'Canceled');
  assert.equal((await all.server.job(job)).state, 'canceled');
  assert.equal(await page.getByRole('button', { name: 'Cancel' }).count(), 0);
  assert.ok(await page.locator('.panel-png:visible').isVisible());
  assert.equal(await page.locator('#announcer').textContent(), `Job ${job}: Canceled`);
});

test('the second job on a scene says which table it started from', async () => {
  const first = await post_by_form(page, { ...kShort, method: 'huang' });
  await wait_for_state(page, first.job, 'Done');
  assert.equal(await fact(first.job, 'Table made').locator('code').textContent(),
    (await all.server.job(first.job)).table_out.slice(0, 8));
  const second = await post_by_form(page, { ...kShort, seed: 2 });
  await wait_for_state(page, second.job, 'Done');
  const { table_in } = await all.server.job(second.job);
  assert.equal(table_in, (await all.server.job(first.job)).table_out);
  const used = fact(second.job, 'Table used');
  assert.equal(await used.locator('code').textContent(), table_in.slice(0, 8));
  assert.equal(await used.locator('a').textContent(), first.job);
});

test('the next job starts from the table that two were merged into', async () => {
  const { tables } = await (await fetch(`${all.server.url}/v1/tables`)).json();
  const answer = await fetch(`${all.server.url}/v1/tables/merge`, {
    method: 'POST',
    headers: { 'Content-Type': 'application/json' },
    body: JSON.stringify({ tables: tables.slice(0, 2).map((table) => table.id) }),
  });
  assert.equal(answer.status, 201);
  const merged = await answer.json();
  const { job } = await post_by_form(page, { ...kShort, method: 'huang', seed: 5 });
  await wait_for_state(page, job, 'Done');
  const used = fact(job, 'Table used');
  assert.equal(await used.locator('code').textContent(), merged.id.slice(0, 8));
  assert.equal(await used.locator('a').count(), 0);  // no job left it
});

test('the published method wears its badge', async () => {
  const { job } = await post_by_form(page, { ...kShort, method: 'huang-published' });
  await wait_for_state(page, job, 'Done');
  assert.ok(await page.locator(`.panel[data-job="${job}"] .panel-badge`).isVisible());
  assert.ok(await page.locator(`#jobs [data-job="${job}"] .badge`).isVisible());
  assert.equal(await page.locator('#jobs .badge:visible').count(), 1);
});

test('a lost server is noticed, and everything is right again when it is back', async () => {
  const { port } = all.server;
  const rows = await page.locator('#jobs li').count();
  await all.server.stop();
  await page.locator('#notice').waitFor();
  all.server = await Server.start(all.folder, { port });
  await page.locator('#notice').waitFor({ state: 'hidden' });
  assert.equal(await page.locator('#connection').textContent(), 'Live');
  assert.equal(await page.locator('#jobs li').count(), rows);
  const { job } = await post_by_form(page, { ...kShort, method: 'none', seed: 3 });
  await wait_for_state(page, job, 'Done');
  assert.equal(await page.locator('#jobs li').count(), rows + 1);
});
