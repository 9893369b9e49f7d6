// From the form to the finished picture: tiles come while it renders, the canvas shows what the
// server's PNG has, exposure asks for nothing, and wrong values are answered at their fields.
import assert from 'node:assert/strict';
import { after, afterEach, before, test } from 'node:test';
import { display_values, expect_inside } from './rgb9e5.mjs';
import { canvas_pixels, png_pixels, post_by_form, screenshot, start_all, wait_for_picture,
  wait_for_state, wait_for_tiles } from './support.mjs';

let all;
let page;
let job;
before(async () => {
  all = await start_all();
  page = await all.browser.page(all.server.url);
});
after(() => all?.close());
afterEach(() => all.browser.expect_no_errors());

// 200 x 136: the tiles at the right and lower edges are cut.
const kFields = { scene: 'cornell-box', method: 'huang', width: 200, height: 136, seed: 7 };

test('the picture forms tile by tile while the job runs', async () => {
  // Far more time than the slowest machine takes for what is looked at here.
  const { job: long_job } =
    await post_by_form(page, { ...kFields, budget: 'seconds', amount: 300 });
  assert.match(long_job, /^j\d+$/);
  const first = await wait_for_tiles(page, 0);
  assert.deepEqual([first.width, first.height], [200, 136]);
  await wait_for_state(page, long_job, 'Learning|Rendering');
  // From here on only `progress` hints can bring tiles, until the job leaves this state.
  let last = await wait_for_tiles(page, 0);
  for (let i = 0; i < 2; ++i) {
    const next = await wait_for_tiles(page, 0, last.tile_updates);
    assert.ok(next.cursor > last.cursor, `cursor ${last.cursor}, then ${next.cursor}`);
    last = next;
  }
  assert.match((await all.server.job(long_job)).state, /^(learning|rendering)$/);
  await screenshot(page, 'forming-1280');
  await fetch(`${all.server.url}/v1/jobs/${long_job}/cancel`, { method: 'POST' });
  await wait_for_state(page, long_job, 'Canceled');
});

test('the form leads to a finished picture', async () => {
  ({ job } = await post_by_form(page, { ...kFields, budget: 'samples', amount: 8 }));
  await wait_for_state(page, job, 'Done');
  const row = page.locator(`#jobs [data-job="${job}"]`);
  assert.equal(await row.locator('.row-state').textContent(), 'Done');
  assert.equal((await all.server.job(job)).request.seed, 7);
});

test('the canvas shows the pixels of image.png', async () => {
  const tiles = await (await all.server.get(`/v1/jobs/${job}/tiles?since=0`)).arrayBuffer();
  const newest = Number(new DataView(tiles).getBigUint64(12, true));
  await wait_for_picture(page, 0, (picture) => picture.cursor === newest);
  const expected = display_values(tiles);
  expect_inside(await canvas_pixels(page, 0), expected, true);
  expect_inside(await png_pixels(page, `/v1/jobs/${job}/image.png`), expected, false);
});

test('exposure changes the picture and asks the server for no tiles', async () => {
  let requests = 0;
  const watch = (request) => {
    if (request.url().includes('/tiles')) ++requests;
  };
  page.on('request', watch);
  await page.locator('#exposure').fill('1.5');
  assert.equal(await page.locator('.view-exposure-value').textContent(), '+1.5 EV');
  const tiles = await (await all.server.get(`/v1/jobs/${job}/tiles?since=0`)).arrayBuffer();
  const expected = display_values(tiles, 1.5);
  expect_inside(await canvas_pixels(page, 0), expected, true);
  const png = await page.locator('.panel-png:visible').getAttribute('href');
  assert.equal(png, `/v1/jobs/${job}/image.png?picture=sampled&exposure=1.5`);
  expect_inside(await png_pixels(page, png), expected, false);
  page.off('request', watch);
  assert.equal(requests, 0);
  await page.getByRole('button', { name: 'Auto' }).click();
  const chosen = (await all.server.get(`/v1/jobs/${job}/image.png?picture=sampled&exposure=auto`))
    .headers.get('qray-exposure');
  const shown = Math.round(chosen * 10) / 10;
  await page.waitForFunction(
    (ev) => Number(document.querySelector('#exposure').value) === ev, shown);
  await page.getByRole('button', { name: 'Reset' }).click();
  assert.equal(await page.locator('.view-exposure-value').textContent(), '0.0 EV');
});

test('the EXR can be downloaded', async () => {
  const [download] = await Promise.all([page.waitForEvent('download'),
    page.locator('.panel-exr:visible').click()]);
  const chunks = [];
  for await (const chunk of await download.createReadStream()) chunks.push(chunk);
  assert.equal(Buffer.concat(chunks).readUInt32LE(0), 20000630); // OpenEXR's magic number
});

test('a refused value is answered at its field', async () => {
  const url = page.url();
  await page.locator('#amount').fill('0');
  await page.locator('#job-form [name=budget]').selectOption('samples');
  await page.locator('#width').fill('0');
  await page.getByRole('button', { name: 'Render' }).click();
  await page.locator('#amount-error').filter({ hasText: /./ }).waitFor();
  const refused = await fetch(`${all.server.url}/v1/jobs`, { method: 'POST',
    headers: { 'content-type': 'application/json' },
    body: '{"scene":"cornell-box","samples":0,"width":0}' });
  assert.equal(refused.status, 422);
  const { errors } = await refused.json();
  const detail = Object.fromEntries(errors.map((e) => [e.pointer, e.detail]));
  assert.equal(await page.locator('#amount-error').textContent(), detail['/samples']);
  assert.equal(await page.locator('#width-error').textContent(), detail['/width']);
  assert.equal(await page.locator('#height-error').textContent(), '');
  assert.equal(await page.locator('#amount').getAttribute('aria-invalid'), 'true');
  assert.equal(await page.evaluate(() => document.activeElement.id), 'amount');
  assert.equal(page.url(), url);
  await page.locator('#amount').fill('2');
  assert.equal(await page.locator('#amount-error').textContent(), '');
  assert.equal(await page.locator('#amount').getAttribute('aria-invalid'), null);
});

test('tiles whose bytes were changed on the way are refused', async () => {
  const answers = await page.evaluate(async (id) => {
    const { crc32c, parse_tiles } = await import('/tiles.js');
    const buffer = await (await fetch(`/v1/jobs/${id}/tiles?since=0`)).arrayBuffer();
    const outcome = (change) => {
      const copy = change(buffer.slice(0));
      try {
        return `${parse_tiles(copy).tiles.length} tiles`;
      } catch (error) {
        return error.message;
      }
    };
    const flip = (at) => (copy) => {
      new Uint8Array(copy)[at] ^= 1;
      return copy;
    };
    return [crc32c(new TextEncoder().encode('123456789')).toString(16), outcome((copy) => copy),
      outcome(flip(0)), outcome(flip(28 + 24 + 5)), outcome((copy) => copy.slice(0, -4)),
      outcome((copy) => copy.slice(0, 20))];
  }, job);
  assert.equal(answers[0], 'e3069283'); // the published check value of CRC-32C
  assert.equal(answers[1], `${Math.ceil(200 / 64) * Math.ceil(136 / 64)} tiles`);
  assert.match(answers[2], /magic/);
  assert.match(answers[3], /tile 0: CRC-32C/);
  assert.match(answers[4], /cut short/);
  assert.match(answers[5], /header/);
});
