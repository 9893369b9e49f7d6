// The JSON Schema and the C++ loader must say the same of every scene document that a schema can
// judge. corpus/good_*.json pass both, corpus/bad_*.json fail both, corpus/loader_*.json break what
// only the loader can see. Mutants of the good ones widen the net.
import assert from 'node:assert/strict';
import {execFileSync} from 'node:child_process';
import {cpSync, mkdtempSync, readdirSync, readFileSync, rmSync, writeFileSync} from 'node:fs';
import {createRequire} from 'node:module';
import {tmpdir} from 'node:os';
import {join} from 'node:path';
import {test} from 'node:test';

const source = process.env.QRAY_SOURCE_DIR;
const corpus = join(source, 'tests/schema/corpus');
const require = createRequire(join(process.env.QRAY_SCHEMA_MODULES, 'x.js'));
const Ajv = require('ajv/dist/2020').default;
const schema = JSON.parse(readFileSync(join(source, 'scenes/scene.schema.json'), 'utf8'));
const validate = new Ajv({strict: true, strictRequired: false, strictTypes: false}).compile(schema);

// [{path, ok, error}] in the order of `paths`.
function loaderVerdicts(paths) {
  const lines = execFileSync(process.env.LOAD_VERDICT, paths, {maxBuffer: 1 << 26})
    .toString().trimEnd().split('\n');
  assert.equal(lines.length, paths.length);
  return lines.map((line, i) => ({
    path: paths[i], ok: line.startsWith('ok '), error: line.split('\t')[1] ?? '',
  }));
}
const schemaSays = (path) => validate(JSON.parse(readFileSync(path, 'utf8')));
const schemaError = () => JSON.stringify(validate.errors?.slice(0, 3));
const files = (prefix) => readdirSync(corpus).filter((f) => f.startsWith(prefix))
  .map((f) => join(corpus, f));

test('the schema and the loader pass the good documents and the included scenes', () => {
  const scenes = readdirSync(join(source, 'scenes'), {withFileTypes: true})
    .filter((entry) => entry.isDirectory())
    .map((entry) => join(source, 'scenes', entry.name, 'scene.json'));
  const paths = [...files('good_'), ...scenes];
  assert.ok(paths.length >= 10);
  for (const {path, ok, error} of loaderVerdicts(paths)) {
    assert.ok(ok, `${path}: the loader says ${error}`);
    assert.ok(schemaSays(path), `${path}: the schema says ${schemaError()}`);
  }
});

test('both refuse each document that breaks one rule', () => {
  const paths = files('bad_');
  assert.ok(paths.length >= 50);
  for (const {path, ok} of loaderVerdicts(paths)) {
    assert.ok(!ok, `${path}: the loader passes it`);
    assert.ok(!schemaSays(path), `${path}: the schema passes it`);
  }
});

test('the loader sees what a schema cannot', () => {
  const paths = files('loader_');
  assert.ok(paths.length >= 8);
  for (const {path, ok} of loaderVerdicts(paths)) {
    assert.ok(schemaSays(path), `${path}: the schema says ${schemaError()}`);
    assert.ok(!ok, `${path}: the loader passes it`);
  }
});

test('the schema passes the example of the format\'s page', () => {
  const page = readFileSync(join(source, 'docs/scene_format.md'), 'utf8');
  const example = JSON.parse(page.match(/```json\n([^]*?)```/)[1]);
  assert.ok(validate(example), schemaError());
});

// What the loader may refuse though the schema passes: names, indices, counts, files, geometry.
const beyondSchema = [
  /expected the name of a (material|texture)/, /is taken, expected a name of its own/,
  /no such file/, /expected at least one shape with an area/, /one a position/,
  /expected positions to refer to/, /triangles\/\d+\/\d+: expected an integer/,
  /quads\/\d+\/\d+: expected an integer/, /expected more than "min"/, /that keeps volume/,
  /expected the name of one mesh/, /a mesh of triangles/, /one scale for all directions/,
  /transform: expected a place within/,
  /inner_deg: expected 0 to the outer angle/,
  /camera(s\/[^/]*)?\/(target|up): expected a (point away|direction other)/,
  /expected at most \d+ pixels/, /a time after the one before it/, /one for each of "seconds"/,
];

const replacements = [null, true, 0, -1, 0.5, 3, 300, 1e7, 1e300, '', 'x', [], [0], [0, 0, 0],
  [1, 2, 3], [1, 'x', 3], {}, {texture: 'checker'}];

// Every document one step away: a value replaced, a member removed or added.
function* mutants(document) {
  function* walk(value, replace) {
    for (const r of replacements) yield replace(r);
    if (value === null || typeof value !== 'object') return;
    if (Array.isArray(value)) {
      const shown = value.length > 4 ? [0, value.length - 1] : value.keys();
      for (const i of shown) {
        yield* walk(value[i], (v) => replace(value.map((old, k) => k === i ? v : old)));
        yield replace(value.filter((_, k) => k !== i));
      }
      yield replace([...value, value[0] ?? 0]);
      return;
    }
    for (const key of Object.keys(value)) {
      yield* walk(value[key], (v) => replace({...value, [key]: v}));
      const {[key]: _, ...rest} = value;
      yield replace(rest);
    }
    yield replace({...value, unheard_of: 1});
  }
  yield* walk(document, (v) => v);
}

test('they agree on every mutant of the good documents', () => {
  const folder = mkdtempSync(join(tmpdir(), 'qray_schema_'));
  try {
    cpSync(corpus, folder, {recursive: true, filter: (path) => !path.endsWith('.json')});
    let count = 0, judged = 0;
    for (const good of files('good_')) {
      const paths = [], verdicts = [];
      for (const mutant of mutants(JSON.parse(readFileSync(good, 'utf8')))) {
        const path = join(folder, `${count++}.json`);
        writeFileSync(path, JSON.stringify(mutant));
        paths.push(path);
        verdicts.push(validate(mutant));
      }
      for (let i = 0; i < paths.length; i += 1000) {
        for (const [k, loader] of loaderVerdicts(paths.slice(i, i + 1000)).entries()) {
          const passes = verdicts[i + k];
          if (passes && !loader.ok && beyondSchema.some((r) => r.test(loader.error))) continue;
          ++judged;
          assert.equal(loader.ok, passes, `schema ${passes ? 'passes' : 'refuses'}, loader: ` +
            `${loader.error || 'passes'}\n${readFileSync(loader.path, 'utf8').slice(0, 2000)}`);
        }
      }
    }
    assert.ok(judged > 2000, `only ${judged} of ${count} mutants could be judged`);
  } finally {
    rmSync(folder, {recursive: true});
  }
});
