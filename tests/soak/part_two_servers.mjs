// Two servers on one data folder: the second says why it does not start, the first goes on.
import { Server, scratch_folder } from './server.mjs';

export async function run(_, report) {
  const data = scratch_folder();
  const first = await Server.start(data);
  const why = await Server.start(data).then(() => 'it started', (error) => error.message);
  report.bar('two-servers: the second', 'ends with 1 and a reason',
    why.split('it said: ').at(-1).trim().slice(0, 120),
    why.includes('ended with 1') && why.includes('another server uses this data folder'));
  const health = await first.get('/healthz');
  report.bar('two-servers: the first', '200', health.status, health.status === 200);
  await first.end('SIGKILL');
  const third = await Server.start(data);
  report.bar('two-servers: one after a kill -9', 'starts', 'starts', true);
  await third.end();
}
