// The thread of probe_health() in measure.mjs.
import http from 'node:http';
import { setTimeout as sleep } from 'node:timers/promises';
import { parentPort, workerData } from 'node:worker_threads';
import { request } from './server.mjs';

const agent = new http.Agent({ keepAlive: true, maxSockets: 1 });
const times = [];
let going = true;
parentPort.on('message', () => { going = false; });
const ask = () => request(workerData.port, 'GET', '/healthz', { agent, timeout: 5000 });
while (going) {
  const begin = performance.now();
  // A kept connection may be closed before a call reaches it, to make room; clients ask again.
  const answer = await ask().catch(ask).catch(() => ({}));
  times.push(answer.status === 200 ? performance.now() - begin : Infinity);
  await sleep(workerData.every_ms);
}
parentPort.postMessage(times);
agent.destroy();
