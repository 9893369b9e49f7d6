// What the page says when a job fails, when it waits in the queue, when there is no such job, and
// when there are more jobs than one answer lists.
import assert from 'node:assert/strict';
import { cpSync, mkdirSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { after, afterEach, before, test } from 'node:test';
import { fileURLToPath } from 'node:url';
import { post_by_form, scratch_folder, screenshot, start_all, wait_for_state,
  wait_for_tiles } from './support.mjs';

const kScenes = fileURLToPath(new URL('../../scenes', import.meta.url));

let all;
let page;
before(async () => {
  const scenes_folder = scratch_folder();
  cpSync(join(kScenes, 'cornell-box'), join(scenes_folder, 'cornell-box'), { recursive: true });
  mkdirSync(join(scenes_folder, 'broken'));
  writeFileSync(join(scenes_folder, 'broken', 'scene.json'), '{"materials": 7}');
  all = await start_all({ scenes_folder, more: ['--jobs-at-once', '1'] });
  page = await all.browser.page(all.server.url);
});
after(() => all?.close());
afterEach(() => all.browser.expect_no_errors());

test('a job whose scene cannot be loaded fails with the message and the place', async () => {
  const { job } = await post_by_form(page, { scene: 'broken', amount: 4 });
  await wait_for_state(page, job, 'Failed');
  const { error } = await all.server.job(job);
  assert.match(error.where, /scene\.json/);
  const panel = page.locator(`.panel[data-job="${job}"]`);
  assert.equal(await panel.locator('.panel-error-message').textContent(), error.message);
  assert.equal(await panel.locator('.panel-error-where').textContent(), error.where);
  assert.equal(await panel.locator('.panel-png').isVisible(), false);
  assert.equal(await page.locator('.view-waiting').textContent(), 'No picture was made.');
  await screenshot(page, 'failed-1280');
});

test('a job behind another one waits, and can be canceled while it waits', async () => {
  const first = await all.server.post({ scene: 'cornell-box', seconds: 60, width: 64, height: 64 });
  const { job } = await post_by_form(page, { scene: 'cornell-box', amount: 4, width: 64,
    height: 64 });
  await wait_for_state(page, job, 'Waiting');
  // Jobs posted elsewhere come into the list by themselves.
  await page.locator(`#jobs [data-job="${first}"]`).waitFor();
  await page.getByRole('button', { name: 'Cancel' }).click();
  await wait_for_state(page, job, 'Canceled');
  await page.locator(`#jobs [data-job="${first}"] a`).click();
  await wait_for_tiles(page, 0);
  await page.getByRole('button', { name: 'Cancel' }).click();
  await wait_for_state(page, first, 'Canceled');
});

test('an address of a job that does not exist says so', async () => {
  const other = await all.browser.page(`${all.server.url}/#job=j999999`);
  await other.locator('.view-missing').filter({ hasText: 'There is no job j999999.' }).waitFor();
  assert.equal(await other.locator('.stage').isVisible(), false);
  await other.context().close();
});

test('older jobs are listed when asked for', async () => {
  let newest;
  for (let seed = 1; seed <= 52; ++seed) {
    newest = await all.server.post({
      scene: 'cornell-box', samples: 1, width: 8, height: 8, seed });
  }
  // An event of a job that still runs would show it before the list has come, or beyond its page.
  await all.server.wait_until(newest, (job) => job.state === 'succeeded');
  const other = await all.browser.page(all.server.url);
  await other.locator('#jobs li').first().waitFor();
  assert.equal(await other.locator('#jobs li').count(), 50);
  await other.getByRole('button', { name: 'Show older jobs' }).click();
  await other.locator('#jobs [data-job="j000001"]').waitFor();
  assert.equal(await other.locator('#older').isVisible(), false);
  const ids = await other.locator('#jobs li').evaluateAll((rows) => rows.map((r) => r.dataset.job));
  assert.deepEqual(ids, [...ids].sort().reverse());
  await other.context().close();
});
