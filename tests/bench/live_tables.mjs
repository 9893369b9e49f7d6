// Whether a table can only get better: after each of many random visits to a scene (a live session
// of 1 to 8 s, a job of 1 to 64 samples, more samples for an old job), a job that takes its table
// by itself is compared with one from the table that was there before all visits.
//   QRAYD=$PWD/build/release/bin/qrayd QRAY_E2E_MS=4000000 \
//     node tests/bench/live_tables.mjs SCENE [visits] [seed]
// SCENE: an included scene. `qray` lies beside qrayd. Prints, for each visit, the error of the job
// over that of the other (relMSE, and without the worst .1 % of pixels), and geometric means of
// each kind of visit.
import { execFileSync } from 'node:child_process';
import { writeFileSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { setTimeout as sleep } from 'node:timers/promises';
import { scratch_folder, Server } from '../e2e/support.mjs';

const [scene = 'ajar-door', visits = 20, seed = 1] = process.argv.slice(2);
const kSide = 256;
const kTeacherSeconds = 30;
const kReferenceSeconds = 60;
const kSamples = 16; // of the jobs that are compared
const kWaitMs = 180_000;

// Numbers in [0, 1), the same for a seed (mulberry32).
let state = Number(seed);
function random() {
  state = (state + 0x6d2b79f5) | 0;
  let t = Math.imul(state ^ (state >>> 15), 1 | state);
  t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
  return ((t ^ (t >>> 14)) >>> 0) / 2 ** 32;
}

const folder = scratch_folder();
const server = await Server.start(folder);

const size = { scene, width: kSide, height: kSide };
async function done(request) {
  const id = await server.post({ ...size, ...request });
  return server.wait_until(id, ({ state: now }) => now === 'succeeded', kWaitMs);
}

async function picture(job, name) {
  const file = join(folder, `${name}.exr`);
  const answer = await server.get(`/v1/jobs/${job.id}/image.exr`);
  writeFileSync(file, Buffer.from(await answer.arrayBuffer()));
  return file;
}

// A session that looks at points around the first one, from places around the first one.
async function session() {
  const live = await server.call('POST', '/v1/live', { ...size, frame_ms: 100 });
  const end = new AbortController();
  const reading = fetch(`${server.url}/v1/live/${live.id}/frames`, { signal: end.signal })
    .then(async ({ body }) => { for await (const chunk of body) void chunk; }).catch(() => {});
  const until = Date.now() + 1000 + 7000 * random();
  const near = (point, by) => point.map((v) => v + by * (2 * random() - 1));
  const { position, target } = live.camera;
  for (let number = 1; Date.now() < until; ++number) {
    await server.call('PUT', `/v1/live/${live.id}/camera`, { number,
      camera: { position: near(position, 0.2), target: near(target, 0.6) } });
    await sleep(100 + 900 * random());
  }
  end.abort();
  await reading;
  await server.call('DELETE', `/v1/live/${live.id}`);
  await sleep(500); // its table is kept
}

const kinds = {
  session,
  job: () => done({ samples: 1 + Math.floor(64 * random()), seed: Math.floor(1e6 * random()) }),
  async extend() {
    await server.call('POST', `/v1/jobs/${teacher.id}/extend`,
      { samples: 1 + Math.floor(8 * random()) });
    await sleep(100);
    await server.wait_until(teacher.id, ({ state: now }) => now === 'succeeded', kWaitMs);
  },
};

const relmse = (file, reference) => {
  const said = execFileSync(join(dirname(process.env.QRAYD), 'qray'),
    ['diff', file, reference, '--json'], { encoding: 'utf8', stdio: ['ignore', 'pipe', 'ignore'] });
  const { relmse: all, relmse_trimmed: trimmed } = JSON.parse(said);
  return [all, trimmed];
};

const reference = await picture(
  await done({ seconds: kReferenceSeconds, seed: 777, table: 'none' }), 'reference');
const teacher = await done({ seconds: kTeacherSeconds, seed: 11 });
const logs = {};
try {
  for (let visit = 1; visit <= Number(visits); ++visit) {
    const kind = Object.keys(kinds)[Math.floor(3 * random())];
    await kinds[kind]();
    const errors = [];
    for (const table of ['auto', teacher.table_out]) {
      const job = await done({ samples: kSamples, seed: 1000 + visit, table });
      errors.push(relmse(await picture(job, table), reference));
      await server.call('DELETE', `/v1/jobs/${job.id}`);
      if (job.table_out) await server.call('DELETE', `/v1/tables/${job.table_out}`);
    }
    const ratios = errors[0].map((v, i) => v / errors[1][i]);
    (logs[kind] ??= []).push(ratios.map(Math.log));
    console.log(`${String(visit).padStart(3)} ${kind.padEnd(8)} ${
      ratios.map((v) => v.toFixed(2).padStart(6)).join('')}`);
  }
} finally {
  await server.stop();
}
for (const [kind, rows] of Object.entries(logs)) {
  const means = [0, 1].map((i) =>
    Math.exp(rows.reduce((sum, row) => sum + row[i], 0) / rows.length).toFixed(3));
  console.log(`${kind}: ${rows.length} visits, error ${means[0]} (trimmed ${means[1]}) times`);
}
