// The list of jobs and the form: thumbnails, filters that a reload keeps, time left, why a job
// stopped, a job's twin by "Duplicate", and the server's words at every field.
import assert from 'node:assert/strict';
import { after, afterEach, before, test } from 'node:test';
import { post_by_form, screenshot, start_all, wait_for_state, wait_for_tiles } from './support.mjs';

const kSmall = { scene: 'cornell-box', samples: 4, width: 64, height: 64 };
let all;
let page;
const jobs = {};
before(async () => {
  all = await start_all();
  jobs.plain = await all.server.post({ ...kSmall, method: 'none', labels: { project: 'lobby' } });
  jobs.guided = await all.server.post({ ...kSmall, method: 'huang' });
  jobs.noise = await all.server.post({ ...kSmall, method: 'huang', samples: 64, noise: 1 });
  for (const id of Object.values(jobs)) {
    await all.server.wait_until(id, ({ state }) => state === 'succeeded');
  }
  page = await all.browser.page(all.server.url, { height: 1200 });
  await row(jobs.plain).waitFor();
});
after(() => all?.close());
afterEach(() => all.browser.expect_no_errors());

const row = (id) => page.locator(`#jobs [data-job="${id}"]`);
const why = (id) => page.locator(`.panel[data-job="${id}"] .panel-why`);

test('rows show the picture they are about', async () => {
  await row(jobs.plain).locator('.row-picture.drawn').waitFor();
  const lit = await row(jobs.plain).locator('.row-picture').evaluate((canvas) => {
    const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
    return data.filter((v, i) => i % 4 !== 3 && v > 20).length / (data.length * 0.75);
  });
  assert.ok(lit > 0.3, `${lit} of the thumbnail is lit`);
});

test('filters leave what fits, and a reload keeps them', async () => {
  await page.locator('#find').fill('project:lobby');
  await row(jobs.guided).waitFor({ state: 'detached' });
  assert.equal(await page.locator('#jobs li').count(), 1);
  assert.equal(await page.locator('#filtered').textContent(), '1 of all jobs');
  await page.reload();
  await row(jobs.plain).waitFor();
  assert.equal(await page.locator('#jobs li').count(), 1);
  assert.equal(await page.locator('#find').inputValue(), 'project:lobby');
  await page.locator('#find').fill('');
  await page.locator('#state-filter').selectOption('failed');
  await page.waitForFunction(() => !document.querySelector('#jobs li'));
  await page.locator('#state-filter').selectOption('');
  await row(jobs.guided).waitFor();
});

test('several jobs are chosen, and rendered again, extended and deleted together', async () => {
  const own = 'together';
  const ids = [];
  for (let seed = 1; seed <= 3; ++seed) {
    ids.push(await all.server.post({ ...kSmall, method: 'none', seed, labels: { of: own } }));
  }
  for (const id of ids) await all.server.wait_until(id, ({ state }) => state === 'succeeded');
  const other = await all.browser.page(`${all.server.url}/#find=of:${own}`);
  const rows = other.locator('#jobs li');
  await rows.nth(2).waitFor();
  assert.equal(await other.locator('.row-choose').first().isVisible(), false);
  await other.locator('.choice-toggle').click();
  assert.equal(await other.locator('.choice-delete').isDisabled(), true);
  const status = (text) => other.locator('.choice-status').filter({ hasText: text }).waitFor();

  await other.getByLabel(`Choose ${ids[0]}`).check();
  await status('1 chosen.');
  await other.locator('.choice-again').click();
  await status('1 rendered again, each as a new job.');
  await rows.nth(3).waitFor();

  await other.locator('.choice-all').click();
  await status('4 chosen.');
  other.once('dialog', (dialog) => dialog.accept('5'));
  await other.locator('.choice-extend').click();
  await status(/extended\./);
  for (const id of ids) await all.server.wait_until(id, ({ request }) => request.samples === 9);

  const { jobs: listed } = await (await all.server.get(`/v1/jobs?q=of:${own}`)).json();
  for (const { id } of listed) {
    await all.server.wait_until(id, ({ state }) => state === 'succeeded');
  }
  await other.waitForFunction(() =>
    document.querySelectorAll('#jobs li[data-state=succeeded]').length === 4);
  await screenshot(other, 'choice-1280');
  other.once('dialog', (dialog) => dialog.dismiss());
  await other.locator('.choice-delete').click(); // and nothing is lost
  assert.equal(await rows.count(), 4);
  other.once('dialog', (dialog) => dialog.accept());
  await other.locator('.choice-delete').click();
  await status('4 deleted.');
  assert.equal(await rows.count(), 0);
  assert.deepEqual((await (await all.server.get(`/v1/jobs?q=of:${own}`)).json()).jobs, []);
  await other.context().close();
});

test('words find jobs that are older than those listed', async () => {
  const newer = Array.from({ length: 60 }, () => ({ ...kSmall, samples: 1, width: 8, height: 8,
    method: 'none', table: 'none' }));
  await Promise.all(newer.map((request) => all.server.post(request)));
  const other = await all.browser.page(all.server.url);
  await other.locator('#older').waitFor();
  assert.equal(await other.locator(`#jobs [data-job="${jobs.plain}"]`).count(), 0);
  await other.locator('#find').fill('LOBBY');
  await other.locator(`#jobs [data-job="${jobs.plain}"]`).waitFor();
  assert.equal(await other.locator('#filtered').textContent(), '1 of all jobs');
  const found = (await (await all.server.get('/v1/jobs?q=none&limit=200')).json()).jobs.length;
  assert.ok(found > 60);
  await other.locator('.choice-toggle').click();
  await other.locator('#find').fill('none');
  await other.locator('.choice-all').click(); // before the answer, and not only of those listed
  await other.locator('.choice-status').filter({ hasText: `${found} chosen.` }).waitFor();
  await other.context().close();
});

test('a job says why it stopped', async () => {
  await page.locator('#older').click(); // newer ones have come since
  await row(jobs.plain).locator('a').click();
  await why(jobs.plain).filter({ hasText: 'Stopped when all 4 samples were there.' }).waitFor();
  await row(jobs.noise).locator('a').click();
  const { stats } = await all.server.job(jobs.noise);
  assert.ok(stats.samples < 64 && stats.noise <= 1);
  await why(jobs.noise).filter({ hasText: /^Stopped at .* no more than the 1 asked for\.$/ })
    .waitFor();
});

test('a running job tells how long it will take, and one that was canceled who ended it',
  async () => {
    const { job } = await post_by_form(page, { scene: 'cornell-box', method: 'none',
      budget: 'seconds', amount: 60, width: 96, height: 96 });
    await page.locator(`.panel[data-job="${job}"] .panel-numbers`)
      .filter({ hasText: /about [\d.]+\ss left/ }).waitFor();
    await page.getByRole('button', { name: 'Cancel' }).click();
    await wait_for_state(page, job, 'Canceled');
    await why(job)
      .filter({ hasText: /^Someone canceled it after .* Its picture so far is kept\.$/ }).waitFor();
  });

test('Duplicate fills the form with all that the job was asked', async () => {
  const request = { ...kSmall, method: 'huang', seed: 9, nee: false, priority: 2, max_depth: 5,
    guide: { alpha: 0.1, gamma: 0.3, grid: 12 }, gate: false, learning_samples: 2,
    labels: { project: 'twin', who: 'me' },
    camera: { position: [0.1, 1, 3], vertical_fov_deg: 50 } };
  const original = await all.server.post(request);
  await all.server.wait_until(original, ({ state }) => state === 'succeeded');
  await row(original).locator('a').click();
  await wait_for_tiles(page, 0);
  await page.getByRole('button', { name: 'Duplicate' }).click();
  assert.equal(await page.evaluate(() => document.activeElement.id), 'scene');
  const { job } = await post_by_form(page, {});
  assert.notEqual(job, original);
  const { request: twin } = await all.server.job(job);
  assert.deepEqual(twin, (await all.server.job(original)).request);
  await wait_for_state(page, job, 'Done');
});

test('what the server refuses is said at the field, also of those that are folded', async () => {
  await page.getByRole('button', { name: 'Duplicate' }).click();
  await page.locator('.more').evaluate((details) => {
    details.open = false;
  });
  await page.locator('[name="camera.position"]').evaluate((field) => {
    field.value = '1, far, 3';
  });
  await page.locator('[name="guide.grid"]').evaluate((field) => {
    field.value = '100000';
  });
  await page.getByRole('button', { name: 'Render' }).click();
  for (const name of ['camera.position', 'guide.grid']) {
    await page.locator(`[id="${name}-error"]`).filter({ hasText: /expected/ }).waitFor();
    assert.equal(await page.locator(`[name="${name}"]`).getAttribute('aria-invalid'), 'true');
  }
  assert.ok(await page.locator('.more').evaluate((details) => details.open));
  await screenshot(page, 'refused-1280');
});

test('a table of the scene and method can be chosen', async () => {
  const { table_out } = await all.server.job(jobs.guided);
  await page.reload();
  await page.locator('#scene option').first().waitFor({ state: 'attached' });
  await page.locator('#scene').selectOption('cornell-box');
  await page.locator('#method').selectOption('huang');
  const { job } = await post_by_form(page, { table: table_out, amount: 2, width: 64, height: 64 });
  await wait_for_state(page, job, 'Done');
  assert.equal((await all.server.job(job)).table_in, table_out);
  await page.locator('#method').selectOption('ppg');
  assert.equal(await page.locator(`#table option[value="${table_out}"]`).count(), 0);
});
