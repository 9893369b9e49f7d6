// kill -9 at random moments under load. Acknowledged jobs are there once, end, and make the
// pictures that an undisturbed server makes. A job is given up after three interrupted attempts
// (docs/api.md), so one that was interrupted twice is left to end before the next kill. Where the
// server knows Idempotency-Key, clients ask again when they lost an answer, and no job is doubled.
import { execFileSync, spawn } from 'node:child_process';
import { readdirSync } from 'node:fs';
import { join } from 'node:path';
import { in_parallel, picture_hash, sleep } from './measure.mjs';
import { Server, post_job, scratch_folder } from './server.mjs';

const kClients = 3, kQueued = 6; // jobs that they keep waiting
const box = { scene: 'cornell-box', width: 160, height: 160, table: 'none' };
const kKinds = [
  { ...box, method: 'none', samples: 96 },
  { ...box, method: 'huang', samples: 48 },
  { ...box, method: 'adaptive', samples: 40, width: 200 },
  { ...box, method: 'ppg', samples: 40, seed: 7 },
];

const with_key = (key) => ({ headers: { 'idempotency-key': key } });

async function knows_keys(server) {
  const ids = [];
  for (let i = 0; i < 2; ++i) {
    const answer = await post_job(server.port, { scene: 'furnace', samples: 1, width: 16,
      height: 16 }, with_key('again'));
    ids.push(JSON.parse(answer.body).id);
  }
  return ids[0] === ids[1];
}

async function undisturbed(job) {
  const server = await Server.start(scratch_folder());
  const done = await server.wait(await server.post(job));
  const hash = await picture_hash(server, done.id);
  await server.end();
  return { hash, seconds: done.stats.seconds };
}

// What of a running job's work is done again, in its own seconds of rendering.
async function redone_seconds(server, before) {
  for (;;) {
    const now = await server.job(before.id);
    if (now.ended) return 0; // sooner done than looked at
    if (now.progress.samples > 0) {
      const lost = Math.max(0, before.progress.samples - now.progress.samples);
      return before.progress.seconds * lost / Math.max(1, before.progress.samples);
    }
    await sleep(10);
  }
}

const running_of = (jobs) => jobs.filter((job) => !job.ended && job.state !== 'queued');

export async function run({ short, kills }, report) {
  if (short) kills = 3;
  const references = [];
  for (const kind of kKinds) references.push((await undisturbed(kind)).hash);

  const probe = await Server.start(scratch_folder());
  const keys = await knows_keys(probe);
  await probe.end();
  const data = scratch_folder();
  const acknowledged = new Map(), interrupted = new Map(), redone = [];
  let posted = 0, unanswered = 0, server = null, early = 0;
  const going = { on: true };
  const clients = in_parallel(kClients, () => going.on, 50, async () => {
    if (!server) return;
    const one = server;
    const jobs = await one.json('/v1/jobs?limit=50').catch(() => null);
    if (!jobs || jobs.jobs.filter((job) => !job.ended).length >= kQueued) return;
    const kind = posted++ % kKinds.length, key = with_key(`kill-${posted}`);
    let answer = await post_job(one.port, kKinds[kind], key).catch(() => null);
    if (!answer) ++unanswered;
    for (; keys && !answer && going.on; await sleep(50)) {
      if (server) answer = await post_job(server.port, kKinds[kind], key).catch(() => null);
    }
    if (answer?.status === 202) acknowledged.set(JSON.parse(answer.body).id, kind);
  });

  let before = []; // the jobs that the last kill interrupted
  const times = (job) => interrupted.get(job.id) ?? 0;
  const interrupt = () => before.forEach((job) => interrupted.set(job.id, times(job) + 1));
  for (let kill = 0; kill < kills; ++kill) {
    if (Math.random() < 0.1 && before.every((job) => times(job) < 2)) { // while it starts
      const child = spawn(process.env.QRAYD, ['--port', '0', '--data', data], { stdio: 'ignore' });
      await sleep(300 * Math.random());
      child.kill('SIGKILL');
      await new Promise((resolve) => child.once('exit', resolve));
      interrupt();
      ++early;
      continue;
    }
    server = await Server.start(data);
    redone.push(...await Promise.all(before.map((job) => redone_seconds(server, job))));
    await sleep(200 + 3800 * Math.random());
    for (;;) {
      before = running_of((await server.json('/v1/jobs?limit=50')).jobs);
      const often = before.find((job) => times(job) >= 2);
      if (!often) break;
      await server.wait(often.id);
    }
    interrupt();
    const killed = server;
    server = null;
    await killed.end('SIGKILL');
  }
  going.on = false;
  await clients;

  server = await Server.start(data);
  for (const id of acknowledged.keys()) await server.wait(id);
  const jobs = await server.all_jobs();
  const there = new Map(jobs.map((job) => [job.id, job]));
  const lost = [...acknowledged.keys()].filter((id) => !there.has(id)).length;
  const extra = jobs.length - acknowledged.size + lost;
  const what = `kill: ${kills} kills (${early} while starting), ${acknowledged.size} jobs accepted`;
  report.bar(`${what}: lost`, '0', lost, lost === 0);
  // The last kill may have taken answers that nobody asks for again.
  const untold = keys ? Math.min(kClients, unanswered) : unanswered;
  report.bar(`kill: jobs that nobody was told of, with ${unanswered} answers lost`,
    `<= ${untold}`, extra, extra >= 0 && extra <= untold);
  const failed = jobs.filter((job) => acknowledged.has(job.id) && job.state !== 'succeeded');
  report.bar('kill: of these not succeeded', '0',
    `${failed.length}${failed.length ? `: ${failed[0].error?.message}` : ''}`, failed.length === 0);
  let same = 0;
  for (const [id, kind] of acknowledged) {
    if (await picture_hash(server, id) === references[kind]) ++same;
  }
  report.bar('kill: pictures with the undisturbed pixels', `${acknowledged.size}`, same,
    same === acknowledged.size);
  const again = [...interrupted.values()];
  report.show('kill: jobs interrupted once, twice, more', [1, 2, 3].map((n) =>
    again.filter((count) => (n < 3 ? count === n : count >= n)).length).join(', '));
  report.time('kill: done again by one kill, worst', 's', 30, Math.max(0, ...redone));
  await server.end();
  const check = execFileSync('sqlite3', [join(data, 'qray.sqlite'), 'PRAGMA integrity_check'],
    { encoding: 'utf8' }).trim();
  report.bar('kill: database', 'ok', check, check === 'ok');
  const torn = readdirSync(data, { recursive: true }).filter((name) => name.includes('.tmp.'));
  report.show('kill: half-written files left behind', torn.length);
  if (!short && kills >= 10) await one_long_job(report);
}

// 40 s of work, killed after 30.
async function one_long_job(report) {
  const job = { scene: 'cornell-box', method: 'adaptive', table: 'none', samples: 64 };
  const first = await undisturbed(job);
  job.samples = Math.ceil(64 * 40 / first.seconds);
  const reference = await undisturbed(job);
  const data = scratch_folder();
  let server = await Server.start(data);
  const id = await server.post(job);
  const before = await server.wait(id, (now) => now.progress.seconds > 0.75 * reference.seconds);
  await server.end('SIGKILL');
  server = await Server.start(data);
  const redone = await redone_seconds(server, before);
  const done = await server.wait(id);
  report.bar(`kill: a job of ${reference.seconds.toFixed(0)} s`, 'the undisturbed pixels',
    done.state, await picture_hash(server, id) === reference.hash);
  report.time(`kill: of its ${before.progress.seconds.toFixed(0)} s done again`, 's', 30, redone);
  await server.end();
}
