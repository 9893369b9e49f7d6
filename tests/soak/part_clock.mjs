// The time of day jumps a day ahead, two back and home again while a job, an event stream and
// connections are open: nothing that waits may wait for that clock. Needs Debian's faketime.
import { existsSync, readdirSync, writeFileSync } from 'node:fs';
import net from 'node:net';
import { join } from 'node:path';
import { open_stream, sleep } from './measure.mjs';
import { Server, request, scratch_folder } from './server.mjs';

const kDay = 86_400;
const library = () => readdirSync('/usr/lib', { withFileTypes: true })
  .map((entry) => join('/usr/lib', entry.name, 'faketime/libfaketimeMT.so.1')).find(existsSync);

// How long a connection lives that sends `text` and no more.
const life_of = (port, text) => new Promise((resolve) => {
  const begin = performance.now();
  const socket = net.connect(port, '127.0.0.1', () => socket.write(text));
  socket.on('close', () => resolve((performance.now() - begin) / 1000)).on('error', () => {});
  socket.resume();
});

export async function run({ short }, report) {
  const preload = library();
  if (!preload) return report.skip('clock', 'faketime is not installed');
  const folder = scratch_folder(), control = join(folder, 'clock');
  const set = (seconds) => writeFileSync(control, `${seconds < 0 ? '' : '+'}${seconds}s\n`);
  set(0);
  const server = await Server.start(join(folder, 'data'), { env: { LD_PRELOAD: preload,
    FAKETIME_TIMESTAMP_FILE: control, FAKETIME_NO_CACHE: '1',
    FAKETIME_DONT_FAKE_MONOTONIC: '1', DONT_FAKE_MONOTONIC: '1' } });
  const stream = open_stream(server.port);
  await stream.opened;
  const step = short ? 2 : 6;

  const begin = performance.now();
  const id = await server.post({ scene: 'furnace', seconds: 4 * step, table: 'none' });
  const slow_head = life_of(server.port, 'GET /healthz HTT');
  const idle = life_of(server.port, '');
  const answers = [];
  const days = [];
  for (const offset of [kDay, -kDay, 0]) {
    await sleep(1000 * step);
    set(offset);
    answers.push((await request(server.port, 'GET', '/healthz')).status);
    const tiny = await server.post({ scene: 'furnace', samples: 1, width: 16, height: 16 });
    const { created } = await server.job(tiny);
    days.push(Math.round((Date.parse(created) - Date.now()) / 1000 / kDay));
  }
  report.bar('clock: the jumps are seen, days', '1, -1, 0', days.join(', '),
    days.join() === '1,-1,0');
  report.bar('clock: /healthz after each', '200 x 3', answers.join(' '),
    answers.every((status) => status === 200));
  const job = await server.wait(id);
  const took = (performance.now() - begin) / 1000;
  report.bar(`clock: a job of ${4 * step} s`, `succeeded within ${4 * step} .. ${4 * step + 5} s`,
    `${job.state} after ${took.toFixed(1)} s`,
    job.state === 'succeeded' && took >= 4 * step - 0.5 && (short || took <= 4 * step + 5));
  for (const other of (await server.all_jobs())) await server.wait(other.id);
  await sleep(1000);
  const ids = stream.events.map((event) => event.id);
  const done = stream.events.filter((event) => event.kind === 'done').length;
  report.bar('clock: event stream', 'open, ids rise, 4 x done',
    `${stream.ended ? 'ended' : 'open'}, ${done} x done`,
    !stream.ended && done === 4 && ids.every((one, i) => i === 0 || one > ids[i - 1]));
  const progress = stream.events.filter((event) => event.data.job === id &&
    event.kind === 'progress').map((event) => event.at);
  const gap = Math.max(...progress.slice(1).map((at, i) => at - progress[i])) / 1000;
  report.time('clock: longest pause between progress events', 's', 3, gap);
  const beats = stream.comments.length;
  set(-kDay);
  await sleep(12_000);
  report.bar('clock: heartbeats in 12 s after another jump', '>= 1', stream.comments.length - beats,
    stream.comments.length > beats);
  const head_s = await slow_head, idle_s = await idle;
  report.bar('clock: an unfinished head ends after 5 s', '4 .. 8 s', head_s.toFixed(1),
    short || (head_s > 4 && head_s < 8));
  report.bar('clock: a silent connection ends after 15 s', '14 .. 18 s', idle_s.toFixed(1),
    short || (idle_s > 14 && idle_s < 18));
  const end = await server.end();
  report.bar('clock: exit code', '0', end.code, end.code === 0);
}
