// A scene of one's own: dropped on the page, sent by the command; rendered, and refused in words.
import assert from 'node:assert/strict';
import { execFile } from 'node:child_process';
import { mkdirSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { after, afterEach, before, test } from 'node:test';
import { promisify } from 'node:util';
import { env, screenshot, start_all, unfold, wait_for_state, wait_for_tiles } from './support.mjs';

let all;
let page;
before(async () => {
  all = await start_all();
  page = await all.browser.page(all.server.url, { thumbnails: true });
});
after(() => all?.close());
afterEach(() => all.browser.expect_no_errors());

// One triangle that faces the viewer, as binary glTF.
function triangle_glb() {
  const positions = Buffer.from(new Float32Array([-1, -1, 0, 1, -1, 0, 0, 1, 0]).buffer);
  const json = JSON.stringify({
    asset: { version: '2.0' },
    scene: 0,
    scenes: [{ nodes: [0] }],
    nodes: [{ mesh: 0 }],
    meshes: [{ primitives: [{ attributes: { POSITION: 0 } }] }],
    accessors: [{ bufferView: 0, componentType: 5126, count: 3, type: 'VEC3',
      min: [-1, -1, 0], max: [1, 1, 0] }],
    bufferViews: [{ buffer: 0, byteLength: positions.length }],
    buffers: [{ byteLength: positions.length }],
  });
  const text = Buffer.from(json.padEnd(Math.ceil(json.length / 4) * 4));
  const chunk = (kind, bytes) => {
    const head = Buffer.alloc(8);
    head.writeUInt32LE(bytes.length, 0);
    head.write(kind, 4, 'latin1');
    return Buffer.concat([head, bytes]);
  };
  const chunks = Buffer.concat([chunk('JSON', text), chunk('BIN\0', positions)]);
  const head = Buffer.alloc(12);
  head.write('glTF', 0, 'latin1');
  head.writeUInt32LE(2, 4);
  head.writeUInt32LE(12 + chunks.length, 8);
  return Buffer.concat([head, chunks]);
}

const drop = (name, bytes) => page.evaluate(([file_name, values]) => {
  const transfer = new DataTransfer();
  transfer.items.add(new File([new Uint8Array(values)], file_name));
  const event = new DragEvent('drop', { dataTransfer: transfer, bubbles: true, cancelable: true });
  document.body.dispatchEvent(event);
  return event.defaultPrevented;
}, [name, [...bytes]]);

test('a dropped .glb is rendered', async () => {
  await page.locator('#amount').fill('2');
  await unfold(page);
  await page.locator('#width').fill('64'); // of another scene: not meant for this one
  assert.ok(await drop('my triangle.glb', triangle_glb()));
  await page.waitForFunction(() => location.hash.startsWith('#job='));
  const id = new URLSearchParams(new URL(page.url()).hash.slice(1)).get('job');
  await wait_for_state(page, id, 'Done');
  await wait_for_tiles(page, 0);
  const { request } = await all.server.job(id);
  assert.match(request.scene, /^up-[0-9a-f]{32}$/);
  assert.equal(request.samples, 2);
  assert.notEqual(request.width, 64);
  assert.equal(await page.locator('#upload-status').textContent(),
    'my triangle.glb is there as “my triangle”.');
  await page.locator('.row-scene').filter({ hasText: /^my triangle$/ }).waitFor();
  assert.equal(await page.locator('#scene').inputValue(), request.scene);
  await screenshot(page, 'dropped-1280');
});

test('what cannot be rendered is refused in words', async () => {
  const status = page.locator('#upload-status.error');
  const shown = async (text) => status.filter({ hasText: text }).waitFor();
  await drop('room.blend', [1, 2, 3]);
  await shown('Expected a .glb, a .zip, or a scene');
  await drop('empty.glb', []);
  await shown('empty.glb is empty.');
  await drop('broken.glb', [1, 2, 3]);
  await shown(/^broken\.glb: (?!.*scene\.glb)/);
  await page.locator('#upload').setInputFiles(
    { name: 'no.zip', mimeType: 'application/zip', buffer: Buffer.from('nothing') });
  await shown('no.zip: not a zip archive');
});

test('the files of a scene go together; of several scenes one is chosen', async () => {
  const text = (name, words) => ({ name, mimeType: 'text/plain', buffer: Buffer.from(words) });
  const triangle = 'mtllib red.mtl\nusemtl red\nv -1 -1 0\nv 1 -1 0\nv 0 1 0\nf 1 2 3\n';
  await page.locator('#upload').setInputFiles([text('red.mtl', 'newmtl red\nKd 0.9 0 0\n'),
    text('a.obj', triangle), text('b.obj', `${triangle}f 3 2 1\n`)]);
  await page.locator('#upload-status').getByRole('button', { name: 'b.obj' }).click();
  await page.locator('#upload-status').filter({ hasText: 'the files is there' }).waitFor();
  await page.waitForFunction(() =>
    document.querySelector('#scene').selectedOptions[0].textContent === 'b');
  const scene = await page.locator('#scene').inputValue();
  const { triangles, entry } = await (await all.server.get(`/v1/scenes/${scene}`)).json();
  assert.deepEqual([triangles, entry], [2, 'b.obj']);
});

test('scenes are chosen by their picture, renamed and deleted', async () => {
  const card = (title) => page.locator('.scene-card').filter({ hasText: title });
  await card('my triangle').scrollIntoViewIfNeeded(); // pictures come as they are seen
  await card('my triangle').locator('canvas.drawn').waitFor();
  await card('cornell-box').click();
  assert.equal(await page.locator('#scene').inputValue(), 'cornell-box');
  assert.equal(await page.locator('.library-rename').isVisible(), false);
  await card('my triangle').click();
  page.once('dialog', (dialog) => dialog.accept('Triangle'));
  await page.locator('.library-rename').click();
  await card(/^Triangle$/).waitFor();
  assert.equal(await page.locator('#scene option:checked').textContent(), 'Triangle');
  const phone = await all.browser.page(all.server.url, { width: 390, height: 844,
    thumbnails: true });
  await phone.locator('.scene-card').filter({ hasText: /^Triangle$/ }).waitFor();
  assert.equal(await phone.evaluate(() => document.documentElement.scrollWidth), 390);
  await screenshot(phone, 'library-390');
  await phone.context().close();
  page.once('dialog', (dialog) => dialog.accept());
  await page.locator('.library-delete').click();
  await card(/^Triangle$/).waitFor({ state: 'detached' });
});

test('qray submit sends a folder with its textures, and the picture shows them', async () => {
  const folder = join(all.folder, 'mine');
  mkdirSync(join(folder, 'parts'), { recursive: true });
  writeFileSync(join(folder, 'a.obj'), 'mtllib parts/red.mtl\nusemtl red\n' +
    'v -1 -1 0\nv 1 -1 0\nv 0 1 0\nf 1 2 3\n');
  writeFileSync(join(folder, 'parts/red.mtl'), 'newmtl red\nKd 0.9 0 0\n');
  const submit = async () => (await promisify(execFile)(env('QRAY'), ['submit',
    join(folder, 'a.obj'), '--spp', '4', '--size', '32x32', '--method', 'none',
    '--server', all.server.url])).stdout.trim();
  const first = await all.server.wait_until(await submit(), ({ state }) => state === 'succeeded');
  const second = await all.server.wait_until(await submit(), ({ state }) => state === 'succeeded');
  assert.equal(first.request.scene, second.request.scene);
  const picture = await page.evaluate(async (path) => {
    const bitmap = await createImageBitmap(await (await fetch(path)).blob());
    const context = new OffscreenCanvas(32, 32).getContext('2d');
    context.drawImage(bitmap, 0, 0);
    return Array.from(context.getImageData(16, 16, 1, 1).data);
  }, `/v1/jobs/${first.id}/image.png`);
  assert.ok(picture[0] > 100 && picture[1] < 30, `red, got ${picture}`);
});
