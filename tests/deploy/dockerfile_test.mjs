// What can be said of the Dockerfile and compose.yml without an engine: the form of each
// instruction, that what is copied is there, and that ports, folders and options agree with each
// other and with the server. docker/rehearse.sh runs what they name.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { existsSync, readFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';

const source = process.env.QRAY_SOURCE_DIR;
const read = (name) => readFileSync(join(source, name), 'utf8');

// [{stage, name, rest}], with lines joined and comments left out.
function instructions() {
  const text = read('docker/Dockerfile').replace(/^\s*#.*\n/gm, '').replace(/\\\n/g, ' ');
  let stage = -1;
  return text.split('\n').filter((line) => line.trim()).map((line) => {
    const [, name, rest] = /^([A-Z]+)\s+(.*)$/.exec(line) ?? assert.fail(`not one: ${line}`);
    if (name === 'FROM') ++stage;
    return { stage, name, rest };
  });
}
const all = instructions();
const of = (name) => all.filter((one) => one.name === name);
const last = (name) => of(name).at(-1)?.rest ?? assert.fail(`no ${name}`);
const exec_form = (text) => {
  const words = JSON.parse(text.slice(text.indexOf('[')));
  assert.ok(words.length > 0 && words.every((word) => typeof word === 'string'), text);
  return words;
};

test('every instruction is known and every command in exec form', () => {
  const known = ['FROM', 'COPY', 'RUN', 'ARG', 'VOLUME', 'USER', 'WORKDIR', 'EXPOSE', 'STOPSIGNAL',
    'HEALTHCHECK', 'ENTRYPOINT', 'CMD'];
  for (const { name, rest } of all) {
    assert.ok(known.includes(name), name);
    if (['RUN', 'CMD', 'ENTRYPOINT', 'VOLUME'].includes(name)) exec_form(rest);
  }
  assert.match(last('HEALTHCHECK'), / CMD \[/);
  assert.equal(last('STOPSIGNAL'), 'SIGTERM');
});

test('what is copied is there and not ignored', () => {
  const ignored = read('.dockerignore').split('\n').filter(Boolean);
  const debian_12 = /^debian:bookworm(?:-slim)?(?: AS (\w+))?$/;
  const stages = of('FROM').map(({ rest }) => debian_12.exec(rest));
  assert.ok(stages.every(Boolean), 'both stages are Debian 12');
  for (const { stage, rest } of of('COPY')) {
    const [, from, words] = /^(?:--from=(\w+) )?(.*)$/.exec(rest);
    if (from) {
      assert.ok(stages.slice(0, stage).some((match) => match[1] === from), from);
      continue;
    }
    for (const name of words.split(' ').slice(0, -1)) {
      assert.ok(existsSync(join(source, name)), name);
      assert.ok(!ignored.includes(name.split('/')[0]), `${name} is in .dockerignore`);
    }
  }
});

test('the server is no root, and its port, folder and options agree', () => {
  assert.notEqual(last('USER'), 'root');
  const entry = exec_form(last('ENTRYPOINT'));
  assert.equal(entry[0], 'qrayd');
  const value = (option) => entry[entry.indexOf(option) + 1];
  assert.equal(value('--port'), last('EXPOSE'));
  assert.deepEqual(exec_form(last('VOLUME')), [value('--data')]);
  assert.equal(exec_form(last('HEALTHCHECK')).at(-1), last('EXPOSE'));
  const help = execFileSync(process.env.QRAYD, ['--help'], { encoding: 'utf8' });
  const words = [...entry, ...exec_form(last('CMD'))];
  for (const word of words.filter((one) => one.startsWith('--'))) {
    assert.ok(help.includes(`${word} `), `qrayd has no ${word}`);
  }
});

test('compose.yml runs this image, confined', () => {
  const compose = read('docker/compose.yml');
  for (const line of ['dockerfile: docker/Dockerfile', 'read_only: true', 'cap_drop: [ALL]',
    'no-new-privileges:true', 'mem_limit:', `"127.0.0.1:8080:${last('EXPOSE')}"`,
    `data:${exec_form(last('VOLUME'))[0]}`]) {
    assert.ok(compose.includes(line), line);
  }
  assert.ok(exec_form(last('CMD')).includes('/run/secrets/qray_tokens'));
  assert.match(compose, /^ {2}qray_tokens:\n {4}file: /m);
});
