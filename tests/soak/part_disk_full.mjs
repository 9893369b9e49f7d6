// A disk that fills while a job runs, and is freed again. The data folder is a small tmpfs in a
// mount namespace of its own: needs root, or user namespaces.
import { execFileSync, spawn } from 'node:child_process';
import { createHash, randomBytes } from 'node:crypto';
import { closeSync, openSync, readdirSync, unlinkSync, writeSync } from 'node:fs';
import { join } from 'node:path';
import { picture_hash, request, sleep } from './measure.mjs';
import { Server, post_job, scratch_folder } from './server.mjs';

const kMiB = 32;
const small = { scene: 'cornell-box', width: 128, height: 128, table: 'none', method: 'huang' };

// A process that holds the namespace, so that a second server finds the same disk.
async function hold_disk(data) {
  const flags = process.getuid() === 0 ? ['--mount'] : ['--mount', '--user', '--map-root-user'];
  const keeper = spawn('unshare', [...flags, 'sh', '-c',
    `mount -t tmpfs -o size=${kMiB}m none "$0" && echo ready && exec sleep 3600`, data],
  { stdio: ['ignore', 'pipe', 'ignore'] });
  process.on('exit', () => keeper.kill('SIGKILL'));
  const ready = await new Promise((resolve) => {
    keeper.stdout.once('data', () => resolve(true));
    keeper.once('exit', () => resolve(false));
    keeper.once('error', () => resolve(false));
  });
  return ready ? keeper : null;
}

function fill(file) {
  const descriptor = openSync(file, 'w');
  let bytes = 0;
  for (let block = 1 << 20; block >= 512; block >>= 1) {
    const zeros = Buffer.alloc(block);
    try {
      for (;;) bytes += writeSync(descriptor, zeros);
    } catch (error) {
      if (error.code !== 'ENOSPC') throw error;
    }
  }
  closeSync(descriptor);
  return bytes;
}

export async function run({ short }, report) {
  const data = scratch_folder();
  const keeper = await hold_disk(data);
  if (!keeper) return report.skip('disk-full', 'no mount namespace here');
  const disk = `/proc/${keeper.pid}/root${data}`;
  const user = process.getuid() === 0 ? [] : ['--user', '--preserve-credentials'];
  const wrap = (program, args) =>
    ['nsenter', ['--target', String(keeper.pid), '--mount', ...user, '--', program, ...args]];
  let server = await Server.start(data, { wrap });

  const first = await server.wait(await server.post({ ...small, samples: 8 }));
  const running = await server.post({ ...small, method: 'none', seconds: short ? 2 : 8 });
  await server.wait_running(running);
  const filler = join(disk, 'filler');
  fill(filler);

  // Step 1: full.
  const accepted = [], refused = [], wrong = [];
  for (let i = 0; i < 40; ++i) {
    const answer = await post_job(server.port, { ...small, samples: 2, seed: i });
    if (answer.status === 202) accepted.push(JSON.parse(answer.body).id);
    else if ([503, 507].includes(answer.status)) refused.push(answer);
    else wrong.push(answer.status);
    fill(filler + (i % 2)); // what a removed file gave back
  }
  report.bar('disk-full: 40 jobs posted', '202, 503 or 507',
    `${accepted.length} x 202, ${refused.length} x ${refused[0]?.status ?? '-'}, ` +
    `${wrong.length} others${wrong.length ? ` (${wrong[0]})` : ''}`, wrong.length === 0);
  const asset = randomBytes(1 << 20);
  const put = await request(server.port, 'PUT',
    `/v1/assets/${createHash('sha256').update(asset).digest('hex')}`, { body: asset });
  report.bar('disk-full: an upload', '503 or 507', put.status, [503, 507].includes(put.status));
  const health = await server.get('/healthz');
  report.bar('disk-full: /healthz', '200', health.status, health.status === 200);
  const read = await server.get(`/v1/jobs/${first.id}/image.png`);
  report.bar('disk-full: an older picture', '200', read.status, read.status === 200);
  await sleep(short ? 3000 : 10_000); // the running job comes to its end meanwhile
  const during = await server.job(running);
  report.show('disk-full: the running job at its end', `${during.state}` +
    `${during.error ? `: ${during.error.message}` : ''}`);
  report.bar('disk-full: the process', 'lives', server.alive ? 'lives' : server.said.slice(-200),
    server.alive);

  // Step 2: free again, and nobody does anything about it.
  for (const name of readdirSync(disk)) if (name.startsWith('filler')) unlinkSync(join(disk, name));
  const begin = performance.now();
  let answer;
  do {
    answer = await post_job(server.port, { ...small, samples: 8 });
    if (answer.status !== 202) await sleep(100);
  } while (answer.status !== 202 && performance.now() - begin < 30_000);
  const after = answer.status === 202 &&
    await server.wait(JSON.parse(answer.body).id, undefined, 60).catch((state) => ({ state }));
  report.bar('disk-full: freed, a new job without a restart', 'succeeded', after.state ??
    answer.status, after.state === 'succeeded');
  const ended = await Promise.all([running, ...accepted].map((id) =>
    server.wait(id, undefined, 20).catch(() => server.job(id))));
  const open = ended.filter((job) => !job.ended);
  report.bar('disk-full: jobs accepted before that have not ended', '0',
    `${open.length}${open.length ? `: ${open[0].id} ${open[0].state}` : ''}`, open.length === 0);
  const no_reason = ended.filter((job) => job.state === 'failed' && !job.error?.message);
  report.bar('disk-full: failed without a reason', '0', no_reason.length, no_reason.length === 0);

  // Step 3: what is on the disk.
  const { code } = await server.end();
  report.bar('disk-full: exit code', '0', code, code === 0);
  const check = execFileSync('sqlite3', [join(disk, 'qray.sqlite'), 'PRAGMA integrity_check'],
    { encoding: 'utf8' }).trim();
  report.bar('disk-full: database', 'ok', check, check === 'ok');
  const half = readdirSync(disk, { recursive: true })
    .filter((name) => /\.tmp\.|\.part$/.test(name));
  report.bar('disk-full: half-written files left behind', '0', half.length, half.length === 0);
  server = await Server.start(data, { wrap });
  let torn = 0;
  for (const job of (await server.all_jobs()).filter((one) => one.state === 'succeeded')) {
    if ((await picture_hash(server, job.id)).startsWith('status')) ++torn;
  }
  report.bar('disk-full: succeeded jobs without a picture', '0', torn, torn === 0);
  await server.end();
  keeper.kill();
}
