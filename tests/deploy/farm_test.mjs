// What can be said of a farm's files without the engines that run them: their form, that options
// and variables that they name are the program's, and that the systemd unit passes its own check.
import assert from 'node:assert/strict';
import { execFileSync, spawnSync } from 'node:child_process';
import { chmodSync, copyFileSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { test } from 'node:test';

const source = process.env.QRAY_SOURCE_DIR;
const read = (name) => readFileSync(join(source, name), 'utf8');
const help = execFileSync(process.env.QRAYD, ['--help'], { encoding: 'utf8' });
const files = ['docker/compose.farm.yml', 'docker/farm/kubernetes.yml',
  'docker/farm/slurm_array.sh', 'docker/systemd/qrayd-worker.service'];

test('every option and variable that they name is one of qrayd', () => {
  const in_comments = /^\s*#.*$/gm;
  for (const file of files) {
    const text = read(file).replace(in_comments, '');
    const of_qrayd = file.endsWith('.yml')
      ? [...text.matchAll(/(?:command|args|entrypoint): (\[.*\])/g)].flatMap(([, words]) =>
        JSON.parse(words)).filter((word) => word.startsWith('--'))
      : [...text.matchAll(/qrayd worker(?:[^\n]*\\\n)*[^\n]*/g)].flatMap(([line]) =>
        line.match(/--[a-z-]+/g) ?? []);
    for (const option of of_qrayd) assert.ok(help.includes(`${option} `), `${file}: ${option}`);
    for (const [name] of text.matchAll(/QRAYD_[A-Z_]+/g)) {
      if (name === 'QRAYD_DATA' || name === 'QRAYD_STORE' || file.endsWith('.sh')) continue;
      assert.fail(`${file}: ${name}`);
    }
    assert.match(text, /worker/, file);
  }
  assert.match(help, /QRAYD_STORE/);
  assert.match(help, /QRAYD_DATA/);
});

test('the YAML files are YAML, with the parts that the guide names', (t) => {
  const parse = 'import sys, json, yaml; ' +
    'print(json.dumps(list(yaml.safe_load_all(open(sys.argv[1])))))';
  const run = (file) => spawnSync('python3', ['-c', parse, join(source, file)],
    { encoding: 'utf8' });
  if (/No module named .yaml/.test(run(files[0]).stderr)) return t.skip('python3-yaml is not here');
  const documents = (file) => {
    const { stdout, stderr, status } = run(file);
    assert.equal(status, 0, `${file}: ${stderr}`);
    return JSON.parse(stdout);
  };
  const [{ services }] = documents('docker/compose.farm.yml');
  assert.deepEqual(Object.keys(services).sort(), ['db', 'front', 'worker']);
  for (const name of ['front', 'worker']) {
    assert.match(services[name].environment.QRAYD_STORE, /^postgresql:\/\//);
    assert.deepEqual(services[name].volumes, ['data:/data']);
  }
  const kinds = documents('docker/farm/kubernetes.yml').map(({ kind, metadata }) =>
    `${kind} ${metadata.name}`);
  assert.deepEqual(kinds, ['PersistentVolumeClaim qray-data', 'Service qray',
    'Deployment qray-front', 'Deployment qray-worker']);
});

test('the array script starts a worker with what Slurm gave it', () => {
  const folder = mkdtempSync(join(tmpdir(), 'qray-slurm-'));
  try {
    // What `srun` is given, for want of Slurm.
    writeFileSync(join(folder, 'srun'), '#!/bin/sh\necho "$@"\n');
    chmodSync(join(folder, 'srun'), 0o755);
    const run = (env) => spawnSync('bash', [join(source, 'docker/farm/slurm_array.sh')],
      { encoding: 'utf8', env: { PATH: `${folder}:${process.env.PATH}`, ...env } });
    assert.match(run({}).stderr, /expected postgresql/);
    const { stdout, status } = run({ QRAYD_STORE: 'postgresql://db/qray', QRAYD_DATA: '/srv/qray',
      SLURM_CPUS_PER_TASK: '8', SLURM_MEM_PER_NODE: '16384' });
    assert.equal(status, 0);
    assert.equal(stdout.trim(), 'qrayd worker --threads 8 --jobs-mib 12288');
  } finally {
    rmSync(folder, { recursive: true });
  }
});

test('the unit passes systemd-analyze verify and is as closed as the server\'s', (t) => {
  if (spawnSync('systemd-analyze', ['--version']).status !== 0) return t.skip('no systemd here');
  const folder = mkdtempSync(join(tmpdir(), 'qray-unit-'));
  try {
    const unit = join(folder, 'qrayd-worker.service');
    const program = join(folder, 'qrayd');
    copyFileSync(process.env.QRAYD, program);
    writeFileSync(unit, read('docker/systemd/qrayd-worker.service')
      .replace('/usr/local/bin/qrayd', program));
    const { stdout, stderr } = spawnSync('systemd-analyze', ['verify', unit],
      { encoding: 'utf8' });
    assert.equal(stdout + stderr, '');
    const most = 18; // tenths: it has a network, and a user that stays
    const rated = spawnSync('systemd-analyze',
      ['security', '--offline=yes', `--threshold=${most}`, unit], { encoding: 'utf8' });
    assert.equal(rated.status, 0, rated.stdout.trim().split('\n').at(-1));
  } finally {
    rmSync(folder, { recursive: true });
  }
});

test('qrayd says what a worker lacks', () => {
  const run = (args) => spawnSync(process.env.QRAYD, args, { encoding: 'utf8' });
  assert.match(run(['worker', '--data', '/nowhere']).stderr, /--store: expected postgresql/);
  const folder = mkdtempSync(join(tmpdir(), 'qray-none-'));
  const unreached = run(['--store', 'postgresql://u:secret@127.0.0.1:1/x', '--data', folder,
    '--port', '0']);
  rmSync(folder, { recursive: true });
  assert.equal(unreached.status, 1);
  assert.match(unreached.stderr, /PostgreSQL cannot be reached|without PostgreSQL/);
  assert.doesNotMatch(unreached.stderr, /secret/);
});
