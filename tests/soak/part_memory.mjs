// Minutes of all that clients do: jobs, cancels, streams, tiles, pictures, uploads, refusals.
// Memory grows no more once warm; descriptors and threads come back to where they were.
import { createHash, randomBytes } from 'node:crypto';
import { appendFileSync } from 'node:fs';
import { join } from 'node:path';
import { in_parallel, mib, open_stream, request, sleep } from './measure.mjs';
import { Server, post_job, scratch_folder } from './server.mjs';

const kScenes = ['cornell-box', 'furnace', 'ajar-door', 'lamp-room'];
const kMethods = ['none', 'huang', 'adaptive', 'ppg', 'dahm-keller'];
const pick = (list) => list[Math.floor(Math.random() * list.length)];

async function a_job({ port }) {
  const size = 16 * (2 + Math.floor(8 * Math.random()));
  const answer = await post_job(port, { scene: pick(kScenes), method: pick(kMethods), width: size,
    height: size, samples: 1 + Math.floor(16 * Math.random()), table: pick(['auto', 'none']),
    seed: Math.floor(1e6 * Math.random()) });
  if (answer.status !== 202) return answer.status === 429;
  const { id } = JSON.parse(answer.body);
  if (Math.random() < 0.2) await request(port, 'POST', `/v1/jobs/${id}/cancel`);
  for (let i = 0; i < 2000; ++i) {
    await request(port, 'GET', `/v1/jobs/${id}/tiles?since=0`);
    if (JSON.parse((await request(port, 'GET', `/v1/jobs/${id}`)).body).ended) break;
    await sleep(100);
  }
  await request(port, 'GET', `/v1/jobs/${id}/image.${pick(['png', 'exr'])}`);
  return true;
}

async function an_upload({ port }) {
  const obj = Buffer.from(
    `# ${randomBytes(8).toString('hex')}\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n`);
  const hash = createHash('sha256').update(obj).digest('hex');
  await request(port, 'PUT', `/v1/assets/${hash}`, { body: obj });
  const made = await request(port, 'POST', '/v1/scenes', {
    headers: { 'content-type': 'application/json' },
    body: JSON.stringify({ files: { 'a.obj': hash } }) });
  if (made.status === 503) return true;
  if (![200, 201].includes(made.status)) return false;
  const { name } = JSON.parse(made.body);
  return (await request(port, 'DELETE', `/v1/scenes/${name}`)).status === 204;
}

async function a_stream({ port }) {
  const stream = open_stream(port);
  await stream.opened;
  await sleep(3000 * Math.random());
  stream.close();
  return stream.status === 200;
}

async function a_refusal({ port }) {
  const bad = await post_job(port, { scene: '../x', samples: -1 });
  const missing = await request(port, 'GET', '/v1/jobs/j999999/tiles');
  return bad.status === 422 && missing.status === 404;
}

// The least of each eighth: what stays when the jobs of the moment have gone and the server has
// given back what they left.
function floor_of(samples) {
  const part = (i) => samples.slice(i * samples.length / 8, (i + 1) * samples.length / 8);
  return Array.from({ length: 8 }, (_, i) => part(i)).filter((one) => one.length > 0)
    .map((one) => one.reduce((least, sample) => (sample.mib < least.mib ? sample : least)));
}

// MiB per hour by least squares.
function growth(samples) {
  const n = samples.length, mean = (of) => samples.reduce((sum, one) => sum + of(one), 0) / n;
  const t = mean((one) => one.hours), m = mean((one) => one.mib);
  return samples.reduce((sum, one) => sum + (one.hours - t) * (one.mib - m), 0) /
    samples.reduce((sum, one) => sum + (one.hours - t) ** 2, 0);
}

export async function run({ short, minutes }, report) {
  if (short) minutes = 0.2;
  const server = await Server.start(scratch_folder());
  // The renderer's libraries start their threads with the first job, and the server keeps 256 MiB
  // of pictures: full, they grow no more.
  for (let i = 0; i < (short ? 1 : 24); ++i) {
    await server.wait(await server.post({ scene: 'furnace', samples: 1, method: 'none', seed: i,
      width: 1024, height: 1024 }));
  }
  const begin = performance.now(), end_at = begin + 60_000 * minutes;
  const going = () => performance.now() < end_at && server.alive;
  const quiet = { descriptors: server.descriptors(), threads: server.threads() };
  const samples = [], wrong = [], counts = {};
  const loops = (count, step) => in_parallel(count, going, 0, async () => {
    const good = await step(server).catch((error) => error.message);
    counts[step.name] = (counts[step.name] ?? 0) + 1;
    if (good !== true) wrong.push(`${step.name}: ${good}`);
  });
  const work = [loops(6, a_job), loops(1, an_upload), loops(8, a_stream), loops(1, a_refusal)];
  while (going()) {
    await sleep(2000);
    const sample = { hours: (performance.now() - begin) / 3.6e6, mib: mib(server.rss_bytes()),
      descriptors: server.descriptors() };
    samples.push(sample);
    if (process.env.QRAY_SOAK_LOG) {
      appendFileSync(join(process.env.QRAY_SOAK_LOG), `${JSON.stringify(sample)}\n`);
    }
  }
  await Promise.all(work);
  report.show(`memory: ${minutes} minutes`, Object.entries(counts)
    .map(([name, count]) => `${count} x ${name}`).join(', '));
  report.bar('memory: what went wrong', '0', `${wrong.length}${wrong[0] ? `: ${wrong[0]}` : ''}`,
    wrong.length === 0);
  const warm = samples.slice(Math.floor(samples.length / 3)); // caches and arenas fill before
  const rest = floor_of(warm);
  report.show('memory: smallest value in each eighth of the last two thirds',
    `${rest.map(({ mib }) => mib.toFixed(0)).join(', ')} MiB`);
  const shown = `${growth(rest).toFixed(0)} MiB/h, of all samples ${growth(warm).toFixed(0)}`;
  // It goes up and down by 25 MiB: minutes cannot tell a slope of so few an hour.
  if (minutes < 30) report.show('memory: growth, too short to judge', shown);
  else report.bar('memory: growth', '<= 20 MiB/h', shown, growth(rest) <= 20);
  for (let i = 0; i < 100 && server.threads() > quiet.threads; ++i) await sleep(200);
  const now = { descriptors: server.descriptors(), threads: server.threads() };
  report.bar('memory: descriptors, threads afterwards',
    `${quiet.descriptors} + 2, ${quiet.threads}`, `${now.descriptors}, ${now.threads}`,
    now.descriptors <= quiet.descriptors + 2 && now.threads <= quiet.threads);
  const end = await server.end();
  report.bar('memory: exit code', '0', end.code, end.code === 0);
}
