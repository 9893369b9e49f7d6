// The page that `qray chart` writes, opened from the disk: the split view by mouse, touch and
// keyboard, what it shows when asked for something else, its widths, and its print.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { existsSync } from 'node:fs';
import { join } from 'node:path';
import { after, afterEach, before, test } from 'node:test';
import { pathToFileURL } from 'node:url';
import { Browser, env, scratch_folder, screenshot } from './support.mjs';

const folder = scratch_folder();
const url = pathToFileURL(join(folder, 'index.html')).href;
let browser;
let page;
before(async () => {
  execFileSync(env('QRAY'), ['chart', 'cornell-box', '--quick', '--quiet', '--methods',
    'none,huang-published,huang', '--warm', '-o', folder], { stdio: 'inherit' });
  browser = await Browser.start();
  page = await open();
});
after(() => browser?.close());
afterEach(() => browser.expect_no_errors());

const open = (options = {}) => browser.page(url, { ready: 'select.left option', ...options });
const in_view = (selector, on = page) => on.locator(`.compare ${selector}`);
const source = async (side) => decodeURI(new URL(await in_view(`.sheet .${side}`)
  .evaluate((image) => image.src)).pathname).slice(folder.length + 1);
const value = async () => Number(await in_view('input').inputValue());

// Where the frame is, once all of it is in the window.
async function frame_box(on = page) {
  await in_view('.frame', on).evaluate((frame) => frame.scrollIntoView({ block: 'center' }));
  return in_view('.stage', on).boundingBox();
}

// The right picture begins where the divider stands.
async function expect_split(percent) {
  assert.ok(Math.abs(await value() - percent) <= 1, `expected ${percent} %: ${await value()} %`);
  const box = await in_view('.stage').boundingBox();
  const handle = await in_view('.handle').boundingBox();
  const line = handle.x + handle.width / 2 - box.x;
  assert.ok(Math.abs(line - box.width * percent / 100) <= box.width / 90, `line at ${line} px`);
  const clip = await in_view('.sheet .right').evaluate((image) => image.style.clipPath);
  const left_px = Number(/inset\(0px 0px 0px ([\d.]+)px\)/.exec(clip)[1]);
  const scrolled = await in_view('.stage').evaluate((stage) => stage.scrollLeft);
  assert.ok(Math.abs(left_px - line - scrolled) < 1, `clipped at ${left_px}, line at ${line}`);
}

test('every picture is there, and it begins with none against another', async () => {
  const broken = await page.locator('img').evaluateAll(async (images) => {
    await Promise.allSettled(images.map((image) => image.decode()));
    return images.filter((image) => image.naturalWidth === 0).map((image) => image.src);
  });
  assert.deepEqual(broken, []);
  assert.equal(await source('left'), 'cornell-box/none.png');
  assert.notEqual(await source('right'), 'cornell-box/none.png');
  for (const link of await page.locator('footer a, .plot a').all()) {
    const file = await link.getAttribute('href');
    assert.ok(existsSync(join(folder, file)), `${file} is not there`);
  }
  await screenshot(page, 'chart-1280');
});

test('the divider moves by mouse and keyboard', async () => {
  const box = await frame_box();
  const y = box.y + box.height / 3;
  await page.mouse.move(box.x + box.width / 2 + 5, y);
  await page.mouse.down();
  await page.mouse.move(box.x + box.width * 0.25, y, { steps: 4 });
  await page.mouse.up();
  await expect_split(25);
  await page.mouse.move(box.x + box.width * 0.9, y); // the button is up: nothing moves
  await expect_split(25);
  const range = page.getByRole('slider', { name: 'Divider between the two pictures' });
  await range.focus();
  const before_key = await value();
  await page.keyboard.press('ArrowRight');
  assert.equal(await value(), before_key + 0.5);
  await page.keyboard.press('End');
  await expect_split(100);
});

test('pictures and error maps are chosen, and a biased method says how far it is off', async () => {
  await in_view('select.left').selectOption('reference');
  await in_view('select.right').selectOption('huang-published, biased');
  assert.equal(await source('left'), 'cornell-box/reference.png');
  assert.equal(await source('right'), 'cornell-box/huang-published.png');
  assert.match(await in_view('.captions .right .badge').textContent(),
    /^biased: [\d.]+ (times|%) too bright$/);
  assert.equal(await in_view('.captions .left').textContent(), 'reference');
  assert.equal(await in_view('.scale').isVisible(), false);
  await in_view('.what').selectOption('error');
  assert.equal(await source('left'), 'cornell-box/reference.png'); // has no error map
  assert.equal(await source('right'), 'cornell-box/huang-published-error.png');
  assert.equal(await in_view('.scale').isVisible(), true);
});

test('zoomed, a drag moves the pictures and the line stays', async () => {
  const range = page.getByRole('slider');
  await range.fill('50');
  await in_view('.zoom').selectOption('4');
  await expect_split(50);
  const box = await frame_box();
  const sheet = await in_view('.sheet').boundingBox();
  assert.ok(sheet.width > 3.9 * box.width && sheet.width < 4.1 * box.width);
  assert.equal(await in_view('.sheet .left').evaluate((image) =>
    getComputedStyle(image).imageRendering), 'pixelated');
  const scrolled = () => in_view('.stage').evaluate((stage) => stage.scrollLeft);
  const from = await scrolled();
  await page.mouse.move(box.x + 60, box.y + 60);
  await page.mouse.down();
  await page.mouse.move(box.x + 20, box.y + 60, { steps: 4 });
  await page.mouse.up();
  assert.equal(await scrolled(), from + 40);
  await expect_split(50);
  await screenshot(page, 'chart-zoomed-1280');
});

test('on a phone nothing scrolls sideways, and a finger moves the divider', async () => {
  for (const colorScheme of ['light', 'dark']) {
    const phone = await open({ width: 390, height: 844, colorScheme, hasTouch: true,
      isMobile: true });
    assert.equal(await phone.evaluate(() => document.documentElement.scrollWidth), 390);
    const box = await frame_box(phone);
    const touch = await phone.context().newCDPSession(phone);
    const finger = (type, share) => touch.send('Input.dispatchTouchEvent', { type, touchPoints:
      share === null ? [] : [{ x: box.x + box.width * share, y: box.y + box.height / 2 }] });
    await finger('touchStart', 0.5);
    for (const share of [0.6, 0.7, 0.8]) await finger('touchMove', share);
    await finger('touchEnd', null);
    const moved = Number(await in_view('input', phone).inputValue());
    assert.ok(Math.abs(moved - 80) <= 1, `the divider is at ${moved} %`);
    await screenshot(phone, `chart-390-${colorScheme}`);
    await phone.context().close();
  }
});

test('printed, all pictures stand in rows', async () => {
  const print = await open({ width: 720, colorScheme: 'dark' });
  await print.emulateMedia({ media: 'print' });
  assert.equal(await print.locator('.compare').isVisible(), false);
  const shots = print.locator('.shots figure');
  assert.equal(await shots.count(), 1 + 3 + 2); // the reference, three methods, two also warm
  const tops = await shots.evaluateAll((all) => all.map((shot) =>
    shot.getBoundingClientRect().top));
  assert.equal(new Set(tops.slice(0, 4)).size, 1);
  const paper = await print.evaluate(() => getComputedStyle(document.body).backgroundColor);
  assert.equal(paper, 'rgb(255, 255, 255)');
  await screenshot(print, 'chart-print');
  await print.context().close();
});

test('without scripts all pictures are there', async () => {
  const plain = await open({ javaScriptEnabled: false });
  assert.equal(await plain.locator('.compare').isVisible(), false);
  assert.equal(await plain.locator('.shots .error').first().isVisible(), true);
  await plain.context().close();
});
