// A list of 200,000 jobs while eight clients ask for what matches none, or few, of them: others are
// answered all the same.
import { quantile, sleep } from './measure.mjs';
import { multiply, sql } from './many_jobs.mjs';
import { Server, scratch_folder } from './server.mjs';

const kFilters = ['label=project:none', 'label=project:lobby&label=kind:none',
  `table=${'0'.repeat(32)}`, 'created_before=2020-01-01T00:00:00Z', 'state=failed',
  'label=project:lobby&state=failed', 'ended_from=2100-01-01T00:00:00Z',
  'label=project:lobby&created_before=2020-01-01T00:00:00Z'];

export async function run({ short }, report) {
  const count = short ? 2000 : 200_000, seconds = short ? 2 : 20;
  const data = scratch_folder();
  let server = await Server.start(data);
  const first = await server.post({ scene: 'furnace', width: 32, height: 32, samples: 1,
    labels: { project: 'lobby' } });
  await server.wait(first);
  await server.end();
  multiply(data, 'jobs', 'id', count - 1);
  server = await Server.start(data);
  report.show('filters: jobs in the database', sql(data, 'SELECT COUNT(*) FROM jobs'));

  let on = true;
  const times = new Map(), wrong = [];
  const ask = async (what, path) => {
    while (on) {
      const answer = await server.get(path());
      if (answer.status !== 200) wrong.push(`${what}: ${answer.status}`);
      times.set(what, [...times.get(what) ?? [], answer.ms]);
      await sleep(5);
    }
  };
  const one = () => `/v1/jobs/j${String(1 + Math.floor(Math.random() * count)).padStart(6, '0')}`;
  const asked = [...kFilters.map((filter) => ask(filter, () => `/v1/jobs?${filter}`)),
    ask('list', () => '/v1/jobs?limit=50'), ask('one job', one), ask('health', () => '/healthz')];
  await sleep(1000 * seconds);
  on = false;
  await Promise.all(asked);
  report.bar('filters: answers', 'only 200', wrong.length === 0 ? 'all' : wrong[0],
    wrong.length === 0);
  const p99 = (what) => quantile(times.get(what), 0.99);
  for (const what of ['list', 'one job', 'health'])
    report.time(`filters: ${what}, p99 of ${times.get(what).length}`, 'ms', 20, p99(what));
  for (const filter of kFilters)
    report.show(`filters: ${filter}, p99`, `${p99(filter).toFixed(1)} ms`);
  await server.end();
}
