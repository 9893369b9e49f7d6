// A page of somebody else's whose name leads to this machine after it was loaded: for the browser
// it is of one origin with the server, which must tell by the name alone.
import assert from 'node:assert/strict';
import { createServer } from 'node:http';
import { after, before, test } from 'node:test';
import { Browser, Server, scratch_folder } from './support.mjs';

const kName = 'rebinding.test';

let server, browser;
before(async () => {
  browser = await Browser.start([`--host-resolver-rules=MAP ${kName} 127.0.0.1`]);
});
after(async () => {
  await browser?.close();
  await server?.stop();
});

// What the page's own origin answers it, by method and path.
const ask = (page) => page.evaluate(async () => {
  const job = JSON.stringify({ scene: 'furnace', width: 8, height: 8, samples: 1 });
  const headers = { 'Content-Type': 'application/json' };
  const answers = {};
  for (const [method, path, body] of [['GET', '/v1/jobs'], ['GET', '/v1/scenes'],
    ['GET', '/v1/events'], ['POST', '/v1/jobs', job], ['DELETE', '/v1/jobs?state=succeeded']]) {
    const stop = new AbortController();
    const answer = await fetch(path, { method, body, headers: body ? headers : {},
      signal: stop.signal });
    answers[`${method} ${path}`] = answer.status;
    stop.abort();
  }
  return answers;
});

test('a name that was bound again to this machine reads and writes nothing', async () => {
  const theirs = createServer((_, answer) => {
    answer.setHeader('Content-Type', 'text/html');
    answer.end('<!doctype html><title>a page of somebody else</title><p>hello');
  });
  await new Promise((listening) => theirs.listen(0, '127.0.0.1', listening));
  const { port } = theirs.address();
  const page = await browser.page(`http://${kName}:${port}/`, { ready: 'p' });
  await new Promise((closed) => {
    theirs.close(closed);
    theirs.closeAllConnections();
  });
  server = await Server.start(scratch_folder(), { port }); // where their server was
  const asked = await ask(page);
  assert.deepEqual(new Set(Object.values(asked)), new Set([421]), JSON.stringify(asked));
  assert.deepEqual((await server.get('/v1/jobs').then((r) => r.json())).jobs, []);

  // By the server's own name the same is answered, so that it is the name that was refused.
  const known = await ask(await browser.page(`http://localhost:${port}/`));
  assert.deepEqual(Object.values(known), [200, 200, 200, 202, 200], JSON.stringify(known));
});
