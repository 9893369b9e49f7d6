// A start with 10,000 jobs of before: rows and pictures copied from one that ran here.
import { linkSync, mkdirSync, readdirSync } from 'node:fs';
import { join } from 'node:path';
import { multiply, sql } from './many_jobs.mjs';
import { quantile } from './measure.mjs';
import { Server, scratch_folder } from './server.mjs';

export async function run({ short }, report) {
  const count = short ? 1000 : 10_000;
  const data = scratch_folder();
  let server = await Server.start(data);
  const first = await server.post({ scene: 'furnace', width: 32, height: 32, samples: 1 });
  await server.wait(first);
  await server.end();
  multiply(data, 'jobs', 'id', count - 1);
  multiply(data, 'events', 'id', 3 * count);
  sql(data, "UPDATE counters SET value = (SELECT max(id) FROM events) WHERE name = 'event'");
  const files = readdirSync(join(data, 'results', first));
  for (let i = 2; i <= count; ++i) {
    const folder = join(data, 'results', `j${String(i).padStart(6, '0')}`);
    mkdirSync(folder);
    for (const file of files) linkSync(join(data, 'results', first, file), join(folder, file));
  }

  const starts = [];
  for (let i = 0; i < (short ? 1 : 5); ++i) {
    server = await Server.start(data);
    starts.push(server.started_ms / 1000);
    if (i === 0) {
      const jobs = await server.all_jobs();
      report.bar('old-jobs: in the list', `${count}`, jobs.length, jobs.length === count);
      const pages = [];
      for (let n = 0; n < 50; ++n) pages.push((await server.get('/v1/jobs?limit=50')).ms);
      report.show('old-jobs: a page of 50, median', `${quantile(pages, 0.5).toFixed(1)} ms`);
      const last = `j${String(count).padStart(6, '0')}`;
      const picture = await server.get(`/v1/jobs/${last}/image.png`);
      report.bar(`old-jobs: picture of ${last}`, '200', picture.status, picture.status === 200);
      const job = await server.wait(await server.post({ scene: 'furnace', samples: 1, width: 16,
        height: 16 }));
      report.bar('old-jobs: a new job', 'succeeded', job.state, job.state === 'succeeded');
    }
    await server.end();
  }
  report.time(`old-jobs: ready with ${count} jobs, worst of ${starts.length}`, 's', 2,
    Math.max(...starts));
}
