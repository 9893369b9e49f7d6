// 1,000 jobs at once behind one that renders on all processors: each is accepted or told to come
// again, and what was accepted is there afterwards, once, and ends.
import http from 'node:http';
import { quantile, sleep } from './measure.mjs';
import { Server, if_known, post_job, scratch_folder } from './server.mjs';

export async function run({ short, clients }, report) {
  const count = short ? 120 : 1000, max_queued = short ? 100 : 900;
  const server = await Server.start(scratch_folder(),
    { options: ['--max-queued', String(max_queued), ...if_known('--jobs-at-once', 1)] });
  const first = await server.post({ scene: 'cornell-box', samples: 1_000_000, table: 'none' });
  await server.wait_running(first);

  const agent = new http.Agent({ keepAlive: true, maxSockets: clients });
  const times = { 202: [], 429: [] }, accepted = new Map(), other = [];
  let next = 0, answered = 0, without_hint = 0, overtaken = 0;
  await Promise.all(Array.from({ length: clients }, async () => {
    while (next < count) {
      const seed = ++next;
      const job = { scene: 'furnace', width: 16, height: 16, samples: 1, method: 'none', seed };
      const before = answered;
      const answer = await post_job(server.port, job, { agent }).catch((error) => error);
      overtaken = Math.max(overtaken, answered++ - before);
      if (!times[answer.status]) { other.push(answer.status ?? answer.message); continue; }
      times[answer.status].push(answer.ms);
      if (answer.status === 202) accepted.set(JSON.parse(answer.body).id, seed);
      else if (!answer.headers['retry-after']) ++without_hint;
    }
  }));
  agent.destroy();
  const all_ms = [...times[202], ...times[429]];
  report.bar(`burst: answers to ${count} jobs from ${clients} clients`, 'only 202, 429',
    `${times[202].length} and ${times[429].length}${other.length ? `, ${other[0]}` : ''}`,
    other.length === 0 && all_ms.length === count);
  report.bar('burst: of these, beyond --max-queued', `${count - max_queued} x 429`,
    times[429].length, times[429].length === count - max_queued && without_hint === 0);
  report.time('burst: POST p99', 'ms', 50, quantile(all_ms, 0.99));
  report.show('burst: POST median and worst',
    `${quantile(all_ms, 0.5).toFixed(1)} and ${Math.max(...all_ms).toFixed(0)} ms`);

  report.show('burst: others answered during one POST, at most', overtaken);

  const check = (jobs, what, good) => {
    const seeds = new Map(jobs.map((job) => [job.id, job.request.seed]));
    const there = [...accepted].filter(([id, seed]) => seeds.get(id) === seed).length;
    const extra = jobs.length - 1 - there;
    report.bar(`burst: accepted jobs in the list ${what}`, `${accepted.size}, none more`,
      `${there}, ${extra} more`, there === accepted.size && extra === 0 && good(jobs));
  };
  check(await server.all_jobs(), 'at once', () => true);
  await server.cancel(first);
  for (const newest = [...accepted.keys()].sort().at(-1); ; await sleep(200)) {
    if ((await server.job(newest)).ended) break;
  }
  const jobs = await server.all_jobs();
  check(jobs, 'afterwards, all succeeded',
    () => jobs.every((job) => job.id === first || job.state === 'succeeded'));
  const end = await server.end();
  report.bar('burst: exit code', '0', end.code, end.code === 0);
}
