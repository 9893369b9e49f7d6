// What holds for as long as the page is open: it runs nothing but files of its own, stays small,
// and updates leave no memory behind.
import assert from 'node:assert/strict';
import { readdirSync, statSync } from 'node:fs';
import { join } from 'node:path';
import { after, afterEach, before, test } from 'node:test';
import { fileURLToPath } from 'node:url';
import { start_all, wait_for_state, wait_for_tiles } from './support.mjs';

const kWeb = fileURLToPath(new URL('../../web', import.meta.url));
let all;
let guided;
before(async () => {
  all = await start_all();
  guided = await all.server.post({ scene: 'cornell-box', width: 96, height: 96, samples: 16,
    method: 'huang' });
  await all.server.wait_until(guided, ({ state }) => state === 'succeeded');
});
after(() => all?.close());
afterEach(() => all.browser.expect_no_errors());

test('the page runs nothing but files of its own', async () => {
  const answer = await all.server.get('/');
  const policy = answer.headers.get('content-security-policy');
  assert.match(policy, /default-src 'self'/);
  assert.doesNotMatch(policy, /unsafe|https?:|\*/);
  const page = await all.browser.page(`${all.server.url}/#job=${guided}`);
  const urls = [];
  page.on('request', (request) => urls.push(request.url()));
  await page.reload();
  await wait_for_tiles(page, 0);
  assert.ok(urls.length > 20);
  assert.deepEqual(urls.filter((url) => !url.startsWith(all.server.url) &&
    !url.startsWith('blob:')), []);
  await page.context().close();
});

test('of its libraries the server gives what the page loads, and nothing else', async () => {
  const library = await all.server.get('/lib/uPlot.esm.js');
  assert.match(library.headers.get('content-type'), /^text\/javascript/);
  assert.match(library.headers.get('content-security-policy'), /default-src 'self'/);
  for (const path of ['/lib/installed', '/package-lock.json', '/lib/../install_lib.cmake']) {
    assert.equal((await fetch(all.server.url + path)).status, 404, path);
  }
});

// How long: QRAY_E2E_UPDATES, where an hour of a running job is 7,200.
test('updates leave no memory behind', { timeout: 3_600_000 }, async (context) => {
  const updates = Number(process.env.QRAY_E2E_UPDATES ?? 600);
  const page = await all.browser.page(`${all.server.url}/#job=${guided}&at=40,60`);
  await wait_for_state(page, guided, 'Done');
  const session = await page.context().newCDPSession(page);
  const heap_bytes = async () => {
    await session.send('HeapProfiler.collectGarbage');
    return (await session.send('Runtime.getHeapUsage')).usedSize;
  };
  // What an event of a running job sets off: the list, the panel, tiles, moments, pixel.
  const update = (count) => page.evaluate(async ([id, times]) => {
    const { store, viewer } = await import('/app.js');
    const done = store.get(id);
    for (let i = 0; i < times; ++i) {
      const progress = { ...done.progress, fraction: i / times };
      store.put({ ...done, state: 'rendering', progress });
      store.apply_progress({ job: id, fraction: 1, samples: i % 64 + 1, seconds: i });
      const [picture] = viewer.pictures;
      const before_tiles = picture.tile_updates;
      viewer.restart();
      while (picture.tile_updates === before_tiles) await new Promise(requestAnimationFrame);
    }
    store.put(done);
  }, [guided, count]);
  await update(300); // compiled, and every cache is warm
  const first = await heap_bytes();
  await update(updates);
  const last = await heap_bytes();
  const nodes = await page.evaluate(() => document.querySelectorAll('*').length);
  context.diagnostic(`${updates} updates: the heap went from ${first} to ${last} bytes`);
  assert.ok(last - first < 400_000, `${updates} updates: from ${first} to ${last} bytes`);
  assert.ok(nodes < 1500, `${nodes} elements`);
  await page.context().close();
});

test('jobs that come leave the list and the memory as large as they were',
  { timeout: 200_000 }, async (context) => {
  const page = await all.browser.page(`${all.server.url}/#job=${guided}`);
  await wait_for_state(page, guided, 'Done');
  const session = await page.context().newCDPSession(page);
  const heap_bytes = async () => {
    await session.send('HeapProfiler.collectGarbage');
    return (await session.send('Runtime.getHeapUsage')).usedSize;
  };
  // As if the server had told of them.
  const come = (first, count) => page.evaluate(async ([id, from, many]) => {
    const { store } = await import('/app.js');
    const job = store.get(id);
    for (let i = from; i < from + many; ++i) {
      store.put({ ...structuredClone(job), id: `j${String(100_000 + i)}`,
        created: new Date(Date.parse(job.created) + 1000 * i).toISOString() });
      if (i % 20 === 0) await new Promise(requestAnimationFrame);
    }
    await new Promise(requestAnimationFrame);
  }, [guided, first, count]);
  await come(1, 560);
  const first = await heap_bytes();
  await come(561, 300);
  const last = await heap_bytes();
  context.diagnostic(`300 jobs: the heap went from ${first} to ${last} bytes`);
  assert.ok(last - first < 200_000, `from ${first} to ${last} bytes`);
  assert.equal(await page.locator('#jobs li').count(), 50);
  assert.equal(await page.locator('#jobs li').first().getAttribute('data-job'), 'j100860');
  await page.locator('#older').click(); // those that left the list are there again
  await page.waitForFunction(() => document.querySelectorAll('#jobs li').length === 100);
  assert.equal(await page.locator('.panel-state-words').first().textContent(), 'Done');
  await page.context().close();
});

// As a browser gets them, with gzip, and their source.
test('the pages themselves stay small', async (context) => {
  const is_own = /^\/[\w.]*$/;
  const sent = async (path, ready) => {
    const page = await all.browser.page(all.server.url + path, { ready });
    const files = await page.evaluate(() => ['navigation', 'resource'].flatMap((type) =>
      performance.getEntriesByType(type).map(({ name, encodedBodySize }) =>
        ({ path: new URL(name).pathname, bytes: encodedBodySize }))));
    await page.context().close();
    return files.filter((file) => is_own.test(file.path));
  };
  const bytes = (files) => files.reduce((sum, file) => sum + file.bytes, 0);
  const source = readdirSync(kWeb).filter((name) => /\.(js|html|css|svg)$/.test(name))
    .map((name) => ({ path: `/${name}`, bytes: statSync(join(kWeb, name)).size }));
  // What a live view needs is fetched when one is first opened.
  const is_live = ({ path }) => path.startsWith('/live') && path !== '/live_gate.js';
  // And what experiments need when their page is.
  const is_bench = ({ path }) => /^\/(bench|chart_files)/.test(path);
  const page = await sent('/#list');
  const bench = (await sent('/#bench', '.bench-methods input')).filter(is_bench);
  const live = (await sent('/#scene=cornell-box', '.live-layer:visible')).filter(is_live);
  assert.ok(page.length > 35 && page.every((file) => file.bytes > 0), JSON.stringify(page));
  assert.ok(!page.some(is_live) && !page.some(is_bench) && bytes(page) < 103_500,
    `the page: ${bytes(page)} bytes`);
  assert.ok(bench.length > 6 && bytes(bench) < 18_000, `for experiments: ${bytes(bench)} bytes`);
  assert.ok(live.length > 5 && bytes(live) < 16_000, `for a live view: ${bytes(live)} bytes`);
  const [live_source, bench_source, page_source] = [is_live, is_bench,
    (file) => !is_live(file) && !is_bench(file)].map((which) => bytes(source.filter(which)));
  assert.ok(page_source < 302_500, `${page_source} bytes`);
  assert.ok(live_source < 40_000, `${live_source} bytes`);
  assert.ok(bench_source < 48_000, `${bench_source} bytes`);
  context.diagnostic(`sent: ${bytes(page)}, ${bytes(live)} and ${bytes(bench)} bytes of ` +
    `${page_source}, ${live_source} and ${bench_source}`);
});
