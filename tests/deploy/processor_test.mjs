// One installation serves every processor: a program goes on as the one for this processor.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { chmodSync, copyFileSync, mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync }
  from 'node:fs';
import { tmpdir } from 'node:os';
import { dirname, join } from 'node:path';
import { test } from 'node:test';

const newer_processor = / avx2 /.test(readFileSync('/proc/cpuinfo', 'utf8'));

test('a program goes on as the one for this processor, if that is installed and runs', () => {
  const prefix = mkdtempSync(join(tmpdir(), 'qray-processor-'));
  try {
    const program = join(prefix, 'bin/qray');
    const newer = join(prefix, 'lib/qray/x86-64-v3/qray');
    mkdirSync(dirname(program));
    mkdirSync(dirname(newer), { recursive: true });
    copyFileSync(join(dirname(process.env.QRAY), 'older_program'), program);
    const said = () => execFileSync(program, ['one', 'two three'], { encoding: 'utf8' }).trim();
    const older = said();
    assert.match(older, /^\d+\.\d+\.\d+$/);
    writeFileSync(newer, '#!/bin/sh\necho newer "$#" "$2"\n');
    assert.equal(said(), older, 'it may not be run');
    chmodSync(newer, 0o755);
    assert.equal(said(), newer_processor ? 'newer 2 two three' : older);
  } finally {
    rmSync(prefix, { recursive: true });
  }
});
