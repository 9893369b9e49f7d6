// 200 event streams and 64 clients as busy as the page, while a job renders on all processors.
import http from 'node:http';
import { in_parallel, median, open_stream, probe_health, quantile, request, sleep }
  from './measure.mjs';
import { Server, if_known, scratch_folder } from './server.mjs';

export async function run({ short }, report) {
  const stream_count = short ? 40 : 200, client_count = short ? 8 : 64, seconds = short ? 3 : 30;
  const server = await Server.start(scratch_folder(), { options: if_known('--max-streams', 256) });
  const streams = Array.from({ length: stream_count }, () => open_stream(server.port));
  await Promise.all(streams.map((stream) => stream.opened));
  const open = streams.filter((stream) => stream.status === 200).length;
  report.bar('streams: opened', `${stream_count}`, open, open === stream_count);

  const quiet = probe_health(server.port);
  await sleep(short ? 500 : 3000);
  const quiet_ms = await quiet.stop();

  const id = await server.post({ scene: 'cornell-box', seconds, table: 'none' });
  await server.wait_running(id);
  const probe = probe_health(server.port);
  const agent = new http.Agent({ keepAlive: true, maxSockets: client_count });
  const calls = [], cursors = Array(client_count).fill(0n), wrong = [];
  let going = true;
  // As the page does: the job's state, and the tiles that are new; now and then the list.
  const clients = in_parallel(client_count, () => going, 100, async (client) => {
    const paths = [`/v1/jobs/${id}`, `/v1/jobs/${id}/tiles?since=${cursors[client]}`];
    if (calls.length % 10 === 0) paths.push('/v1/jobs?limit=20');
    for (const path of paths) {
      const answer = await request(server.port, 'GET', path, { agent }).catch((error) => error);
      if (answer.status !== 200) { wrong.push(answer.message ?? answer.status); continue; }
      calls.push(answer.ms);
      if (path.includes('tiles')) cursors[client] = answer.body.readBigUInt64LE(12);
    }
  });
  const job = await server.wait(id);
  going = false;
  const health_ms = await probe.stop();
  await clients;
  await sleep(1500); // what was published reaches its readers
  agent.destroy();

  const of_job = streams.map((stream) => stream.events.filter((event) => event.data.job === id));
  const every = new Set(of_job.flatMap((events) => events.map((event) => event.id)));
  const whole = of_job.filter((events) => events.length === every.size &&
    events.at(-1)?.kind === 'done' &&
    events.every((event, i) => i === 0 || event.id > events[i - 1].id)).length;
  report.bar('streams: the job', 'succeeded', job.state, job.state === 'succeeded');
  report.bar(`streams: with all ${every.size} events once, in order`, `${stream_count}`, whole,
    whole === stream_count);
  const late = of_job.flatMap((events) => events.map((event) => event.at -
    Math.min(...of_job.map((others) => others.find((e) => e.id === event.id)?.at ?? event.at))));
  report.show('streams: an event at its last reader after its first, p99',
    `${quantile(late, 0.99).toFixed(1)} ms`);
  report.bar(`streams: calls of ${client_count} clients refused`, '0',
    `${wrong.length} of ${calls.length}${wrong.length ? `: ${wrong[0]}` : ''}`, !wrong.length);
  report.show('streams: their calls, median and p99',
    `${median(calls).toFixed(1)} ms, ${quantile(calls, 0.99).toFixed(1)} ms`);
  report.show('streams: /healthz p99 without a job', `${quantile(quiet_ms, 0.99).toFixed(2)} ms`);
  report.time(`streams: /healthz p99 of ${health_ms.length} while it renders`, 'ms', 50,
    quantile(health_ms, 0.99));
  report.show('streams: memory and threads', `${(server.rss_bytes() / 2 ** 20).toFixed(0)} MiB, ` +
    `${server.threads()}`);
  streams.forEach((stream) => stream.close());
  const end = await server.end();
  report.bar('streams: exit code', '0', end.code, end.code === 0);
}
