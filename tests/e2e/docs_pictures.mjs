// No test: makes the pictures of the page that README.md and docs/page.md show.
//   QRAYD=$PWD/BUILD/bin/qrayd QRAY_E2E_DIR=$PWD/BUILD/e2e QRAY_E2E_MS=600000 \
//     node tests/e2e/docs_pictures.mjs FOLDER
// BUILD: a build folder in which `ctest -R e2e.install` has run.
import { join } from 'node:path';
import { setTimeout as sleep } from 'node:timers/promises';
import { start_all, wait_for_tiles } from './support.mjs';

const [folder = 'docs/pictures'] = process.argv.slice(2);
const all = await start_all();

async function made(request) {
  const id = await all.server.post({ samples: 64, ...request });
  while ((await all.server.job(id)).state !== 'succeeded') await sleep(200); // of many seconds
  return id;
}

async function shown(name, hash, { width, height }, more = async () => {}) {
  const page = await all.browser.page(`${all.server.url}/#${hash}`,
    { width, height, thumbnails: true });
  await wait_for_tiles(page, 0);
  await page.waitForFunction(() => document.querySelector('.scene-picture') &&
    !document.querySelector('.scene-picture:not(.drawn)'));
  await more(page);
  await page.mouse.move(0, 0);
  await page.screenshot({ path: join(folder, `${name}.jpg`), type: 'jpeg', quality: 88 });
  await page.context().close();
}

try {
  const small = { width: 1200, height: 750 };
  const plain = await made({ scene: 'ajar-door', method: 'none' });
  const published = await made({ scene: 'ajar-door', method: 'huang-published' });
  const huang = await made({ scene: 'ajar-door', method: 'huang' });
  const room = await made({ scene: 'thesis-room', recover: 'auto' });
  await shown('page', `job=${room}`, { width: 1440, height: 900 });
  await shown('page-compare', `job=${published}&with=${plain}&mode=signed&ev=3`, small,
    (page) => page.locator('.pane.left img.overlay').waitFor());
  await shown('page-learned', `job=${huang}&overlay=state&at=230,307&ev=3`, small,
    async (page) => {
      await page.locator('.lobe img').waitFor();
      await page.locator('.pixel-table').scrollIntoViewIfNeeded();
      await page.locator('.lobe figcaption').scrollIntoViewIfNeeded();
    });
} finally {
  await all.close();
}
