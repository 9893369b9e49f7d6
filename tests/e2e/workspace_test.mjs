// The workspace: the picture, its chart and the jobs are in view together, each pane scrolls by
// itself, and on a phone one swipes between them.
import assert from 'node:assert/strict';
import { after, afterEach, before, test } from 'node:test';
import { screenshot, start_all, wait_for, wait_for_tiles } from './support.mjs';

const kJobs = 30;
let all;
let job;
before(async () => {
  all = await start_all();
  const small = { scene: 'cornell-box', method: 'none', samples: 4, width: 64, height: 64 };
  for (let i = 0; i < kJobs; ++i) job = await all.server.post({ ...small, seed: i + 1 });
  await all.server.wait_until(job, ({ state }) => state === 'succeeded');
});
after(() => all?.close());
afterEach(() => all.browser.expect_no_errors());

const open = async (size, hash = `#job=${job}`) => {
  const page = await all.browser.page(`${all.server.url}/${hash}`, size);
  if (hash.includes('job=')) await wait_for_tiles(page, 0);
  return page;
};
// Whether all of it is seen.
async function expect_seen(page, selector) {
  const { width, height } = page.viewportSize();
  const box = await page.locator(selector).boundingBox();
  assert.ok(box && box.x >= 0 && box.y >= 0 && box.x + box.width <= width &&
    box.y + box.height <= height, `${selector} at ${width}: ${JSON.stringify(box)}`);
}
const sizes_of = (page) => page.evaluate(() => {
  const { scrollWidth, scrollHeight } = document.documentElement;
  return [scrollWidth, scrollHeight];
});

for (const [width, height] of [[801, 900], [1000, 900], [1280, 900], [1920, 1080]]) {
  test(`picture, chart, form and jobs are in view together at ${width} px`, async () => {
    const page = await open({ width, height });
    await page.locator('.u-over').waitFor();
    assert.deepEqual(await sizes_of(page), [width, height]);
    for (const part of ['.stage', '.error-chart canvas', '#job-form [type=submit]', '#find',
      `#jobs [data-job="${job}"]`]) await expect_seen(page, part);
    for (const pane of ['picture-pane', 'facts-pane']) {
      const beyond = await page.locator(`#${pane}`).evaluate((place) =>
        place.scrollWidth - place.clientWidth);
      assert.equal(beyond, 0, `${pane} scrolls sideways`);
    }
    await screenshot(page, `workspace-${width}`);
    await page.context().close();
  });
}

test('a job far down the list leaves its picture in view', async () => {
  const page = await open({});
  const last = page.locator('#jobs li').last();
  await last.scrollIntoViewIfNeeded();
  assert.ok(await page.locator('#jobs').evaluate((list) => list.scrollTop) > 200);
  await last.locator('a').click();
  await wait_for_tiles(page, 0);
  await page.waitForFunction((old) => !location.hash.includes(old), job);
  await expect_seen(page, '.stage');
  assert.deepEqual(await sizes_of(page), [1280, 900]);
  await page.context().close();
});

const shown_tab = (page) => page.locator('#panes [aria-current]').textContent();
const left_of = (page, pane) => page.locator(`#${pane}`).evaluate((place) =>
  Math.round(place.getBoundingClientRect().left));

test('on a phone tabs and swipes lead from pane to pane', async () => {
  const page = await open({ width: 390, height: 844, hasTouch: true });
  await wait_for(page, () => document.querySelector('#panes [aria-current]')
    .dataset.pane === 'picture-pane'); // a link of a job leads to its picture
  await expect_seen(page, '.stage');
  assert.deepEqual(await sizes_of(page), [390, 844]);
  await page.locator('[data-pane=facts-pane]').tap();
  await wait_for(page, () => document.querySelector('#panes [aria-current]')
    .dataset.pane === 'facts-pane');
  await expect_seen(page, '.error-chart canvas');
  // A swipe that ends between two panes goes on to one of them.
  const session = await page.context().newCDPSession(page);
  const touch = (type, ...touchPoints) =>
    session.send('Input.dispatchTouchEvent', { type, touchPoints });
  await touch('touchStart', { x: 90, y: 170 });
  for (let x = 100; x <= 330; x += 10) await touch('touchMove', { x, y: 170 });
  await touch('touchEnd');
  await wait_for(page, () => document.querySelector('#panes [aria-current]')
    .dataset.pane === 'picture-pane');
  await wait_for(page, () => Math.abs(document.getElementById('picture-pane')
    .getBoundingClientRect().left - 12) < 1);
  assert.equal(await left_of(page, 'scenes-pane'), 12 - 390);
  await screenshot(page, 'workspace-390');
  await page.locator('[data-pane=scenes-pane]').tap();
  await page.locator('#jobs a').nth(3).tap();
  await wait_for(page, () => document.querySelector('#panes [aria-current]')
    .dataset.pane === 'picture-pane');
  assert.equal(await shown_tab(page), 'Picture');
  await page.context().close();
});
