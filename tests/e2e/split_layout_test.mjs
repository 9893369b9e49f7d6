// Two jobs side by side with a divider, and the page at a phone's width, in the dark, and without
// WebGL2. Leaves screenshots in the build folder.
import assert from 'node:assert/strict';
import { after, afterEach, before, test } from 'node:test';
import { pictures, post_by_form, screenshot, start_all, wait_for_state,
  wait_for_tiles } from './support.mjs';

let all;
let page;
let shown;
before(async () => {
  all = await start_all();
  page = await all.browser.page(all.server.url);
});
after(() => all?.close());
afterEach(() => all.browser.expect_no_errors());

const clip = (name) => page.locator(`.pane.${name}`)
  .evaluate((canvas) => getComputedStyle(canvas).clipPath);

test('a job and its twin without learning form side by side, the latter on the left', async () => {
  shown = await post_by_form(page, { scene: 'ajar-door', method: 'huang', budget: 'samples',
    amount: 16, width: 256, height: 160, twin: true });
  assert.ok(shown.job && shown.with);
  assert.equal((await all.server.job(shown.with)).request.method, 'none');
  await wait_for_tiles(page, 0);
  await wait_for_tiles(page, 1);
  const [left, right] = await pictures(page);
  assert.deepEqual([left.job, right.job], [shown.with, shown.job]);
  assert.equal(await page.locator('.view-left-label').textContent(), 'no learning');
  assert.equal(await page.locator('.view-right-label').textContent(), 'huang');
  await wait_for_state(page, shown.job, 'Done');
  await wait_for_state(page, shown.with, 'Done');
  await screenshot(page, 'split-1280');
});

test('the divider moves by keyboard and by dragging', async () => {
  const divider = page.getByRole('slider', { name: 'Divider between the two pictures' });
  assert.equal(await divider.inputValue(), '50');
  await divider.focus();
  await page.keyboard.press('ArrowLeft');
  assert.equal(await divider.inputValue(), '49.5');
  await page.keyboard.press('End');
  assert.equal(await divider.inputValue(), '100');
  assert.equal(await clip('right'), 'inset(0px 0px 0px 100%)');

  const stage = await page.locator('.stage').boundingBox();
  const [y, at] = [stage.y + stage.height / 2, (share) => stage.x + stage.width * share];
  await page.mouse.move(at(1) - 2, y);
  await page.mouse.down();
  await page.mouse.move(at(0.5), y, { steps: 4 });
  await page.mouse.move(at(0.25), y, { steps: 4 });
  await page.mouse.up();
  const value = Number(await divider.inputValue());
  assert.ok(Math.abs(value - 25) <= 1.5, `dragged to a quarter, the divider is at ${value} %`);
  assert.equal(await clip('right'), `inset(0px 0px 0px ${value}%)`);
});

test('another job is chosen from the list, and the address keeps both', async () => {
  await page.locator('#compare').selectOption('');
  await page.waitForFunction(() => !location.hash.includes('with='));
  assert.equal(await page.locator('.view-divider').isVisible(), false);
  assert.equal(await page.locator('.panel:visible').count(), 1);
  await page.locator('#compare').selectOption(shown.with);
  await page.waitForFunction(() => location.hash.includes('with='));
  await page.reload();
  await wait_for_tiles(page, 1);
  assert.equal(await page.locator('.panel:visible').count(), 2);
});

test('nothing scrolls sideways at 390 px and at 1,000 px, light or dark', async () => {
  const address = `${all.server.url}/#job=${shown.job}&with=${shown.with}`;
  for (const [width, colorScheme] of [[390, 'light'], [390, 'dark'], [1000, 'dark'],
    [1280, 'light']]) {
    const other = await all.browser.page(address, { width, height: 844, colorScheme });
    await wait_for_tiles(other, 1);
    await other.locator('#new-job').evaluate((details) => {
      details.open = true;
    });
    const widest = await other.evaluate(() => document.documentElement.scrollWidth);
    assert.equal(widest, width);
    await screenshot(other, `page-${width}-${colorScheme}`);
    await other.context().close();
  }
});

test('on a phone a posted job brings its picture into view', async () => {
  const phone = await all.browser.page(all.server.url, { width: 390, height: 844 });
  await post_by_form(phone, { scene: 'cornell-box', amount: 2, width: 64, height: 64 });
  await wait_for_tiles(phone, 0);
  assert.equal(await phone.locator('#new-job').evaluate((details) => details.open), false);
  const stage = await phone.locator('.stage').boundingBox();
  assert.ok(stage.y >= 0 && stage.y < 844, `the picture is at ${stage.y}`);
  await screenshot(phone, 'posted-390');
  await phone.context().close();
});

test('without WebGL2 the page says so and still offers the downloads', async () => {
  const plain = await all.browser.page(`${all.server.url}/#job=${shown.job}`, {
    init: () => {
      const get_context = HTMLCanvasElement.prototype.getContext;
      HTMLCanvasElement.prototype.getContext = function (kind, ...rest) {
        return kind === 'webgl2' ? null : get_context.call(this, kind, ...rest);
      };
    },
  });
  await plain.locator('.view-no-webgl').waitFor();
  assert.match(await plain.locator('.view-no-webgl').textContent(), /no WebGL2/);
  const png = plain.locator('.panel-png:visible');
  await png.waitFor();
  await all.server.get(await png.getAttribute('href'));
  await plain.context().close();
});
