// What the parts measure with: probes of the server's health, quantiles, pictures' hashes.
import { createHash } from 'node:crypto';
import http from 'node:http';
import { setTimeout as sleep } from 'node:timers/promises';
import { Worker } from 'node:worker_threads';
import { request } from './server.mjs';

export const quantile = (values, q) =>
  [...values].sort((a, b) => a - b)[Math.min(values.length - 1, Math.floor(q * values.length))];
export const median = (values) => quantile(values, 0.5);
export const mib = (bytes) => bytes / (1 << 20);

// Asks /healthz every `every_ms` over one kept connection, in a thread of its own event loop so
// that a busy caller is not measured. stop() resolves to the milliseconds of each answer; Infinity
// for a request that failed twice, or was not 200.
export function probe_health(port, every_ms = 20) {
  const worker = new Worker(new URL('./probe_worker.mjs', import.meta.url),
    { workerData: { port, every_ms } });
  return {
    async stop() {
      const times = new Promise((resolve) => worker.once('message', resolve));
      worker.postMessage('stop');
      const all = await times;
      await worker.terminate();
      return all;
    },
  };
}

// A job's stream of server-sent events: [{id, kind, data, at}] grows while it is open.
export function open_stream(port, path = '/v1/events', headers = {}) {
  const stream = { events: [], comments: [], status: 0, ended: false };
  stream.opened = new Promise((resolve, reject) => {
    const call = http.get({ host: '127.0.0.1', port, path, headers, agent: false }, (response) => {
      stream.status = response.statusCode;
      let text = '';
      response.setEncoding('utf8').on('data', (chunk) => {
        text += chunk;
        const blocks = text.split('\n\n');
        text = blocks.pop();
        for (const block of blocks) take(block);
      });
      response.on('close', () => { stream.ended = true; });
      response.on('error', () => {});
    });
    const take = (block) => {
      if (block.includes(': qray')) resolve(stream);
      const field = (name) => new RegExp(`^${name}: ?(.*)$`, 'm').exec(block)?.[1];
      if (!field('event')) return stream.comments.push(performance.now());
      stream.events.push({ id: Number(field('id')), kind: field('event'),
        data: JSON.parse(field('data')), at: performance.now() });
    };
    call.on('error', (error) => { stream.ended = true; reject(error); });
    call.on('response', (response) => response.statusCode !== 200 && resolve(stream));
    stream.close = () => call.destroy();
  });
  stream.opened.catch(() => {});
  return stream;
}

// Of an OpenEXR file's pixels as stored, without its header, which holds times.
export function exr_pixels_hash(file) {
  let at = 8;
  while (file[at] !== 0) { // name, type, size, value
    at = file.indexOf(0, at) + 1;
    at = file.indexOf(0, at) + 1;
    at += 4 + file.readUInt32LE(at);
  }
  return createHash('sha256').update(file.subarray(Number(file.readBigUInt64LE(at + 1))))
    .digest('hex');
}

export async function picture_hash(server, id) {
  const answer = await server.get(`/v1/jobs/${id}/image.exr`);
  return answer.status === 200 ? exr_pixels_hash(answer.body) : `status ${answer.status}`;
}

// `count` loops of `step(loop)` until `going()` is false, `pause_ms` apart.
export const in_parallel = (count, going, pause_ms, step) =>
  Promise.all(Array.from({ length: count }, async (_, loop) => {
    while (going()) {
      await step(loop);
      if (pause_ms) await sleep(pause_ms);
    }
  }));

export { request, sleep };
