// Printed figures, no test: the list with 10,000 jobs on the server. How long a search takes there
// and until the list shows it, and what stays in the page's memory.
// `node tests/e2e/bench_jobs.mjs` with QRAYD and QRAY_E2E_DIR as ctest sets them.
import { linkSync, mkdirSync, readdirSync } from 'node:fs';
import { join } from 'node:path';
import { multiply } from '../soak/many_jobs.mjs';
import { scratch_folder, Browser, Server } from './support.mjs';

const kJobs = 10_000;
const kSearches = 40;
const quantile = (values, q) =>
  values.toSorted((a, b) => a - b)[Math.floor(q * (values.length - 1))];
const words = (values) => `median ${quantile(values, 0.5).toFixed(0)} ms, slowest ` +
  `${Math.max(...values).toFixed(0)} ms`;

const data = scratch_folder();
let server = await Server.start(data);
const first = await server.post({ scene: 'furnace', width: 32, height: 32, samples: 1,
  method: 'none', labels: { project: 'lobby' } });
await server.wait_until(first, ({ state }) => state === 'succeeded');
await server.stop();
multiply(data, 'jobs', 'id', kJobs - 1);
const files = readdirSync(join(data, 'results', first));
for (let i = 2; i <= kJobs; ++i) {
  const folder = join(data, 'results', `j${String(i).padStart(6, '0')}`);
  mkdirSync(folder);
  for (const file of files) linkSync(join(data, 'results', first, file), join(folder, file));
}
server = await Server.start(data);

const asked = [];
for (let i = 0; i < kSearches; ++i) {
  const begin = performance.now();
  const { jobs } = await (await server.get(`/v1/jobs?limit=50&q=${i % 2 ? 'lobby' : `j00${i}`}`))
    .json();
  asked.push(performance.now() - begin);
  if (!jobs.length && i % 2) throw new Error('nothing was found');
}
console.log(`a search of ${kJobs} jobs by the server, ${kSearches} times: ${words(asked)}`);

const browser = await Browser.start();
const page = await browser.page(server.url);
await page.locator('#jobs li').nth(49).waitFor();
const session = await page.context().newCDPSession(page);
const heap_mb = async () => {
  await session.send('HeapProfiler.collectGarbage');
  return ((await session.send('Runtime.getHeapUsage')).usedSize / 1e6).toFixed(2);
};
const start = await heap_mb();
const seen = [];
for (let i = 0; i < kSearches; ++i) {
  const id = `j${String(1 + Math.floor((i + 0.5) / kSearches * kJobs)).padStart(6, '0')}`;
  seen.push(await page.evaluate((text) => new Promise((resolve) => {
    const field = document.getElementById('find');
    const begin = performance.now();
    field.value = text;
    field.dispatchEvent(new Event('input', { bubbles: true }));
    const look = () => {
      if (document.querySelector(`#jobs [data-job="${text}"]`)) resolve(performance.now() - begin);
      else requestAnimationFrame(look);
    };
    look();
  }), id));
}
console.log(`until the page lists it, after 200 ms of waiting for more letters: ${words(seen)}`);
await page.locator('#find').fill('');
await page.locator('#jobs li').nth(49).waitFor();
const searched = await heap_mb();
for (let i = 0; i < 10; ++i) {
  const count = await page.locator('#jobs li').count();
  await page.locator('#older').click();
  await page.waitForFunction((old) => document.querySelectorAll('#jobs li').length > old, count);
}
const listed = await page.locator('#jobs li').count();
console.log(`heap: ${start} MB with 50 jobs listed, ${searched} MB after ${kSearches} searches, ` +
  `${await heap_mb()} MB with ${listed} listed`);
await browser.close();
await server.stop();
process.exit(0);
