// Bad manners and attacks on one server, each followed by a look at its health; 1,000 silent
// connections; and an end in the middle of it. What each answers is tested in tests/server; here it
// is what they cost together.
import net from 'node:net';
import { mib, probe_health, quantile, sleep } from './measure.mjs';
import { Server, scratch_folder } from './server.mjs';

const kHost = 'Host: localhost\r\n';
const post = (headers, body = '') => `POST /v1/jobs HTTP/1.1\r\n${kHost}${headers}\r\n\r\n${body}`;
const sized = (body) =>
  post(`Content-Type: application/json\r\nContent-Length: ${body.length}`, body);

// Connects, sends all of `parts` as far as it is let, and resolves to the first answer's status: 0
// when the connection was closed without one, or none came in `patience_ms`.
function send(port, parts, patience_ms = 8000) {
  return new Promise((resolve) => {
    let answer = '';
    const socket = net.connect(port, '127.0.0.1');
    const end = () => {
      socket.destroy();
      resolve(Number(/^HTTP\/1.1 (\d+)/.exec(answer)?.[1] ?? 0));
    };
    socket.setTimeout(patience_ms, end);
    socket.on('data', (chunk) => {
      answer = (answer + chunk).slice(0, 64);
      if (answer.length >= 12) end();
    });
    socket.on('error', () => {}).on('close', end);
    socket.on('connect', async () => {
      for (const part of parts) {
        if (socket.destroyed) return;
        if (!socket.write(part)) {
          await new Promise((go) => { socket.once('drain', go); socket.once('close', go); });
        }
      }
    });
  });
}

const repeat = function* (count, part) { for (let i = 0; i < count; ++i) yield part; };

// name, how many at once, what each sends, the statuses that are right.
const kAttacks = [
  ['a header line of 64 MB', 4, () => ['GET / HTTP/1.1\r\nA: ', ...repeat(1024, 'a'.repeat(65536))],
    [431, 0]],
  ['endless chunked bodies', 8, () => [post('Transfer-Encoding: chunked'),
    ...repeat(2000, `10000\r\n${'z'.repeat(65536)}\r\n`)], [411, 0]],
  ['a body of 10 GB announced', 8, () => [post('Content-Length: 10737418240')], [413]],
  ['lengths that differ', 8, () => [post('Content-Length: 3\r\nContent-Length: 4', 'abcd')], [400]],
  ['a negative length', 8, () => [post('Content-Length: -1')], [400]],
  ['a gzip bomb', 8, () => [post('Content-Encoding: gzip\r\nContent-Length: 3', 'abc')], [415]],
  ['multipart', 8, () => [post('Content-Type: multipart/form-data; boundary=x\r\n' +
    'Content-Length: 3', 'abc')], [415]],
  ['200 overlapping ranges', 8, () => [`GET /index.html HTTP/1.1\r\n${kHost}Range: bytes=` +
    `${Array(200).fill('0-').join(',')}\r\n\r\n`], [416, 431]],
  ['a path of 100 KB', 8, () => [`GET /${'a/'.repeat(50_000)} HTTP/1.1\r\n${kHost}\r\n`],
    [414, 431, 0]],
  ['a path that leads out', 8, () => [`GET /../../etc/passwd HTTP/1.1\r\n${kHost}\r\n`],
    [400, 404]],
  ['100,000 nested arrays', 8, () => [sized('['.repeat(100_000))], [400, 422]],
  ['4 MiB of JSON', 8, () => [sized(`{"scene":"${'a'.repeat((4 << 20) - 20)}"}`)], [422]],
  ['10,000 header fields', 8, () => [`GET / HTTP/1.1\r\n${'a: b\r\n'.repeat(10_000)}\r\n`],
    [431, 0]],
  ['noise', 64, () => [Buffer.from(Array.from({ length: 4096 }, () => 256 * Math.random()))],
    [400, 408, 431, 501, 0]],
  ['a page of another site', 8, () => [`POST /v1/jobs HTTP/1.1\r\n${kHost}` +
    'Origin: http://evil.example\r\nContent-Length: 2\r\n\r\n{}'], [403]],
  ['10,000 requests in a row, unread', 8, () => repeat(100,
    `GET /healthz HTTP/1.1\r\n${kHost}\r\n`.repeat(100)), [200]],
];

// Opens `count` connections that say nothing, or the beginning of something.
const open_many = (port, count, text = '') => Promise.all(Array.from({ length: count }, () =>
  new Promise((resolve) => {
    const socket = net.connect(port, '127.0.0.1', () => {
      if (text) socket.write(text);
      resolve(socket);
    });
    socket.on('error', () => resolve(socket));
    socket.resume();
  })));
const drop = (sockets) => sockets.forEach((socket) => socket.destroy());

export async function run({ short }, report) {
  const server = await Server.start(scratch_folder());
  const rss = server.rss_bytes(), descriptors = server.descriptors();

  const judge = (name, ms) => {
    const answered = ms.filter((one) => one !== Infinity);
    report.bar(`attacks: ${name}: /healthz unanswered`, '0', `${ms.length - answered.length} of ` +
      `${ms.length}`, answered.length === ms.length && ms.length > 0);
    report.time(`attacks: ${name}: /healthz p99`, 'ms', 100, quantile(ms, 0.99));
  };

  // Step 1: one kind of attack after the other.
  let all_ms = [];
  for (const [name, count, parts, right] of kAttacks) {
    const probe = probe_health(server.port, 10);
    const statuses = await Promise.all(
      Array.from({ length: short ? Math.min(count, 4) : count }, () => send(server.port, parts())));
    await sleep(100);
    all_ms = all_ms.concat(await probe.stop());
    const wrong = statuses.filter((status) => !right.includes(status));
    report.bar(`attacks: ${name}, ${statuses.length} at once`, right.join(' or '),
      wrong.length ? wrong.join(' ') : statuses[0], wrong.length === 0);
  }
  // Step 2: more connections than there are places, each of which holds on to its own.
  const many = short ? 600 : 1000;
  const body = `${post('Content-Type: application/json\r\nContent-Length: 1000')}{`;
  for (const [name, text] of [['silent connections', ''], ['unfinished heads', 'GET /healthz HTT'],
    ['unfinished bodies', body]]) {
    const probe = probe_health(server.port, 10);
    const sockets = await open_many(server.port, many, text);
    await sleep(short ? 500 : 3000);
    judge(`${many} ${name}`, await probe.stop());
    const grown = mib(server.rss_bytes() - rss);
    report.bar(`attacks: ${many} ${name}: memory over the beginning`, '<= 64 MiB',
      `${grown.toFixed(0)} MiB`, grown <= 64);
    drop(sockets);
  }
  const flood = probe_health(server.port, 10);
  for (let i = 0; i < (short ? 2 : 20); ++i) {
    drop(await open_many(server.port, 150));
    await sleep(100);
  }
  judge('connections that come and go', await flood.stop());
  judge('the first sixteen', all_ms);

  // Step 3: afterwards.
  for (let i = 0; i < 300 && server.descriptors() > descriptors + 1; ++i) await sleep(100);
  report.bar('attacks: descriptors afterwards', `<= ${descriptors} + 1`, server.descriptors(),
    server.descriptors() <= descriptors + 1);
  report.show('attacks: memory afterwards, over the beginning',
    `${mib(server.rss_bytes() - rss).toFixed(0)} MiB`);
  const sockets = [...await open_many(server.port, 300), ...await open_many(server.port, 50,
    `GET /v1/events HTTP/1.1\r\n${kHost}\r\n`)];
  await server.wait_running(await server.post({ scene: 'furnace', samples: 1_000_000 }));
  const end = await server.end();
  drop(sockets);
  report.bar('attacks: exit code with 300 silent connections, 50 streams, a job', '0', end.code,
    end.code === 0);
  report.time('attacks: SIGTERM to its end', 's', 2, end.ms / 1000);
}
