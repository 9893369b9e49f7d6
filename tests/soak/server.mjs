// A qrayd process under trial: started in any wrapping, killed, measured from outside. Linux only.
import assert from 'node:assert/strict';
import { execFileSync, spawn } from 'node:child_process';
import { mkdtempSync, readFileSync, readdirSync, rmSync } from 'node:fs';
import http from 'node:http';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { setTimeout as sleep } from 'node:timers/promises';

const kStartMs = 60_000;
const running = new Set();
const folders = [];
process.on('exit', () => {
  running.forEach((child) => child.kill('SIGKILL'));
  folders.forEach((folder) => rmSync(folder, { recursive: true, force: true }));
});
for (const signal of ['SIGINT', 'SIGTERM']) process.on(signal, () => process.exit(130));

// Removed when the process ends.
export function scratch_folder() {
  const folder = mkdtempSync(join(tmpdir(), 'qray-soak-'));
  folders.push(folder);
  return folder;
}

// {status, headers, body, ms} of one request. `agent`: keep-alive connections of the caller's own.
export function request(port, method, path, { body, headers = {}, agent, timeout = 30_000 } = {}) {
  return new Promise((resolve, reject) => {
    const begin = performance.now();
    const call = http.request({ host: '127.0.0.1', port, method, path, agent, headers, timeout },
      (response) => {
        const chunks = [];
        response.on('data', (chunk) => chunks.push(chunk));
        response.on('error', reject);
        response.on('end', () => resolve({ status: response.statusCode,
          headers: response.headers, body: Buffer.concat(chunks), ms: performance.now() - begin }));
      });
    call.on('timeout', () => call.destroy(new Error(`${method} ${path}: no answer`)));
    call.on('error', reject);
    call.end(body);
  });
}

export const post_job = (port, job, more = {}) => request(port, 'POST', '/v1/jobs',
  { ...more, body: JSON.stringify(job),
    headers: { 'content-type': 'application/json', ...more.headers } });

// `option value` when this qrayd has that option, else nothing.
export function if_known(option, value) {
  const help = execFileSync(process.env.QRAYD, ['--help'], { encoding: 'utf8' });
  return help.includes(`${option} `) ? [option, String(value)] : [];
}

export class Server {
  #child;
  #ended;
  said = '';
  port = 0;
  started_ms = 0; // from spawning to the first answer

  // Rejects when the server ends before it listens. `wrap(program, args)` gives another command
  // line whose process becomes the server's.
  static async start(data, { options = [], env = {}, wrap = (...line) => line } = {}) {
    const server = new Server();
    const begin = performance.now();
    const [program, args] =
      wrap(process.env.QRAYD, ['--port', '0', '--data', data, ...options]);
    const child = spawn(program, args,
      { stdio: ['ignore', 'pipe', 'pipe'], env: { ...process.env, ...env } });
    server.#child = child;
    running.add(child);
    server.#ended = new Promise((resolve) => child.once('exit', (code, signal) => {
      running.delete(child);
      resolve(signal ?? code);
    }));
    const keep = (chunk) => { server.said = (server.said + chunk).slice(-100_000); };
    child.stderr.on('data', keep);
    server.port = await new Promise((resolve, reject) => {
      const give_up = (why) => reject(new Error(`qrayd ${why}; it said: ${server.said}`));
      const timer = setTimeout(() => give_up('is silent'), kStartMs);
      child.stdout.on('data', (chunk) => {
        const match = /listening on http:\/\/127\.0\.0\.1:(\d+)/.exec(chunk);
        if (!match) return;
        clearTimeout(timer);
        resolve(Number(match[1]));
      });
      child.on('error', reject);
      server.#ended.then((code) => { clearTimeout(timer); give_up(`ended with ${code}`); });
    });
    assert.equal((await server.get('/healthz')).status, 200);
    server.started_ms = performance.now() - begin;
    return server;
  }

  get pid() { return this.#child.pid; }
  get alive() { return running.has(this.#child); }

  // {code, ms}: how it ended, and how soon.
  async end(signal = 'SIGTERM') {
    const begin = performance.now();
    this.#child.kill(signal);
    const patience = setTimeout(() => this.#child.kill('SIGKILL'), 60_000);
    const code = await this.#ended;
    clearTimeout(patience);
    return { code, ms: performance.now() - begin };
  }

  rss_bytes() {
    return 1024 * Number(/VmRSS:\s+(\d+)/.exec(readFileSync(`/proc/${this.pid}/status`))[1]);
  }
  // User and system time so far; the kernel counts in hundredths of a second.
  processor_seconds() {
    const fields = readFileSync(`/proc/${this.pid}/stat`, 'utf8').split(') ')[1].split(' ');
    return (Number(fields[11]) + Number(fields[12])) / 100;
  }
  descriptors() { return readdirSync(`/proc/${this.pid}/fd`).length; }
  threads() { return readdirSync(`/proc/${this.pid}/task`).length; }

  get(path, more) { return request(this.port, 'GET', path, more); }

  async json(path) {
    const answer = await this.get(path);
    assert.equal(answer.status, 200, `GET ${path}: ${answer.body}`);
    return JSON.parse(answer.body);
  }
  job(id) { return this.json(`/v1/jobs/${id}`); }

  // The id of a job that must be accepted.
  async post(job) {
    const answer = await post_job(this.port, job);
    assert.equal(answer.status, 202, `${answer.body}`);
    return JSON.parse(answer.body).id;
  }
  cancel(id) { return request(this.port, 'POST', `/v1/jobs/${id}/cancel`); }

  async wait(id, done = (job) => job.ended, seconds = 600) {
    const until = Date.now() + 1000 * seconds;
    for (;;) {
      const job = await this.job(id);
      if (done(job)) return job;
      assert.ok(Date.now() < until, `${id} stays ${job.state}`);
      await sleep(50);
    }
  }
  wait_running(id) {
    return this.wait(id, (job) => ['learning', 'rendering'].includes(job.state));
  }

  // All jobs, newest first.
  async all_jobs() {
    const jobs = [];
    for (let before = ''; ;) {
      const page = await this.json(`/v1/jobs?limit=200${before && `&before=${before}`}`);
      jobs.push(...page.jobs);
      if (!page.next) return jobs;
      before = page.next;
    }
  }
}
