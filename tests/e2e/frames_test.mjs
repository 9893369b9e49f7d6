// A job of many frames on the page: the strip that comes while they form, the slider, the film over
// the stage, links, and what a frame that is not there yet looks like.
import assert from 'node:assert/strict';
import { after, afterEach, before, test } from 'node:test';
import { screenshot, start_all } from './support.mjs';

const kJob = { scene: 'cornell-box', method: 'none', samples: 16, width: 96, height: 96,
  frames: { turntable: 8, degrees: 40 } };
let all;
let page;
let job;
before(async () => {
  all = await start_all();
  job = await all.server.post(kJob);
  page = await all.browser.page(`${all.server.url}/#job=${job}`);
  await all.server.wait_until(job, ({ state }) => state === 'succeeded');
  await page.locator('.frames-progress', { hasText: '8 of 8 frames done' }).waitFor();
});
after(() => all?.close());
afterEach(() => all.browser.expect_no_errors());

const frame = (n) => page.locator(`.frames-strip button[data-frame="${n}"]`);
const pressed = () => page.locator('.frames-strip button[aria-pressed="true"]')
  .evaluateAll((buttons) => buttons.map(({ dataset }) => dataset.frame));
const stage = () => page.evaluate(async () => {
  const { viewer } = await import('/app.js');
  const [{ frame, job_id, has_picture }] = viewer.pictures;
  return { frame, job_id, has_picture };
});

test('each frame has a small picture, its state and samples', async () => {
  await page.locator('.frames-strip canvas.drawn').nth(7).waitFor();
  assert.equal(await page.locator('.frames-strip button').count(), 8);
  assert.equal(await frame(5).getAttribute('aria-label'), 'Frame 5, done, 16 samples a pixel');
  assert.deepEqual(await pressed(), ['0']);
  await screenshot(page, 'frames-1280');
});

test('a click shows a frame on the stage, and the address keeps it', async () => {
  await frame(3).click();
  await page.waitForFunction(async () => {
    const { viewer } = await import('/app.js');
    return viewer.pictures[0].frame === 3 && viewer.pictures[0].cursor > 0n;
  });
  assert.deepEqual(await stage(), { frame: 3, job_id: job, has_picture: true });
  assert.deepEqual(await pressed(), ['3']);
  assert.match(page.url(), /frame=3/);
  assert.match(await page.locator('.panel-exr').first().getAttribute('href'), /frame=3/);
});

test('the slider scrubs by keys', async () => {
  await page.locator('#frame').focus();
  await page.keyboard.press('ArrowRight');
  await page.waitForFunction(() => location.hash.includes('frame=4'));
  assert.deepEqual(await pressed(), ['4']);
  await page.keyboard.press('Home');
  await page.waitForFunction(() => !location.hash.includes('frame='));
});

test('the film plays over the stage and stops at the frame that it shows', async () => {
  await page.locator('.frames-play').click();
  assert.equal(await page.locator('.frames-play').textContent(), 'Pause');
  await page.locator('#frames-player:not([hidden])').waitFor();
  const seen = new Set();
  for (let i = 0; i < 200 && seen.size < 4; ++i) {
    (await pressed()).forEach((n) => seen.add(n));
    await page.waitForTimeout(20);
  }
  assert.ok(seen.size >= 4, [...seen].join());
  await page.locator('.frames-play').click();
  await page.locator('#frames-player').waitFor({ state: 'hidden' });
  assert.equal(String((await stage()).frame), (await pressed())[0]);
});

test('all frames are fetched as an archive and as a film', async () => {
  const href = (n) => page.locator('.frames-downloads a').nth(n).getAttribute('href');
  const head = async (n) => {
    const answer = await fetch(all.server.url + await href(n));
    assert.equal(answer.status, 200, await href(n));
    return Buffer.from(await answer.arrayBuffer()).toString('latin1', 0, 3);
  };
  assert.equal(await head(0), 'PK\x03');
  assert.equal(await head(1), 'PK\x03');
  assert.equal(await head(2), 'GIF');
});

test('a frame without a picture is empty, and fills while the job goes on', async () => {
  const slow = await all.server.post({ ...kJob, samples: 1000 });
  await all.server.wait_until(slow, ({ state }) => state !== 'queued');
  await page.goto(`${all.server.url}/#job=${slow}&frame=4`); // the second in their order
  await page.waitForFunction(async (id) => {
    const { viewer } = await import('/app.js');
    const [picture] = viewer.pictures;
    return picture.job_id === id && picture.frame === 4 && !picture.has_picture;
  }, slow);
  await page.waitForFunction(async () => {
    const { viewer } = await import('/app.js');
    return viewer.pictures[0].cursor > 0n;
  });
  await page.locator('.frames-strip canvas.drawn').first().waitFor();
  await screenshot(page, 'frames-forming-1280');
  await fetch(`${all.server.url}/v1/jobs/${slow}/cancel`, { method: 'POST' });
});

test('a job without frames has no strip', async () => {
  const id = await all.server.post({ ...kJob, frames: undefined, samples: 1 });
  await all.server.wait_until(id, ({ state }) => state === 'succeeded');
  await page.goto(`${all.server.url}/#job=${id}&frame=3`);
  await page.waitForFunction(async (shown) => {
    const { viewer } = await import('/app.js');
    return viewer.pictures[0].job_id === shown && viewer.pictures[0].has_picture;
  }, id);
  assert.ok(await page.locator('#frames').isHidden());
});

test('on a phone the strip scrolls, the page does not', async () => {
  const phone = await all.browser.page(`${all.server.url}/#job=${job}&frame=2`,
    { width: 390, height: 844 });
  await phone.locator('.frames-strip canvas.drawn').nth(2).waitFor();
  assert.ok(await phone.evaluate(() =>
    document.documentElement.scrollWidth <= document.documentElement.clientWidth));
  await phone.locator('#frames').scrollIntoViewIfNeeded();
  await screenshot(phone, 'frames-390');
});

test('the form posts a turntable', async () => {
  await page.goto(`${all.server.url}/#`);
  await page.locator('#new-job').evaluate((details) => { details.open = true; });
  await page.locator('.more summary').click();
  await page.locator('#scene').selectOption('furnace');
  await page.locator('[name="width"]').fill('32');
  await page.locator('[name="height"]').fill('32');
  await page.locator('#amount').fill('1');
  await page.locator('[name="frames.turntable"]').fill('5');
  await page.locator('[name="frames.degrees"]').fill('10');
  await page.locator('#job-form button[type="submit"]').click();
  await page.locator('.frames-strip button').nth(4).waitFor();
  const { jobs: [posted] } = await (await all.server.get('/v1/jobs?limit=1')).json();
  assert.deepEqual(posted.request.frames, { turntable: 5, degrees: 10 });
});
