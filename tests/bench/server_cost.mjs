// What a picture costs through the server against `qray render` of the same job, in turns:
//   node tests/bench/server_cost.mjs BUILD [turns] [scene] [method] [samples]
// Prints medians and ratios of rendering seconds, of whole seconds (the command's process; the job
// from started to ended), and of processor seconds, which a busy machine disturbs least. The aim:
// at most 1.03. Linux only.
import { execFileSync, spawn } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';

const [build, turns = '7', scene = 'cornell-box', method = 'huang', samples = '64'] =
  process.argv.slice(2);
if (!build) throw new Error('expected the build folder');
const scratch = mkdtempSync(join(tmpdir(), 'qray-cost-'));
const median = values => values.sort((a, b) => a - b)[values.length >> 1];

function local_turn(seed) {
  const stats = join(scratch, 'stats.json');
  const start = performance.now();
  const times = execFileSync('bash', ['-c', '"$@" && times', 'bash', join(build, 'bin/qray'),
    'render', scene, '-q', '--method', method, '--spp', samples, '--seed', seed, '--json', stats,
    '-o', join(scratch, 'out.exr')]).toString();
  const children = times.trim().split('\n')[1].match(/(\d+)m([\d.]+)s (\d+)m([\d.]+)s/);
  const [, m1, s1, m2, s2] = children.map(Number);
  return { render: JSON.parse(readFileSync(stats)).seconds,
    whole: (performance.now() - start) / 1000, processor: 60 * (m1 + m2) + s1 + s2 };
}

// User and system time of a process so far; the kernel counts in hundredths of a second.
function processor_seconds(pid) {
  const fields = readFileSync(`/proc/${pid}/stat`, 'utf8').split(') ')[1].split(' ');
  return (Number(fields[11]) + Number(fields[12])) / 100;
}

async function server_turn(url, pid, seed) {
  const before = processor_seconds(pid);
  const request = { scene, method, samples: Number(samples), seed: Number(seed), table: 'none' };
  const posted = await fetch(`${url}/v1/jobs`, { method: 'POST', body: JSON.stringify(request),
    headers: { 'content-type': 'application/json' } });
  const { id } = await posted.json();
  if (posted.status !== 202) throw new Error(`the job was refused: ${posted.status}`);
  for (;;) {
    const job = await (await fetch(`${url}/v1/jobs/${id}`)).json();
    if (job.state === 'succeeded') {
      return { render: job.stats.seconds,
        whole: (Date.parse(job.ended) - Date.parse(job.started)) / 1000,
        processor: processor_seconds(pid) - before };
    }
    if (job.ended) throw new Error(`${id} ${job.state}`);
    await new Promise(resume => setTimeout(resume, 200));
  }
}

const server = spawn(join(build, 'bin/qrayd'), ['--port', '0', '--data', join(scratch, 'data')],
  { stdio: ['ignore', 'pipe', 'ignore'] });
try {
  const url = await new Promise((found, lost) => {
    server.stdout.on('data', text => found(/http:\S+/.exec(text)[0]));
    server.on('exit', () => lost(new Error('qrayd ended')));
  });
  const local = [], remote = [];
  for (let turn = 0; turn < Number(turns); ++turn) {
    local.push(local_turn(String(turn + 1)));
    remote.push(await server_turn(url, server.pid, String(turn + 1)));
  }
  for (const part of ['render', 'whole', 'processor']) {
    const a = median(local.map(t => t[part])), b = median(remote.map(t => t[part]));
    const ratio = median(local.map((t, i) => remote[i][part] / t[part]));
    const text = `qray ${a.toFixed(3)} s, qrayd ${b.toFixed(3)} s, ratio ${ratio.toFixed(3)}`;
    console.log(`${part}: ${text}`);
  }
} finally {
  server.removeAllListeners('exit');
  server.kill('SIGTERM');
  await new Promise(done => server.exitCode === null ? server.on('exit', done) : done());
  rmSync(scratch, { recursive: true, force: true });
}
