// docker/nginx/qray.conf with Debian's nginx before a real server: TLS, events as they come,
// uploads, ids of requests, and limits of clients. nginx runs as a process of this test.
import assert from 'node:assert/strict';
import { execFileSync, spawn } from 'node:child_process';
import { createHash, randomBytes } from 'node:crypto';
import { mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import http2 from 'node:http2';
import https from 'node:https';
import net from 'node:net';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { setTimeout as sleep } from 'node:timers/promises';
import { Server, env, scratch_folder } from '../e2e/support.mjs';

const kHost = 'qray.example';
let server, nginx, port, ca;

async function free_port() {
  const listener = net.createServer().listen(0, '127.0.0.1');
  await new Promise((resolve) => listener.once('listening', resolve));
  const { port } = listener.address();
  await new Promise((resolve) => listener.close(resolve));
  return port;
}

// The example with this test's ports and files in place of a machine's.
function configuration(folder, http_port, https_port) {
  let text = readFileSync(join(env('QRAY_SOURCE_DIR'), 'docker/nginx/qray.conf'), 'utf8');
  for (const [there, here] of [
    ['listen 443 ssl', `listen 127.0.0.1:${https_port} ssl`],
    ['listen 80;', `listen 127.0.0.1:${http_port};`],
    ['server 127.0.0.1:8080;', `server 127.0.0.1:${server.port};`],
    ['/etc/ssl/qray/cert.pem', join(folder, 'cert.pem')],
    ['/etc/ssl/qray/key.pem', join(folder, 'key.pem')],
    ['/var/log/nginx/qray.log', join(folder, 'access.log')],
  ]) {
    assert.ok(text.includes(there), `qray.conf has no '${there}'`);
    text = text.replace(there, here);
  }
  const scratch = ['client_body', 'proxy', 'fastcgi', 'uwsgi', 'scgi']
    .map((name) => `${name}_temp_path ${join(folder, name)};`).join('\n');
  return `daemon off; master_process off; pid ${join(folder, 'pid')}; error_log stderr warn;
    events { worker_connections 512; }
    http { ${scratch}\n${text} }`;
}

const options = (more = {}) => ({ host: '127.0.0.1', port, ca, servername: kHost,
  ...more, headers: { host: `${kHost}:${port}`, ...more.headers } });

// {status, headers, text} of one request over TLS.
function call(method, path, { body, headers, agent } = {}) {
  return new Promise((resolve, reject) => {
    const request = https.request(options({ method, path, headers, agent }), (response) => {
      let text = '';
      response.setEncoding('utf8').on('data', (chunk) => { text += chunk; });
      response.on('end', () => resolve(
        { status: response.statusCode, headers: response.headers, text }));
    });
    request.on('error', reject).end(body);
  });
}

const json = (value) => ({ body: JSON.stringify(value),
  headers: { 'content-type': 'application/json' } });

before(async () => {
  const folder = scratch_folder();
  server = await Server.start(join(folder, 'data'), { more: ['--names', kHost] });
  execFileSync('openssl', ['req', '-x509', '-newkey', 'ec', '-pkeyopt',
    'ec_paramgen_curve:prime256v1', '-nodes', '-days', '2', '-subj', `/CN=${kHost}`, '-addext',
    `subjectAltName=DNS:${kHost}`, '-keyout', join(folder, 'key.pem'), '-out',
    join(folder, 'cert.pem')], { stdio: 'ignore' });
  ca = readFileSync(join(folder, 'cert.pem'));
  port = await free_port();
  mkdirSync(join(folder, 'logs'));
  const conf = join(folder, 'nginx.conf');
  writeFileSync(conf, configuration(folder, await free_port(), port));
  // Debian has it where only root's path leads.
  const path = `${process.env.PATH}:/usr/sbin:/sbin`;
  nginx = spawn('nginx', ['-p', folder, '-c', conf, '-e', 'stderr'],
    { stdio: ['ignore', 'ignore', 'pipe'], env: { ...process.env, PATH: path } });
  let said = '';
  nginx.stderr.on('data', (chunk) => { said += chunk; });
  nginx.on('error', (error) => { said += error.message; });
  process.on('exit', () => nginx.kill('SIGKILL'));
  for (let i = 0; ; ++i) {
    const answer = await call('GET', '/healthz').catch(() => null);
    if (answer?.status === 200) break;
    assert.ok(i < 200, `nginx does not answer; it said: ${said}`);
    await sleep(50);
  }
});

after(async () => {
  nginx?.kill('SIGTERM');
  await server?.stop();
});

test('health, and an id for every request', async () => {
  const answer = await call('GET', '/healthz');
  assert.deepEqual(JSON.parse(answer.text), { status: 'ok' });
  assert.match(answer.headers['x-request-id'], /^[0-9a-f]{32}$/);
  assert.ok(answer.headers['strict-transport-security']);
  const named = await call('GET', '/healthz', { headers: { 'x-request-id': 'mine-1' } });
  assert.equal(named.headers['x-request-id'], 'mine-1');
  const bad = await call('GET', '/healthz', { headers: { 'x-request-id': 'a'.repeat(65) } });
  assert.match(bad.headers['x-request-id'], /^[0-9a-f]{32}$/);
});

test('a job with its events as they come', async () => {
  const events = new Promise((resolve, reject) => {
    const request = https.get(options({ path: '/v1/events' }), (response) => {
      assert.equal(response.statusCode, 200);
      let text = '';
      response.setEncoding('utf8').on('data', async (chunk) => {
        text += chunk;
        // Posted once the stream is open: a buffering proxy would hold the greeting back.
        if (chunk.includes(': qray')) {
          const posted = await call('POST', '/v1/jobs',
            json({ scene: 'cornell-box', width: 64, height: 64, samples: 4 }));
          if (posted.status !== 202) reject(new Error(posted.text));
        }
        if (!text.includes('event: done')) return;
        request.destroy();
        resolve(text);
      });
    });
    request.on('error', reject);
  });
  const text = await events;
  for (const state of ['queued', 'preparing', 'succeeded']) assert.ok(text.includes(state), text);
  const png = await call('GET', '/v1/jobs/j000001/image.png');
  assert.equal(png.status, 200);
});

test('the page itself may post, also over HTTP/2; a page of another site may not', async () => {
  const post = (origin) => call('POST', '/v1/jobs', { body: '{}',
    headers: { 'content-type': 'application/json', origin } });
  assert.equal((await post(`https://${kHost}:${port}`)).status, 422); // judged by its fields
  assert.equal((await post('https://elsewhere.example')).status, 403);

  const session = http2.connect(`https://127.0.0.1:${port}`, { ca, servername: kHost });
  const status = await new Promise((resolve, reject) => {
    const request = session.request({ ':method': 'POST', ':path': '/v1/jobs',
      ':authority': `${kHost}:${port}`, 'content-type': 'application/json',
      origin: `https://${kHost}:${port}` });
    request.on('response', (headers) => resolve(headers[':status'])).on('error', reject);
    request.end('{}'); // without a length: nginx counts it
  });
  session.close();
  assert.equal(status, 422);
});

test('uploads pass up to their limits', async () => {
  const asset = randomBytes(5 << 20); // more than other calls may send
  const path = `/v1/assets/${createHash('sha256').update(asset).digest('hex')}`;
  assert.equal((await call('PUT', path, { body: asset })).status, 201);
  assert.equal((await call('HEAD', path)).status, 200);
  const large = await call('POST', '/v1/jobs', { body: asset,
    headers: { 'content-type': 'application/json' } }).catch(() => ({ status: 413 }));
  assert.equal(large.status, 413);
});

test('a client has so many streams, and so many calls a second', async () => {
  const open = () => new Promise((resolve, reject) => {
    const request = https.get(options({ path: '/v1/events', agent: false }), (response) => {
      response.resume();
      resolve({ status: response.statusCode, close: () => request.destroy() });
    });
    request.on('error', reject);
  });
  const streams = [];
  for (let i = 0; i < 20; ++i) streams.push(await open());
  const count = (status) => streams.filter((stream) => stream.status === status).length;
  assert.deepEqual([count(200), count(429)], [16, 4]);
  streams.forEach((stream) => stream.close());

  const agent = new https.Agent({ keepAlive: true, maxSockets: 16 });
  const calls = await Promise.all(Array.from({ length: 600 }, () =>
    call('GET', '/healthz', { agent }).then((answer) => answer.status)));
  agent.destroy();
  assert.ok(calls.includes(200));
  // A machine so slow that 600 calls take seconds stays below the rate.
  assert.deepEqual(calls.filter((status) => status !== 200 && status !== 429), []);
});
