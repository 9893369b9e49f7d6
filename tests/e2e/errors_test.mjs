// Error against time: the chart and its words are what the server tells of each pass, it grows
// while a job runs, a moment is shown while the pointer is on it and kept by a click or the slider.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { after, afterEach, before, test } from 'node:test';
import { canvas_pixels, png_pixels, post_by_form, screenshot, start_all, wait_for, wait_for_state,
  wait_for_tiles } from './support.mjs';

const kJob = { scene: 'ajar-door', width: 96, height: 64 };
let all;
let page;
let guided;
let reference;
before(async () => {
  all = await start_all();
  guided = await all.server.post({ ...kJob, method: 'adaptive', samples: 128 });
  reference = await all.server.post({ ...kJob, method: 'none', samples: 64, seed: 5 });
  for (const id of [guided, reference]) {
    await all.server.wait_until(id, ({ state }) => state === 'succeeded');
  }
  page = await all.browser.page(`${all.server.url}/#job=${guided}&axis=samples`, { height: 1600 });
  await page.locator('.error-chart canvas').waitFor();
});
after(() => all?.close());
afterEach(() => all.browser.expect_no_errors());

const metrics = async (id, ref = '') =>
  (await all.server.get(`/v1/jobs/${id}/metrics${ref && `?ref=${ref}`}`)).json();
const words = (id) => page.locator('.error-words li').filter({ hasText: new RegExp(`^${id},`) });
const moment_shown = () => page.evaluate(async () =>
  (await import('/app.js')).viewer.pictures[0].moment);
const significant = (v) => (v >= 1e5 || v < 1e-4 ? v.toExponential(2) : String(+v.toPrecision(3)));

test('the words under the chart are what the server tells', async () => {
  const { moments, gate } = await metrics(guided);
  const measured = moments.filter(({ noise }) => noise > 0);
  assert.ok(measured.length >= 3);
  const last = measured.at(-1);
  await words(guided).filter({ hasText: `${significant(last.noise)} after` }).waitFor();
  assert.ok((await words(guided).textContent()).includes(gate === 'on' ? 'guiding pays'
    : gate.replace('off: ', 'guiding stopped: ')), gate);
  const ink = await page.locator('.error-chart canvas').evaluate((canvas) => {
    const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
    let blue = 0; // the first job's line
    for (let i = 0; i < data.length; i += 4) {
      blue += data[i + 3] > 200 && data[i] < 40 && data[i + 1] > 90 && data[i + 2] > 150;
    }
    return blue;
  });
  assert.ok(ink > 100, `${ink} pixels of the line`);
  await screenshot(page, 'errors-1280');
});

test('the chart is saved with every pass that it has', async () => {
  const saved = async (kind) => {
    const [download] = await Promise.all([page.waitForEvent('download'),
      page.locator(`.error-files [data-file=${kind}]`).click()]);
    return readFileSync(await download.path(), 'utf8');
  };
  const { moments } = await metrics(guided);
  const lines = (await saved('csv')).trim().split('\n');
  assert.equal(lines.filter((line) => line.startsWith(guided)).length, moments.length);
  const json = JSON.parse(await saved('json'));
  assert.equal(json.passes.filter(({ job }) => job === guided).at(-1).noise, moments.at(-1).noise);
  assert.match(await saved('svg'), /^<svg [^]*<polyline [^]*<\/svg>\n$/);
});

test('against a reference the error is the relMSE', async () => {
  await page.locator('#error-ref').selectOption(reference);
  const { moments } = await metrics(guided, reference);
  const last = moments.filter(({ relmse }) => relmse > 0).at(-1);
  await words(guided).filter({ hasText: `${significant(last.relmse)} after` }).waitFor();
  await page.locator('.error-chart').filter({ hasText: guided }).waitFor();
  assert.ok(await page.evaluate((id) => location.hash.includes(`ref=${id}`), reference));
  await page.locator('#error-ref').selectOption('');
});

// Those that the chart has and whose picture is kept; of a first pass no noise is known.
const charted = async () =>
  (await metrics(guided)).moments.filter(({ picture, noise }) => picture && noise > 0);

test('the pointer over the chart shows that moment, and leaving it the newest', async () => {
  const pictured = await charted();
  const over = page.locator('.error-chart .u-over');
  await over.scrollIntoViewIfNeeded();
  const box = await over.boundingBox();
  await page.mouse.move(box.x + 4, box.y + box.height / 2);
  await wait_for(page, async (number) =>
    (await import('/app.js')).viewer.pictures[0].moment === number, pictured[0].number);
  await page.mouse.move(box.x + box.width / 2, box.y - 200);
  await wait_for(page, async () =>
    (await import('/app.js')).viewer.pictures[0].moment === null);
  await page.mouse.click(box.x + 4, box.y + box.height / 2);
  await page.waitForFunction((n) => location.hash.includes(`moment=${n}`), pictured[0].number);
  await page.mouse.move(10, 10);
  assert.equal(await moment_shown(), pictured[0].number);
});

test('a kept moment is the picture of then, also after a reload', async () => {
  const [first] = await charted();
  await page.reload();
  await wait_for_tiles(page, 0);
  const shown = await canvas_pixels(page, 0);
  const expected = await png_pixels(page, `/v1/jobs/${guided}/image.png?moment=${first.number}`);
  const off = (a, b) => a.reduce((sum, v, i) => sum + Math.abs(v - b[i]), 0) / a.length;
  const now = await png_pixels(page, `/v1/jobs/${guided}/image.png`);
  assert.ok(off(shown, expected) < 1, `off by ${off(shown, expected)}`);
  assert.ok(off(shown, now) > 5, `the picture of now is ${off(shown, now)} away`);
  const png = await page.locator('.panel-png:visible').getAttribute('href');
  assert.equal(png, `/v1/jobs/${guided}/image.png?moment=${first.number}&exposure=0`);
});

test('the slider and the keys go through the moments', async () => {
  const pictured = (await metrics(guided)).moments.filter(({ picture }) => picture);
  const slider = page.locator('#moment');
  await slider.focus();
  await page.keyboard.press('ArrowRight');
  const at = pictured.findIndex(({ noise }) => noise > 0);
  assert.equal(await moment_shown(), pictured[at + 1].number);
  assert.match(await slider.getAttribute('aria-valuetext'),
    new RegExp(`^pass ${pictured[at + 1].number}: `));
  await page.locator('.stage').focus();
  await page.keyboard.press('[');
  assert.equal(await moment_shown(), pictured[at].number);
  await page.getByRole('button', { name: 'Newest' }).click();
  assert.equal(await moment_shown(), null);
});

test('the curve grows while a job runs', async () => {
  const { job } = await post_by_form(page, { scene: 'cornell-box', method: 'huang',
    budget: 'seconds', amount: 60, width: 96, height: 96 });
  const points = () => page.evaluate(() => Number(document.querySelector('#moment').max));
  await page.waitForFunction(() => Number(document.querySelector('#moment').max) >= 2);
  const some = await points();
  await page.waitForFunction((than) => Number(document.querySelector('#moment').max) > than, some);
  await page.getByRole('button', { name: 'Cancel' }).click();
  await wait_for_state(page, job, 'Canceled');
  assert.ok((await words(job).textContent()).includes('after'));
});

test('without the library there is no chart, and the rest is there', async () => {
  const bare = await all.browser.page('about:blank', { ready: 'body' });
  await bare.route('**/lib/**', (route) => route.fulfill({ status: 404, body: '' }));
  await bare.goto(`${all.server.url}/#job=${guided}`);
  await bare.locator('.error-no-chart').filter({ hasText: 'built without uPlot' }).waitFor();
  assert.equal(await bare.locator('.error-chart').isVisible(), false);
  await bare.locator('.error-words li').filter({ hasText: ' after ' }).waitFor();
  assert.ok(await bare.locator('#moment').isVisible());
  await bare.context().close();
});
