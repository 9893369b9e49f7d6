// Every view in both colour schemes: axe-core finds nothing, nothing scrolls sideways, and a
// picture of it is left.
import assert from 'node:assert/strict';
import { createRequire } from 'node:module';
import { join } from 'node:path';
import { after, afterEach, before, test } from 'node:test';
import { env, screenshot, start_all } from './support.mjs';

const kJob = { scene: 'cornell-box', width: 96, height: 96, samples: 16 };
const axe = createRequire(join(env('QRAY_E2E_DIR'), 'package.json')).resolve('axe-core/axe.min.js');
let all;
let guided;
let plain;
let turning;
let lit;
const experiment = { experiment: 'two', jobs: '2' };
before(async () => {
  all = await start_all();
  guided = await all.server.post({ ...kJob, method: 'huang' });
  plain = await all.server.post({ ...kJob, method: 'none' });
  turning = await all.server.post({ ...kJob, frames: { turntable: 6, degrees: 30 } });
  lit = await all.server.post({ scene: 'studio', method: 'none', samples: 4, width: 96, height: 72,
    light_groups: 'scene' });
  const runs = [await all.server.post({ ...kJob, method: 'none', labels: experiment }),
    await all.server.post({ ...kJob, method: 'huang', labels: experiment })];
  for (const id of [guided, plain, turning, lit, ...runs]) {
    await all.server.wait_until(id, ({ state }) => state === 'succeeded');
  }
});
after(() => all?.close());
afterEach(() => all.browser.expect_no_errors());

// name -> [its address, what is there once it is]
const views = () => ({
  empty: ['', '.view-empty:visible'],
  job: [`#job=${guided}&at=40,60`, '.pixel-table:visible'],
  compare: [`#job=${guided}&with=${plain}`, '.view-divider:visible'],
  mix: [`#job=${lit}&mix=1%3B0%3B2%3B1%3B1%3B1`, '.mixer-groups li'],
  frames: [`#job=${turning}&frame=2`, '.frames-strip canvas.drawn:visible'],
  states: [`#job=${guided}&overlay=state&curve=false`, 'img.overlay:visible'],
  tables: ['#tables', 'tbody tr'],
  figures: ['#figures', '.figure-card'],
  experiments: ['#bench', '.bench-list li'],
  experiment: ['#bench&group=two', '.case-chart canvas'],
  live: ['#scene=cornell-box', '.live-layer:visible'],
  'live job': [`#job=${guided}&live=on`, '.live-layer:visible'],
});

async function violations(page) {
  await page.evaluate(() => document.activeElement.blur());
  const { violations: found } = await page.evaluate(async (options) => globalThis.axe.run(options),
    { resultTypes: ['violations'] });
  return found.map(({ id, nodes }) => `${id}: ${nodes.map(({ html }) => html).join(' | ')}`);
}

for (const [width, colorScheme] of [[1280, 'light'], [1280, 'dark'], [390, 'light'],
  [390, 'dark']]) {
  test(`axe-core finds nothing at ${width} px in ${colorScheme}`, async () => {
    for (const [name, [hash, ready]] of Object.entries(views())) {
      const page = await all.browser.page(`${all.server.url}/${hash}`, { width,
        height: width > 800 ? 1000 : 844, colorScheme, reducedMotion: 'reduce',
        init: { path: axe } });
      if (width > 800 || name !== 'empty') await page.locator(ready).first().waitFor();
      assert.deepEqual(await violations(page), [], `${name} at ${width} px in ${colorScheme}`);
      assert.equal(await page.evaluate(() => document.documentElement.scrollWidth), width, name);
      await screenshot(page, `${name}-${width}-${colorScheme}`);
      await page.context().close();
    }
  });
}

test('dialogs, a choice of jobs and the folded options are good too', async () => {
  const page = await all.browser.page(all.server.url, { init: { path: axe } });
  await page.locator('.choice-toggle').click(); // several jobs at once
  await page.locator('.row-choose').first().check();
  assert.deepEqual(await violations(page), []);
  await page.locator('.more summary').click();
  assert.deepEqual(await violations(page), []);
  await page.locator('#show-keys').click();
  assert.deepEqual(await violations(page), []);
  await page.locator('#keys').evaluate((dialog) => dialog.append(document.createElement('input')));
  assert.match((await violations(page)).join(), /label/); // it does look
  await page.context().close();
});
