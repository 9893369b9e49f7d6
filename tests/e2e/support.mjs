// What every browser test needs: the real server on a free port with a scratch data folder, a
// fresh headless Chromium, and pages that fail the test when the page itself reports an error.
import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import { accessSync, constants, mkdirSync, mkdtempSync, rmSync } from 'node:fs';
import { createRequire } from 'node:module';
import { tmpdir } from 'node:os';
import { delimiter, join } from 'node:path';
import { setTimeout as sleep } from 'node:timers/promises';

const kWaitMs = 60_000; // long enough for a sanitizer build on a busy machine

// A file that hangs ends by itself before ctest kills it, so that no server stays behind.
// Whoever asks for more updates (lasting_test.mjs) has the time.
const kFileMs =
  Number(process.env.QRAY_E2E_MS ?? (process.env.QRAY_E2E_UPDATES ? 3_600_000 : 390_000));
const running = new Set();
const folders = [];
process.on('exit', () => {
  running.forEach((child) => child.kill('SIGKILL'));
  folders.forEach((folder) => rmSync(folder, { recursive: true, force: true }));
});
setTimeout(() => {
  console.error(`not done after ${kFileMs} ms`);
  process.exit(1);
}, kFileMs).unref();

export function env(name) {
  assert.ok(process.env[name], `${name} is not set: run these tests through ctest -L e2e`);
  return process.env[name];
}

function find_chromium() {
  if (process.env.CHROMIUM) return process.env.CHROMIUM;
  for (const folder of env('PATH').split(delimiter)) {
    const file = join(folder, 'chromium');
    try {
      accessSync(file, constants.X_OK);
      return file;
    } catch {
      // not in this folder
    }
  }
  throw new Error('chromium is not installed: apt-get install chromium');
}

// The modules are installed into the build folder, so they are looked up from there.
function load_playwright() {
  return createRequire(join(env('QRAY_E2E_DIR'), 'package.json'))('playwright-core');
}

// Removed when the file of tests ends.
export function scratch_folder() {
  const folder = mkdtempSync(join(tmpdir(), 'qray-e2e-'));
  folders.push(folder);
  return folder;
}

export class Server {
  #process;
  url;

  // Resolves when the server printed where it listens.
  static async start(data_folder, { port = 0, scenes_folder = null, more = [] } = {}) {
    const server = new Server();
    const options = ['--port', String(port), '--data', data_folder, ...more];
    if (scenes_folder) options.push('--scenes', scenes_folder);
    const child = spawn(env('QRAYD'), options, { stdio: ['ignore', 'pipe', 'pipe'] });
    server.#process = child;
    running.add(child);
    child.once('exit', () => running.delete(child));
    let said = '';
    server.url = await new Promise((resolve, reject) => {
      const silent = () => reject(new Error(`qrayd is silent; it said: ${said}`));
      const timer = setTimeout(silent, kWaitMs);
      const listen = (chunk) => {
        said = (said + chunk).slice(-20_000);
        const match = said.match(/qrayd listening on (http:\/\/127\.0\.0\.1:\d+)/);
        if (!match) return;
        clearTimeout(timer);
        resolve(match[1]);
      };
      child.stdout.on('data', listen);
      child.stderr.on('data', listen);
      child.on('error', reject);
      child.on('exit', (code) => reject(new Error(`qrayd ended with ${code}; it said: ${said}`)));
    });
    return server;
  }

  get port() {
    return Number(new URL(this.url).port);
  }

  async stop() {
    if (this.#process.exitCode !== null || this.#process.signalCode !== null) return;
    const ended = new Promise((resolve) => this.#process.once('exit', resolve));
    this.#process.kill('SIGTERM');
    const timer = setTimeout(() => this.#process.kill('SIGKILL'), 10_000);
    await ended;
    clearTimeout(timer);
  }

  async get(path) {
    const response = await fetch(this.url + path);
    assert.equal(response.status, 200, `GET ${path}`);
    return response;
  }

  async job(id) {
    return (await this.get(`/v1/jobs/${id}`)).json();
  }

  async post(request) {
    const response = await fetch(`${this.url}/v1/jobs`, {
      method: 'POST',
      headers: { 'content-type': 'application/json' },
      body: JSON.stringify(request),
    });
    assert.equal(response.status, 202, await response.clone().text());
    return (await response.json()).id;
  }

  // The JSON that the server answers, or null where it answers nothing.
  async call(method, path, body) {
    const response = await fetch(this.url + path, {
      method,
      headers: { 'content-type': 'application/json' },
      body: body && JSON.stringify(body),
    });
    const text = await response.text();
    assert.ok(response.ok, `${method} ${path}: ${response.status} ${text}`);
    return text ? JSON.parse(text) : null;
  }

  async wait_until(id, done, wait_ms = kWaitMs) {
    const until = Date.now() + wait_ms;
    for (;;) {
      const job = await this.job(id);
      if (done(job)) return job;
      assert.ok(Date.now() < until, `job ${id} stays ${job.state}`);
      await sleep(50);
    }
  }
}

export class Browser {
  #browser;
  #errors = [];

  // `args`: more of Chromium's own options.
  static async start(args = []) {
    const browser = new Browser();
    browser.#browser = await load_playwright().chromium.launch({
      executablePath: find_chromium(),
      headless: true,
      args: ['--no-sandbox', '--disable-gpu', '--use-angle=swiftshader',
        '--enable-unsafe-swiftshader', '--disable-quic', '--no-first-run',
        '--disable-background-networking', '--disable-component-update', '--disable-sync',
        ...args],
    });
    return browser;
  }

  // A page of its own profile. Errors in it, and breaches of the content policy, are kept.
  // `init` runs in it before its own scripts. Resolves when `ready` is there. Scenes have no small
  // pictures unless `thumbnails`: each new server would render them all.
  async page(url, { width = 1280, height = 900, init, ready = '#scene option',
    thumbnails = false, ...options } = {}) {
    const context = await this.#browser.newContext({ viewport: { width, height }, ...options });
    if (!thumbnails) {
      await context.route('**/thumbnail.jpg', (route) => route.fulfill({ status: 404 }));
    }
    if (init) await context.addInitScript(init);
    const page = await context.newPage();
    page.setDefaultTimeout(kWaitMs);
    page.on('pageerror', (error) => this.#errors.push(error.stack));
    page.on('console', (message) => {
      // A refused request or a lost server is logged by the browser; tests ask for both.
      const network = message.text().startsWith('Failed to load resource');
      if (message.type() === 'error' && !network) this.#errors.push(message.text());
    });
    await page.goto(url);
    await page.locator(ready).first().waitFor({ state: 'attached' });
    return page;
  }

  // Nothing that a page reported since the last call.
  expect_no_errors() {
    assert.deepEqual(this.#errors.splice(0), []);
  }

  close() {
    return this.#browser.close();
  }
}

// {server, browser, close()} for one file of tests.
export async function start_all(options = {}) {
  const folder = scratch_folder();
  const server = await Server.start(folder, options);
  let browser;
  try {
    browser = await Browser.start();
  } catch (error) {
    await server.stop(); // a child that stays would keep node waiting
    throw error;
  }
  return {
    server, // a test may put another in its place
    browser,
    folder,
    async close() {
      await browser.close();
      await this.server.stop();
    },
  };
}

// Fills the form and posts it; resolves to the ids now in the address.
// Opens the folded options of the form.
export const unfold = (page) => page.locator('.more').evaluate((details) => {
  details.open = true;
});

// Not recovered, unless `fields` says so.
export async function post_by_form(page, fields) {
  const before = page.url();
  await unfold(page);
  for (const [name, value] of Object.entries({ recover: 'none', ...fields })) {
    const field = page.locator(`#job-form [name="${name}"]`);
    if (typeof value === 'boolean') await field.setChecked(value);
    else if (await field.evaluate((e) => e.tagName === 'SELECT')) await field.selectOption(value);
    else await field.fill(String(value));
  }
  await page.locator('#job-form button[type=submit]').click();
  await page.waitForFunction((url) => location.href !== url, before);
  const shown = new URLSearchParams(new URL(page.url()).hash.slice(1));
  return { job: shown.get('job'), with: shown.get('with') };
}

// What the page shows of its pictures, left and right.
export const pictures = (page) => page.evaluate(async () => {
  const { viewer } = await import('/app.js');
  return viewer.pictures.map((picture) => ({
    job: picture.job_id,
    cursor: Number(picture.cursor),
    tile_updates: picture.tile_updates,
    width: picture.width,
    height: picture.height,
  }));
});

// The first picture snapshot at `index` that passes `good`.
export async function wait_for_picture(page, index, good) {
  const until = Date.now() + kWaitMs;
  for (;;) {
    const picture = (await pictures(page))[index];
    if (good(picture)) return picture;
    assert.ok(Date.now() < until, `waited in vain for picture ${index}; it stays ` +
      JSON.stringify(picture));
    await sleep(40);
  }
}

// Until the picture at `index` has had more than `than` tiles, counting each version of a tile.
export const wait_for_tiles = (page, index, than = 0) =>
  wait_for_picture(page, index, (picture) => picture.tile_updates > than);

export const canvas_pixels = async (page, index) => Uint8Array.from(await page.evaluate(
  async (i) => Array.from((await import('/app.js')).viewer.pictures[i].read_pixels()), index));

// RGBA bytes of a PNG, decoded by the browser without colour management.
export const png_pixels = async (page, path) => Uint8Array.from(await page.evaluate(
  async (url) => {
    const blob = await (await fetch(url)).blob();
    const bitmap = await createImageBitmap(blob,
      { colorSpaceConversion: 'none', premultiplyAlpha: 'none' });
    const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext('2d');
    context.drawImage(bitmap, 0, 0);
    return Array.from(context.getImageData(0, 0, bitmap.width, bitmap.height).data);
  }, path));

// Until `check` is true in the page; it may be async, which page.waitForFunction takes for true.
export async function wait_for(page, check, arg) {
  const until = Date.now() + kWaitMs;
  while (!await page.evaluate(check, arg)) {
    assert.ok(Date.now() < until, `waited in vain for ${check} of ${JSON.stringify(arg)}`);
    await sleep(40);
  }
}

// Until an <img> of the page shows what the server has at `path`.
export const wait_for_same_image = (page, selector, path) => wait_for(page,
  async ([place, url]) => {
    const shown = document.querySelector(place);
    if (shown.hidden || !shown.complete || !shown.naturalWidth) return false;
    const expected = Object.assign(new Image(), { src: url });
    await expected.decode();
    if (shown.naturalWidth !== expected.width) return false;
    const [a, b] = [shown, expected].map((image) => {
      const context = new OffscreenCanvas(expected.width, expected.height).getContext('2d');
      context.drawImage(image, 0, 0);
      return context.getImageData(0, 0, expected.width, expected.height).data;
    });
    return a.every((v, i) => v === b[i]);
  }, [selector, path]);

export async function screenshot(page, name) {
  const folder = join(env('QRAY_E2E_DIR'), 'screenshots');
  mkdirSync(folder, { recursive: true });
  await page.screenshot({ path: join(folder, `${name}.png`), fullPage: true });
}

export const state_shown = (page, job_id) =>
  page.locator(`.panel[data-job="${job_id}"] .panel-state-words`).textContent();

export const wait_for_state = (page, job_id, words) =>
  page.locator(`.panel[data-job="${job_id}"] .panel-state-words`)
    .filter({ hasText: new RegExp(`^(${words})$`) }).waitFor();
