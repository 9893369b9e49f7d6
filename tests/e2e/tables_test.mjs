// The page of tables: versions and parents, which jobs used one, merging, deleting, and what the
// server refuses.
import assert from 'node:assert/strict';
import { after, afterEach, before, test } from 'node:test';
import { screenshot, start_all } from './support.mjs';

const kJob = { scene: 'cornell-box', method: 'huang', samples: 4, width: 64, height: 64 };
let all;
let page;
const done = [];
before(async () => {
  all = await start_all();
  const requests = [kJob, kJob, { ...kJob, table: 'auto', seed: 3 },
    { ...kJob, scene: 'furnace' }];
  for (const request of requests) {
    const id = await all.server.post(request);
    done.push(await all.server.wait_until(id, ({ state }) => state === 'succeeded'));
  }
  page = await all.browser.page(`${all.server.url}/#tables`);
  await row(done[0].table_out).waitFor();
});
after(() => all?.close());
afterEach(() => all.browser.expect_no_errors());

const row = (id) => page.locator(`[id="table-${id}"]`);
const cell = (id, name) => row(id).locator(`.table-${name}`).textContent();

test('each table tells its version, its parents, what it holds and who made it', async () => {
  const [first, second, third] = done.map(({ table_out }) => table_out);
  const { tables } = await (await all.server.get('/v1/tables')).json();
  assert.deepEqual(await page.locator('tbody tr').evaluateAll((rows) => rows.map(({ id }) => id)),
    tables.map(({ id }) => `table-${id}`));
  assert.deepEqual([await cell(first, 'version'), await cell(second, 'version'),
    await cell(third, 'version')], ['v1', 'v2', 'v3']);
  assert.equal(await cell(first, 'parents'), '–');
  assert.equal(await cell(third, 'parents'), second.slice(0, 8));
  assert.equal(await cell(first, 'job'), done[0].id);
  const { states } = tables.find(({ id }) => id === first);
  assert.equal(await cell(first, 'states'), states.toLocaleString('en'));
  await screenshot(page, 'tables-1280');
});

test('which jobs used a table is asked when it is wanted', async () => {
  const [first, second] = done;
  await row(first.table_out).locator('summary').click();
  const lines = row(first.table_out).locator('.table-user-list li');
  await lines.nth(1).waitFor();
  assert.deepEqual((await lines.allTextContents()).sort(),
    [`${first.id} made it`, `${second.id} started from it`].sort());
});

test('two are merged, and the merged one is the newest', async () => {
  const [first, second] = done.map(({ table_out }) => table_out);
  const merge = page.locator('.tables-merge');
  assert.ok(await merge.isDisabled());
  await row(first).locator('.table-choose').check();
  await row(second).locator('.table-choose').check();
  await merge.click();
  await page.locator('.tables-status').filter({ hasText: /^Merged into [0-9a-f]{8};/ }).waitFor();
  const { tables: [newest] } = await (await all.server.get('/v1/tables')).json();
  assert.deepEqual(newest.parents.toSorted(), [first, second].toSorted());
  await row(newest.id).waitFor();
  assert.equal(await cell(newest.id, 'job'), 'a merge');
  assert.equal(await cell(newest.id, 'version'), 'v3');
});

test('what cannot be merged is said in the server\'s words', async () => {
  const ids = [done[0].table_out, done[3].table_out];
  for (const id of ids) await row(id).locator('.table-choose').check();
  await page.locator('.tables-merge').click();
  const refused = await fetch(`${all.server.url}/v1/tables/merge`, { method: 'POST',
    headers: { 'content-type': 'application/json' }, body: JSON.stringify({ tables: ids }) });
  assert.equal(refused.status, 409);
  const { detail } = await refused.json();
  await page.locator('.tables-status.error').filter({ hasText: detail }).waitFor();
});

test('a table is deleted once that is confirmed', async () => {
  const id = done[3].table_out;
  page.once('dialog', (dialog) => dialog.dismiss());
  await row(id).locator('.table-delete').click();
  assert.equal((await fetch(`${all.server.url}/v1/tables/${id}`)).status, 200);
  page.once('dialog', (dialog) => dialog.accept());
  await row(id).locator('.table-delete').click();
  await row(id).waitFor({ state: 'detached' });
  assert.equal((await fetch(`${all.server.url}/v1/tables/${id}`)).status, 404);
});

test('on a phone the list scrolls, the page does not', async () => {
  const phone = await all.browser.page(`${all.server.url}/#tables`, { width: 390, height: 844 });
  await phone.locator('tbody tr').first().waitFor();
  assert.equal(await phone.evaluate(() => document.documentElement.scrollWidth), 390);
  await screenshot(phone, 'tables-390');
  await phone.context().close();
});
