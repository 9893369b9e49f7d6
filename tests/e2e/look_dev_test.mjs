// How a picture is looked at: channels, offset, stripes where it is clipped, the histogram, and the
// picture as a file as it is shown.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { after, afterEach, before, test } from 'node:test';
import { screenshot, start_all, wait_for_tiles } from './support.mjs';

const kSize = 96;
const kJob = { scene: 'cornell-box', width: kSize, height: kSize, samples: 16 };
let all;
let guided;
let plain;
before(async () => {
  all = await start_all();
  guided = await all.server.post({ ...kJob, method: 'huang' });
  plain = await all.server.post({ ...kJob, method: 'none' });
  for (const id of [guided, plain]) {
    await all.server.wait_until(id, ({ state }) => state === 'succeeded');
  }
});
after(() => all?.close());
afterEach(() => all.browser.expect_no_errors());

async function open(hash, options) {
  const page = await all.browser.page(`${all.server.url}/#job=${plain}${hash}`, options);
  await wait_for_tiles(page, 0);
  return page;
}
// The shown colour at a pixel, 0..255, and its radiance.
const at = (page, x, y) => page.evaluate(async ([px, py]) => {
  const { viewer } = await import('/app.js');
  const [picture] = viewer.pictures;
  const first = 4 * (py * picture.width + px);
  return { color: [...picture.read_pixels().slice(first, first + 3)],
    radiance: picture.radiance(px, py) };
}, [x, y]);
const srgb = (v) => 255 * (v <= 0.0031308 ? 12.92 * v : 1.055 * v ** (1 / 2.4) - 0.055);
const clamp = (v) => Math.min(Math.max(v, 0), 1);

test('a channel alone is grey, and an offset is added after the exposure', async () => {
  const page = await open('');
  const [x, y] = [10, 50]; // on the red wall
  const { radiance } = await at(page, x, y);
  assert.ok(radiance[0] > 3 * radiance[1], radiance.join(' '));
  for (const [channel, value] of [['r', radiance[0]], ['g', radiance[1]], ['luminance',
    0.2126 * radiance[0] + 0.7152 * radiance[1] + 0.0722 * radiance[2]]]) {
    await page.locator('#channel').selectOption(channel);
    const { color } = await at(page, x, y);
    color.forEach((v) => assert.ok(Math.abs(v - srgb(clamp(value))) < 1.5, `${channel}: ${color}`));
  }
  await page.keyboard.press('Escape');
  await page.locator('#channel').selectOption('');
  await page.evaluate(async () => (await import('/app.js')).address.set({ ev: 1, offset: 0.25 }));
  const { color } = await at(page, x, y);
  color.forEach((v, i) => assert.ok(
    Math.abs(v - srgb(clamp(2 * radiance[i] + 0.25))) < 1.5, `${color} of ${radiance}`));
});

test('stripes stand where the picture is clipped, and nowhere else', async () => {
  const page = await open('&clipped=on');
  assert.ok(await page.locator('#clipped').isChecked());
  const counts = await page.evaluate(async () => {
    const { viewer } = await import('/app.js');
    const [picture] = viewer.pictures;
    const bytes = picture.read_pixels();
    const found = { clipped: 0, striped: 0, wrong: 0 };
    for (let y = 0; y < picture.height; ++y) {
      for (let x = 0; x < picture.width; ++x) {
        const values = picture.radiance(x, y);
        const out = Math.max(...values) > 1 || Math.max(...values) <= 0;
        const color = bytes.slice(4 * (y * picture.width + x), 4 * (y * picture.width + x) + 3);
        const striped = [[255, 25.5, 25.5], [25.5, 76.5, 255]].some((stripe) =>
          stripe.every((v, i) => Math.abs(v - color[i]) <= 1));
        found.clipped += out;
        found.striped += striped;
        found.wrong += striped && !out;
      }
    }
    return found;
  });
  assert.equal(counts.wrong, 0);
  assert.ok(counts.clipped > 50 && counts.striped > 0.3 * counts.clipped &&
    counts.striped < 0.7 * counts.clipped, JSON.stringify(counts));
});

test('the histogram tells least, greatest and mean as they are', async () => {
  for (const width of [1280, 390]) {
    const page = await open('', { width });
    await page.locator('#histogram summary').click();
    const words = page.locator('#histogram figcaption').first();
    await words.filter({ hasText: 'luminance' }).waitFor();
    const wanted = await page.evaluate(async () => {
      const { viewer } = await import('/app.js');
      const [picture] = viewer.pictures;
      let [sum, greatest] = [0, 0];
      for (let i = 0; i < picture.width * picture.height; ++i) {
        const [r, g, b] = picture.radiance(i % picture.width, Math.floor(i / picture.width));
        const bright = 0.2126 * r + 0.7152 * g + 0.0722 * b;
        sum += bright;
        greatest = Math.max(greatest, bright);
      }
      return { mean: sum / (picture.width * picture.height), greatest };
    });
    const [, greatest, mean] = (await words.textContent()).match(/ to ([\d.]+), mean ([\d.]+)/);
    assert.ok(Math.abs(greatest / wanted.greatest - 1) < 0.01, greatest);
    assert.ok(Math.abs(mean / wanted.mean - 1) < 0.01, mean);
    await words.scrollIntoViewIfNeeded();
    await screenshot(page, `look-dev-${width}`);
    assert.equal(await page.evaluate(() => document.documentElement.scrollWidth), width);
  }
});

test('the picture is saved as it is shown, with the divider of two', async () => {
  const page = await open(`&with=${guided}&ev=1&curve=filmic&split=25`);
  await wait_for_tiles(page, 1);
  const [download] = await Promise.all([page.waitForEvent('download'),
    page.locator('#snapshot').click()]);
  assert.equal(download.suggestedFilename(), `${plain}-${guided}.png`);
  const png = readFileSync(await download.path()).toString('base64');
  const wrong = await page.evaluate(async (data) => {
    const file = Uint8Array.from(atob(data), (c) => c.charCodeAt(0));
    const image = await createImageBitmap(new Blob([file], { type: 'image/png' }));
    const context = new OffscreenCanvas(image.width, image.height).getContext('2d');
    context.drawImage(image, 0, 0);
    const bytes = context.getImageData(0, 0, image.width, image.height).data;
    const { viewer } = await import('/app.js');
    const sides = viewer.pictures.slice(0, 2).map((picture) => picture.read_pixels());
    let off = image.width === viewer.pictures[0].width ? 0 : 1e9;
    for (let i = 0; i < bytes.length; ++i) {
      const x = (i >> 2) % image.width;
      off += Math.abs(bytes[i] - sides[x < image.width / 4 ? 0 : 1][i]) > 0;
    }
    return off;
  }, png);
  assert.equal(wrong, 0);
});
