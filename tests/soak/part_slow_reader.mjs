// Readers of tiles that hardly read: what they cost the renderer. Jobs with and without them in
// turns on one server. Judged are rays per second of the processor that the whole server took,
// which other work on the machine disturbs least.
import net from 'node:net';
import { median, sleep } from './measure.mjs';
import { Server, scratch_folder } from './server.mjs';

const kReaders = 32;

// Asks for all tiles, takes them at 16 KB a second, and asks again when it lost its connection.
function slow_reader(port, id, going) {
  if (!going.on) return;
  const socket = net.connect(port, '127.0.0.1', () => {
    socket.pause();
    socket.write(`GET /v1/jobs/${id}/tiles?since=0 HTTP/1.1\r\nHost: localhost\r\n\r\n`);
  });
  const sips = setInterval(() => socket.read(4096), 250);
  going.sockets.add(socket);
  socket.on('error', () => {}).on('close', () => {
    clearInterval(sips);
    going.sockets.delete(socket);
    setTimeout(() => slow_reader(port, id, going), 50);
  });
}

export async function run({ short, turns }, report) {
  if (short) turns = 1;
  const server = await Server.start(scratch_folder());
  const rates = { alone: [], read: [] }, per_processor = { alone: [], read: [] };
  for (let turn = 0; turn < 2 * turns; ++turn) {
    const kind = (turn + (turn >> 1)) % 2 === 0 ? 'alone' : 'read'; // a b b a a b ...
    const id = await server.post({ scene: 'cornell-box', method: 'adaptive', table: 'none',
      seconds: short ? 2 : 8, seed: 1 });
    const going = { on: true, sockets: new Set() };
    await server.wait_running(id);
    const before = server.processor_seconds();
    if (kind === 'read') for (let i = 0; i < kReaders; ++i) slow_reader(server.port, id, going);
    const job = await server.wait(id);
    going.on = false;
    going.sockets.forEach((socket) => socket.destroy());
    rates[kind].push(job.stats.rays_per_second / 1e6);
    per_processor[kind].push(job.stats.rays / 1e6 / (server.processor_seconds() - before));
    await sleep(300);
  }
  for (const [kind, name] of [['alone', 'alone'], ['read', `${kReaders} readers at 16 KB/s`]]) {
    report.show(`slow-reader: ${name}, median of ${turns}`,
      `${median(rates[kind]).toFixed(2)} million rays/s, ` +
      `${median(per_processor[kind]).toFixed(3)} a processor second`);
  }
  report.show('slow-reader: spread alone, a processor second',
    `${Math.min(...per_processor.alone).toFixed(3)} .. ` +
    `${Math.max(...per_processor.alone).toFixed(3)}`);
  report.time('slow-reader: what they cost', '%', 3,
    100 * (1 - median(per_processor.read) / median(per_processor.alone)));
  const health = await server.get('/healthz');
  report.bar('slow-reader: /healthz afterwards', '200', health.status, health.status === 200);
  await server.end();
}
