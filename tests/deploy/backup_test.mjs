// docker/backup.sh of a server that renders, and a server on the copy.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { join } from 'node:path';
import { test } from 'node:test';
import { Server, env, scratch_folder } from '../e2e/support.mjs';

const backup = (...words) => spawnSync('bash',
  [join(env('QRAY_SOURCE_DIR'), 'docker/backup.sh'), ...words], { encoding: 'utf8' });
const picture = async (server, id) =>
  Buffer.from(await (await server.get(`/v1/jobs/${id}/image.exr`)).arrayBuffer());

test('a copy made while a job renders is a whole data folder', async () => {
  const folder = scratch_folder();
  const data = join(folder, 'data'), copy = join(folder, 'copy');
  const small = { scene: 'cornell-box', width: 64, height: 64, samples: 8 };
  let server = await Server.start(data);
  const done = await server.post(small);
  const before = await server.wait_until(done, (job) => job.state === 'succeeded');
  const pixels = await picture(server, done);
  const running = await server.post({ ...small, samples: 1_000_000 });
  await server.wait_until(running, (job) => ['learning', 'rendering'].includes(job.state));
  const waiting = await server.post({ ...small, seed: 2 });

  const made = backup(data, copy);
  assert.equal(made.status, 0, made.stderr);
  assert.match(made.stdout, /3 jobs/);
  assert.notEqual(backup(data, copy).status, 0, 'a backup is not overwritten');
  await server.stop();

  server = await Server.start(copy);
  assert.deepEqual(await server.job(done), before);
  assert.deepEqual(await picture(server, done), pixels);
  await fetch(`${server.url}/v1/jobs/${running}/cancel`, { method: 'POST' });
  await server.wait_until(waiting, (job) => job.state === 'succeeded');
  assert.equal(await server.post(small), 'j000004', 'ids are not used twice');
  await server.stop();
});

test('what is no data folder is refused', () => {
  const folder = scratch_folder();
  assert.notEqual(backup(folder, join(folder, 'copy')).status, 0);
});
