// Wrong requests, made from the contract that a running server gives out: every field missing, of
// another type, extreme or hostile, in bodies, queries and paths. Whatever the contract's schema
// refuses gets a 4xx of problem+json that names the field; nothing gets a 5xx; the server stays up.
import assert from 'node:assert/strict';
import { Agent, request } from 'node:http';
import { createRequire } from 'node:module';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { Server, env, scratch_folder } from '../e2e/support.mjs';

const Ajv = createRequire(join(env('QRAY_SCHEMA_MODULES'), 'package.json'))('ajv/dist/2020.js');
const agent = new Agent({ keepAlive: true, maxSockets: 4 });
const kJson = { 'content-type': 'application/json' };
const kHash = '0'.repeat(64);

let server;
let contract;
let ajv;
let job; // renders for as long as the test does, so that what is accepted only waits
const asked = { total: 0, refused: 0 };

before(async () => {
  server = await Server.start(scratch_folder(),
    { more: ['--max-queued', '100000', '--threads', '1', '--jobs-at-once', '1'] });
  contract = await (await server.get('/openapi.json')).json();
  ajv = new Ajv({ strict: false, validateFormats: false });
  ajv.addSchema({ $id: 'contract', ...contract });
  job = await server.post({ scene: 'cornell-box', seconds: 3600, width: 16, height: 16 });
});
after(async () => {
  agent.destroy();
  await server?.stop();
});

// An event stream resolves with its head.
const send = (method, path, headers = {}, body = '') => new Promise((resolve, reject) => {
  asked.total += 1;
  const call = request({ agent, host: '127.0.0.1', port: server.port, method, path,
    headers: { ...headers, 'content-length': Buffer.byteLength(body) } }, (response) => {
    const type = response.headers['content-type'] ?? '';
    const chunks = [];
    const done = () => resolve({ method, status: response.statusCode, type,
      text: Buffer.concat(chunks).toString() });
    if (type.startsWith('text/event-stream')) {
      done();
      response.destroy();
      return;
    }
    response.on('data', (chunk) => chunks.push(chunk));
    response.on('end', done);
    response.on('error', reject);
  });
  call.on('error', reject);
  call.end(body);
});

const short = (text) => (text.length > 200 ? `${text.slice(0, 200)}...` : text);

// `wrong`: the contract's schema refuses it, so the server must.
function judge(what, answer, { wrong, field = null, pointers = null }) {
  assert.ok(answer.status < 500, `${what}: ${answer.status} ${answer.text}`);
  if (wrong) assert.ok(answer.status >= 400, `${what} was taken: ${answer.status}`);
  if (answer.status < 400) return;
  asked.refused += 1;
  assert.equal(answer.type, 'application/problem+json', what);
  if (answer.method === 'HEAD') return; // its answers have no body
  const problem = JSON.parse(answer.text);
  const good = ajv.getSchema('contract#/components/schemas/Problem');
  assert.ok(good(problem), `${what}: ${JSON.stringify(good.errors)}`);
  assert.equal(problem.status, answer.status, what);
  if (!wrong || answer.status !== 422 || field === null) return;
  const named = (problem.errors ?? []).map((error) => error.pointer);
  const fits = (pointer) => pointer === `/${field}` || pointer.startsWith(`/${field}/`) ||
    pointers?.includes(pointer);
  assert.ok(named.some(fits), `${what}: expected /${field}, got ${answer.text}`);
}

function resolved(node) {
  if (!node?.$ref) return node;
  return node.$ref.slice(2).split('/').reduce((at, name) => at[name], contract);
}

const check = (schema) => ajv.compile({ $id: undefined, ...rebased(schema) });

// References as seen from outside of the document.
function rebased(node) {
  if (Array.isArray(node)) return node.map(rebased);
  if (node === null || typeof node !== 'object') return node;
  return Object.fromEntries(Object.entries(node).map(([name, value]) =>
    [name, name === '$ref' ? `contract${value}` : rebased(value)]));
}

function operations() {
  const found = [];
  for (const [pattern, item] of Object.entries(contract.paths)) {
    for (const method of ['get', 'head', 'post', 'put', 'patch', 'delete']) {
      if (!item[method]) continue;
      const parameters = [...(item.parameters ?? []), ...(item[method].parameters ?? [])];
      found.push({ method: method.toUpperCase(), pattern, operation: item[method],
        parameters: parameters.map(resolved) });
    }
  }
  return found;
}

// An address that exists as far as that can be.
const good_path = ({ pattern }) => pattern
  .replace('/v1/jobs/{id}', `/v1/jobs/${job}`)
  .replace('{sha256}', kHash).replace('{name}', 'cornell-box').replace('{id}', '0'.repeat(32));

const nested = (depth) => '['.repeat(depth) + ']'.repeat(depth);
// As JSON text, so that they may be what no JavaScript value is.
const kValues = ['null', 'true', '0', '-1', '0.5', '1e308', '-1e308', '1e400', '1e-400',
  '9223372036854775808', '18446744073709551616', '-9223372036854775809', '""', '"x"', '"../../x"',
  '"\\u0000"', '"a\\u0000b"', '"\\ud800"', '"\\udc00\\ud800"', '"\\u202egnp.exe"', '"\\ufeff"',
  '"\u{1f600}"', `"${'x'.repeat(65536)}"`, `"${'\u{1f600}'.repeat(16384)}"`, '[]', '{}', '[null]',
  '[1,2,3]', '["x","x"]', '{"x":1}', '{"__proto__":1}', '{"":""}', nested(30), nested(40),
  nested(50_000)];

function parsed(text) {
  try {
    return { value: JSON.parse(text), json: true };
  } catch {
    return { json: false };
  }
}

// Complete bodies that differ in the one field.
const with_field = (base, name, text) =>
  `{${[...Object.entries(base).filter(([other]) => other !== name)
    .map(([other, value]) => `${JSON.stringify(other)}:${JSON.stringify(value)}`),
  `${JSON.stringify(name)}:${text}`].join(',')}}`;

const kBases = {
  'POST /v1/jobs': [{ scene: 'cornell-box', samples: 1 }, { scene: 'cornell-box', seconds: 1 }],
  'POST /v1/scenes': [{ files: { 'a.obj': kHash } }, { asset: kHash, type: 'glb' }],
  'POST /v1/tables/merge': [{ tables: ['0'.repeat(32), '1'.repeat(32)] }],
  'POST /v1/session': [{ token: 'x' }],
  'POST /v1/webhooks': [{ url: 'https://example.org/' }],
  'PATCH /v1/jobs/{id}': [{ priority: 1, labels: { a: 'b' } }],
};

// What a schema asks for at least.
function example(schema) {
  const at = resolved(schema);
  if (at.const !== undefined) return at.const;
  if (at.enum) return at.enum[0];
  if (at.anyOf) return example(at.anyOf[0]);
  const type = [at.type].flat()[0];
  if (type === 'object') {
    return Object.fromEntries((at.required ?? []).map((name) =>
      [name, example(at.properties[name])]));
  }
  if (type === 'array') return Array.from({ length: at.minItems ?? 0 }, () => example(at.items));
  if (type === 'integer' || type === 'number') return at.minimum ?? 1;
  return type === 'boolean' ? true : 'x';
}

test('bodies', async (t) => {
  const with_bodies = operations().filter(({ operation }) =>
    operation.requestBody?.content['application/json']);
  assert.ok(with_bodies.length >= 4);
  for (const call of with_bodies) {
    const name = `${call.method} ${call.pattern}`;
    await t.test(name, async () => {
      const path = good_path(call);
      const schema = resolved(call.operation.requestBody.content['application/json'].schema);
      const is_good = check(schema);
      const post = async (body, field = null) => {
        const { value, json } = parsed(body);
        const answer = await send(call.method, path, kJson, body);
        judge(`${name} ${short(body)}`, answer, { wrong: !json || !is_good(value), field,
          pointers: schema.oneOf ? [''] : null });
      };
      const bases = kBases[name] ?? [example(schema)];
      for (const [field, about] of Object.entries(schema.properties ?? {})) {
        const base = bases.find((candidate) => field in candidate) ?? bases[0];
        for (const text of kValues) await post(with_field(base, field, text), field);
        const inner = resolved(about).properties ?? {};
        for (const member of Object.keys(inner)) {
          for (const text of kValues) {
            await post(with_field(base, field, with_field({}, member, text)), field);
          }
        }
      }
      for (const base of bases) {
        for (const field of Object.keys(base)) {
          const { [field]: _, ...rest } = base;
          const missing = (schema.required ?? []).includes(field);
          await post(JSON.stringify(rest), missing ? field : null);
        }
        for (const field of ['surprise', 'a~b', 'é', '', 'x'.repeat(300)]) {
          await post(with_field(base, field, '1'));
        }
        await post(with_field(base, 'surprise', '1'), 'surprise');
        const wrong_type = await send(call.method, path, { 'content-type': 'text/plain' },
          JSON.stringify(base));
        judge(`${name} as text`, wrong_type, { wrong: true });
      }
      for (const body of ['', ' ', 'null', '7', '"x"', '[]', '{', '}', '{"a":1', '{"a" 1}', '{,}',
        '{"a":NaN}', "{'a':1}", '\u0000', '\ufeff{}', nested(40), nested(100_000),
        '{"a":'.repeat(1000), `${JSON.stringify(bases[0])}x`, `"${'x'.repeat(65536)}"`]) {
        await post(body);
      }
      for (const bytes of [[0xff], [0x7b, 0x22, 0xff, 0x22, 0x3a, 0x31, 0x7d], [0xc0, 0x80]]) {
        judge(`${name} ${bytes}`, await send(call.method, path, kJson, Buffer.from(bytes)),
          { wrong: true });
      }
    });
  }
});

test('bodies where none is asked for', async () => {
  for (const call of operations()) {
    if (!['POST', 'PUT', 'PATCH'].includes(call.method)) continue;
    if (/(cancel|pause)$/.test(call.pattern)) continue; // of the job behind which others wait
    for (const body of ['', '{', 'x'.repeat(65536)]) {
      const answer = await send(call.method, good_path(call),
        { 'content-type': 'application/octet-stream' }, body);
      judge(`${call.method} ${call.pattern}`, answer, { wrong: false });
    }
  }
});

const kTexts = ['', '0', '-1', '1', '1.5', '1e308', '1e999', 'nan', 'inf', '0x10', '+1', ' 1', '1 ',
  '1,2', '18446744073709551616', '-9223372036854775809', 'x', 'null', '[]', '../..', '\u0000',
  'a\u0000b', '\u202egnp', '\u{1f600}', '%', "'", '"', '<b>', 'x'.repeat(900)];

test('queries', async (t) => {
  for (const call of operations()) {
    const query = call.parameters.filter((parameter) => parameter.in === 'query');
    const unknown = await send(call.method, `${good_path(call)}?surprise=1`);
    judge(`${call.method} ${call.pattern}?surprise`, unknown, { wrong: true });
    for (const parameter of query) {
      await t.test(`${call.method} ${call.pattern} ${parameter.name}`, async () => {
        const whole = resolved(parameter.schema);
        const schema = whole.type === 'array' ? whole.items : parameter.schema;
        const is_good = check(schema);
        const kinds = [resolved(schema), ...(resolved(schema).oneOf ?? [])];
        const numeric = kinds.some(({ type }) => ['integer', 'number'].includes(type));
        const others = query.filter((other) => other.required && other !== parameter)
          .map((other) => `&${other.name}=${example(other.schema)}`).join('');
        for (const text of kTexts) {
          const value = numeric && /^-?[0-9]+(\.[0-9]+)?$/.test(text) ? Number(text) : text;
          const path = `${good_path(call)}?${parameter.name}=${encodeURIComponent(text)}${others}`;
          // Some read an empty one as none, and a job that has nothing to show answers that first.
          judge(path, await send(call.method, path),
            { wrong: text !== '' && !is_good(value), field: parameter.name });
        }
        for (const raw of ['%', '%zz', '%ff', '%00', '%ed%a0%80', 'a&'.repeat(200)]) {
          const path = `${good_path(call)}?${parameter.name}=${raw}${others}`;
          judge(path, await send(call.method, path), { wrong: false });
        }
      });
    }
  }
});

test('paths', async () => {
  const hostile = ['x', '-1', '0', 'j0', 'j999999999999999999999', '..', '.', '%2e%2e', '%2f',
    '%5c', '%00', 'a%00b', '%ff', '%ed%a0%80', '%zz', '%', encodeURIComponent('\u202e\u{1f600}'),
    'x:y', "';--", 'x'.repeat(900), 'x'.repeat(65536), '{id}', kHash, '0'.repeat(32)];
  for (const call of operations().filter(({ pattern }) => pattern.includes('{'))) {
    for (const text of hostile) {
      const path = call.pattern.replace(/\{[a-z0-9]+\}/, () => text);
      let answer;
      try {
        answer = await send(call.method, path);
      } catch (error) {
        // Over the bound of a whole head the connection ends, at times before the answer was read.
        assert.ok(text.length > 16_000, `${call.method} ${short(path)}: ${error}`);
        continue;
      }
      if (call.method === 'HEAD') {
        assert.ok(answer.status < 500, path);
        continue;
      }
      judge(`${call.method} ${short(path)}`, answer, { wrong: false });
    }
  }
});

test('the server is as it was', async () => {
  assert.ok(asked.total > 1500 && asked.refused > 1000, JSON.stringify(asked));
  assert.equal((await (await server.get('/healthz')).json()).status, 'ok');
  assert.equal((await server.job(job)).state === 'failed', false);
  const metrics = await (await server.get('/metrics')).text();
  assert.match(metrics, /^qray_http_errors_total 0$/m);
});
