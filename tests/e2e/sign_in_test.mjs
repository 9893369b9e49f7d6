// A server that asks for tokens: the page's dialog, what it opens, and what happens when the
// session is over.
import assert from 'node:assert/strict';
import { createHash } from 'node:crypto';
import { writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { after, afterEach, before, test } from 'node:test';
import { post_by_form, scratch_folder, screenshot, start_all, wait_for_state,
  wait_for_tiles } from './support.mjs';

const kToken = 'a token of this test';
const kDialog = '#sign-in[open]';

let all;
before(async () => {
  const file = join(scratch_folder(), 'tokens');
  const digest = (token) => createHash('sha256').update(token).digest('hex');
  writeFileSync(file, `tester submit ${digest(kToken)}\nreader read ${digest('reads')}\n`);
  all = await start_all({ more: ['--tokens', file] });
});
after(() => all?.close());
afterEach(() => all.browser.expect_no_errors());

async function sign_in(page, token) {
  await page.locator(`${kDialog} input`).fill(token);
  await page.locator(`${kDialog} button`).click();
}

test('the page asks for a token, and goes on with it', async () => {
  const page = await all.browser.page(all.server.url, { ready: kDialog });
  await screenshot(page, 'sign-in-1280');
  await page.keyboard.press('Escape');
  await page.keyboard.press('Escape');
  await page.locator(kDialog).waitFor(); // there is nothing to see without
  await sign_in(page, 'another one');
  const problem = page.locator('#token-error');
  await problem.filter({ hasText: 'does not know this token' }).waitFor();
  await sign_in(page, kToken);
  await page.locator('#sign-in').waitFor({ state: 'hidden' });
  await page.locator('.connection[data-live="true"]').waitFor();
  assert.equal(await page.locator('#token').inputValue(), '');

  const { job } = await post_by_form(page, { scene: 'cornell-box', amount: 4 });
  await wait_for_tiles(page, 0);
  await wait_for_state(page, job, 'Done|Succeeded|Finished');
  const picture = await page.evaluate(async (id) => {
    const image = new Image();
    image.src = `/v1/jobs/${id}/image.png`;
    await image.decode();
    return image.naturalWidth;
  }, job);
  assert.ok(picture > 0);
  assert.equal(await page.evaluate(() => document.cookie), ''); // scripts do not see it

  await page.reload(); // the session stays
  await page.locator('.connection[data-live="true"]').waitFor();
  assert.equal(await page.locator(kDialog).count(), 0);
});

test('a session that is over is asked for again, and the call goes on', async () => {
  const page = await all.browser.page(all.server.url, { ready: kDialog });
  await sign_in(page, kToken);
  await page.locator('.connection[data-live="true"]').waitFor();
  await page.locator('#job-form button[type=submit]:enabled').waitFor(); // the scenes are listed
  await page.context().clearCookies();
  await page.locator('#amount').fill('1');
  // Not by its button: the dialog may be there already, since the page asks for other things too.
  await page.evaluate(() => document.querySelector('#job-form').requestSubmit());
  await page.locator(kDialog).waitFor();
  await sign_in(page, kToken);
  await page.waitForFunction(() => location.hash.startsWith('#job='));
});

test('an answer from before a session that comes after it asks for no token', async () => {
  const page = await all.browser.page(all.server.url, { ready: kDialog });
  await sign_in(page, kToken);
  await page.locator('.connection[data-live="true"]').waitFor();
  await page.context().clearCookies();
  let release;
  const released = new Promise((resolve) => { release = resolve; });
  const kLate = '**/v1/jobs/late';
  const refused = page.waitForResponse(kLate);
  await page.route(kLate, async (route) => {
    const answer = await route.fetch();
    if (answer.status() === 401) await released;
    await route.fulfill({ response: answer });
  });
  await page.evaluate(async () => {
    const { get_job } = await import('/api.js');
    const status_of = (id) => get_job(id).catch((error) => error.status);
    window.late = status_of('late');
    window.early = status_of('early');
  });
  await page.locator(kDialog).waitFor();
  await sign_in(page, kToken);
  assert.equal(await page.evaluate(() => window.early), 404);
  release();
  assert.equal((await refused).status(), 401);
  assert.equal(await page.evaluate(() => window.late), 404);
  assert.equal(await page.locator(kDialog).count(), 0);
});

test('a token that may only read says so at the form', async () => {
  const page = await all.browser.page(all.server.url, { width: 390, height: 844, ready: kDialog });
  await screenshot(page, 'sign-in-390');
  await sign_in(page, 'reads');
  await page.locator('.connection[data-live="true"]').waitFor();
  await page.locator('#job-form button[type=submit]').click();
  await page.locator('.form-error').filter({ hasText: 'scope submit' }).waitFor();
});
