// The page of experiments: one form posts methods x seeds and a reference, the job list shows one
// entry, and what comes of it is read, saved and repeated by the command that stands there.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { after, afterEach, before, test } from 'node:test';
import { env, scratch_folder, screenshot, start_all } from './support.mjs';

const kName = 'boxes, two methods';
let all;
let page;
before(async () => {
  all = await start_all();
  page = await all.browser.page(`${all.server.url}/#bench`, { ready: '.bench-methods input' });
});
after(() => all?.close());
afterEach(() => all.browser.expect_no_errors());

const group_row = (on) => on.locator('#jobs [data-group]');
const jobs_of = async () => (await (await all.server.get(
  `/v1/jobs?limit=200&label=${encodeURIComponent(`experiment:${kName}`)}`)).json()).jobs;
const cells = () => page.locator('.bench-cases tbody tr').evaluateAll((rows) =>
  rows.map((row) => [...row.children].map((cell) => cell.textContent)));
const median = (values) => {
  const [a, b] = values.toSorted((one, other) => one - other);
  return (a + b) / 2;
};

async function saved(button) {
  const [download] = await Promise.all([page.waitForEvent('download'), button.click()]);
  return { name: download.suggestedFilename(), text: readFileSync(await download.path(), 'utf8') };
}

test('one form posts two methods x two seeds and a reference in two halves', async () => {
  await page.locator('#bench-name').fill(kName);
  for (const box of await page.locator('.bench-scenes input').all()) {
    await box.setChecked(await box.inputValue() === 'cornell-box');
  }
  for (const box of await page.locator('.bench-methods input').all()) {
    await box.setChecked(await box.inputValue() === 'none');
  }
  await page.locator('#bench-variants').fill('huang:grid=12;gate=off');
  await page.locator('#bench-seeds').fill('2');
  await page.locator('#bench-amount').fill('16');
  await page.locator('[name=budget]').last().selectOption('samples');
  await page.locator('#bench-width').fill('48');
  await page.locator('#bench-height').fill('48');
  await page.locator('.bench-count')
    .filter({ hasText: /2 methods × 2 seeds × 1 scenes.* 6 jobs/ }).waitFor();
  await page.locator('.bench-form [type=submit]').click();
  await page.locator('.bench-progress').filter({ hasText: '6 of 6 jobs have ended' }).waitFor();
  assert.equal(await page.locator('h2:visible').first().textContent(), kName);
  const jobs = await jobs_of();
  assert.equal(jobs.length, 6);
  assert.ok(jobs.every(({ request }) => request.alone && request.table === 'none'));
  const guided = jobs.filter(({ request }) => request.labels.variant === 'huang:grid=12;gate=off');
  assert.deepEqual(guided.map(({ request: { method, seed, guide, gate } }) =>
    [method, seed, guide.grid, gate]).sort((a, b) => a[1] - b[1]),
  [['huang', 1, 12, false], ['huang', 2, 12, false]]);
});

test('its results are those of the pictures', async () => {
  await page.locator('.bench-cases tbody tr td:nth-child(2)').filter({ hasText: /^2$/ }).nth(1)
    .waitFor();
  const jobs = await jobs_of();
  const part = (name) => jobs.find(({ request }) => request.labels.part === name).id;
  const [a, b] = [part('reference a'), part('reference b')];
  const compare = async (query) => (await all.server.get(`/v1/compare?${query}`)).json();
  const apart = (await compare(`a=${a}&b=${b}`)).difference.relmse;
  const error_of = async ({ id }) => {
    const { difference, a_error: of_a } = await compare(`a=${id}&b=${b}&ref=${a}`);
    return (difference.relmse + of_a.relmse) / 2 - apart / 4;
  };
  const rows = await cells();
  for (const [i, method] of ['none', 'huang'].entries()) {
    const own = jobs.filter(({ request }) => request.labels.part === 'run' &&
      request.method === method);
    const expected = median(await Promise.all(own.map(error_of)));
    assert.ok(Math.abs(Number(rows[i][2]) / expected - 1) < 0.01, `${rows[i]}: ${expected}`);
    assert.equal(rows[i][6], '16');
  }
  assert.match(rows[0][8], /^1 \(1 to 1\)$/); // efficiency over itself
  const said = await page.locator('.case-checks').textContent();
  assert.match(said, /Size and camera are equal in all runs here: 4 have ended/);
  assert.match(said, /equal samples, not equal time: they took .*, each alone/);
  assert.match(said, /two halves of 160 and 160 samples/);
  await page.locator('.case-chart canvas').waitFor();
  const over = await page.locator('.case-chart .u-over').boundingBox();
  await page.mouse.move(over.x + over.width / 2, over.y + over.height / 2);
  await page.locator('.case-hover').filter({ hasText: /after [\d.]+ s$/ }).waitFor();
  await screenshot(page, 'experiment-1280');
});

test('CSV, JSON and SVG have the same', async () => {
  const csv = await saved(page.locator('.bench-csv'));
  assert.equal(csv.name, `${kName}.csv`);
  const [head, ...lines] = csv.text.trim().split('\n').map((line) => line.split(','));
  const ends = lines.filter((line) => line[head.indexOf('at')] === 'end');
  assert.equal(ends.length, 4);
  const json = JSON.parse((await saved(page.locator('.bench-json'))).text);
  assert.equal(json.cases[0].runs.length, 4);
  assert.equal(json.cases[0].methods[0].error,
    median(ends.filter((line) => line[head.indexOf('method')] === 'none')
      .map((line) => Number(line[head.indexOf('error')]))));
  assert.equal(json.cases[0].equal_time.beside, 0);
  const svg = await saved(page.locator('.case-svg'));
  const shape = await page.evaluate((text) => {
    const parsed = new DOMParser().parseFromString(text, 'image/svg+xml');
    return [parsed.documentElement.tagName, parsed.querySelectorAll('polyline').length,
      parsed.querySelectorAll('polygon').length];
  }, svg.text);
  assert.deepEqual(shape, ['svg', 2, 2]);
});

test('the command that stands there repeats it', { timeout: 120_000 }, async () => {
  const command = await page.locator('.bench-command').textContent();
  assert.match(command,
    /^qray chart cornell-box --methods 'none,huang:grid=12;gate=off' --seconds/);
  assert.match(command, /--seeds 2 --size 48x48 --ref-seconds/);
  const folder = scratch_folder();
  execFileSync('sh', ['-c', command.replace(/^qray/, env('QRAY'))], { cwd: folder });
  const name = command.match(/-o (\S+)$/)[1];
  const summary = JSON.parse(readFileSync(join(folder, name, 'summary.json'), 'utf8'));
  assert.deepEqual(summary.scenes[0].methods.map(({ method }) => method),
    ['none', 'huang:grid=12;gate=off']);
});

test('the job list has one entry for it, which opens', async () => {
  const list = await all.browser.page(all.server.url);
  await group_row(list).filter({ hasText: `Experiment ${kName}` }).waitFor();
  assert.equal(await list.locator('#jobs li').count(), 1);
  await list.locator('.row-open').click();
  assert.equal(await list.locator('#jobs [data-job]').count(), 6);
  await list.locator('.row-open').click();
  assert.equal(await list.locator('#jobs [data-job]').count(), 0);
  await list.locator('.choice-toggle').click(); // each can be chosen
  assert.equal(await list.locator('#jobs [data-job] .row-choose:visible').count(), 6);
  await list.locator('.choice-toggle').click();
  await group_row(list).locator('a').click();
  await list.locator('.case-title').filter({ hasText: '48 × 48' }).waitFor();
  await list.context().close();
});

test('runs beside other jobs, and of two sizes, are told', async () => {
  const labels = { experiment: 'by hand' };
  const job = { scene: 'cornell-box', method: 'none', seconds: 1, width: 32, height: 32, labels };
  const beside = await all.server.post({ ...job, seconds: 3600, labels: {} });
  await all.server.wait_until(beside, ({ started }) => started);
  const ids = [];
  for (const more of [{ seed: 1 }, { seed: 2 }, { width: 40 }]) {
    ids.push(await all.server.post({ ...job, ...more }));
  }
  for (const id of ids) await all.server.wait_until(id, ({ state }) => state === 'succeeded');
  await page.goto(`${all.server.url}/#bench&group=by%20hand`);
  await page.locator('.case-title').nth(1).waitFor();
  const said = page.locator('.case-checks').first();
  await said.filter({ hasText: /Equal time does not hold: .* ran beside another job/ }).waitFor();
  assert.match(await said.textContent(), /2 sizes or cameras/);
  assert.match(await said.textContent(), /No reference was made/);
  await all.server.call('POST', `/v1/jobs/${beside}/cancel`);
});

test('a job starts an experiment with its view, and on a phone it fits', async () => {
  const camera = { position: [0, 1, 3.2], target: [0, 1, 0], vertical_fov_deg: 35 };
  const id = await all.server.post({ scene: 'cornell-box', method: 'none', samples: 4, width: 64,
    height: 48, camera });
  const phone = await all.browser.page(`${all.server.url}/#job=${id}`, { width: 390, height: 844 });
  const href = await phone.locator(`.panel[data-job="${id}"] .panel-bench`).getAttribute('href');
  await phone.goto(`${all.server.url}/${href}`);
  await phone.locator('#bench-width').waitFor();
  await phone.waitForFunction(() => document.querySelector('#bench-width').value === '64');
  assert.equal(await phone.locator('#bench-camera').evaluate((one) => one.selectedOptions[0].text),
    `that of ${id}`);
  await phone.evaluate(() => localStorage.setItem('qray-cameras',
    JSON.stringify({ 'cornell-box': { 'from the left': '-1,1,3,0,1,0,f40' } })));
  await phone.locator('#bench-width').fill('65'); // the form looks at itself again
  assert.deepEqual(await phone.locator('#bench-camera option').allTextContents(),
    ["each scene's own", 'from the left', `that of ${id}`]);
  await screenshot(phone, 'experiment-form-390');
  await phone.goto(`${all.server.url}/#bench&group=${encodeURIComponent(kName)}`);
  await phone.locator('.case-chart canvas').waitFor();
  assert.equal(await phone.evaluate(() => document.documentElement.scrollWidth), 390);
  await screenshot(phone, 'experiment-390');
  await phone.context().close();
});

test('an experiment is deleted as a whole', async () => {
  await page.goto(`${all.server.url}/#bench&group=${encodeURIComponent(kName)}`);
  await page.locator('.bench-delete:enabled').waitFor();
  page.once('dialog', (dialog) => dialog.accept());
  await page.locator('.bench-delete').click();
  await page.locator('.bench-list').filter({ hasText: 'by hand' }).waitFor();
  assert.deepEqual(await jobs_of(), []);
});
