// How much the service bears: `node tests/soak/soak.mjs PART... [options]`, README.md beside this.
// Prints a table of bars and what was measured; exits 1 when a bar was missed.
import { existsSync } from 'node:fs';
import { dirname, join, resolve } from 'node:path';
import { fileURLToPath } from 'node:url';
import { parseArgs } from 'node:util';

const kParts = ['streams', 'burst', 'kill', 'old-jobs', 'filters', 'attacks', 'disk-full', 'clock',
  'slow-reader', 'two-servers', 'memory'];
const here = dirname(fileURLToPath(import.meta.url));
const { values, positionals } = parseArgs({ allowPositionals: true, options: {
  build: { type: 'string', default: join(here, '../../build/release') },
  minutes: { type: 'string' }, // of memory
  kills: { type: 'string' }, // of kill
  turns: { type: 'string' }, // of slow-reader
  clients: { type: 'string' }, // of burst
  short: { type: 'boolean', default: false }, // smaller counts; times are shown, not judged
} });
const parts = positionals.includes('all') ? kParts : positionals;
const unknown = parts.filter((part) => !kParts.includes(part));
if (parts.length === 0 || unknown.length > 0) {
  console.error(`soak.mjs: expected all or parts of ${kParts.join(', ')}, got '${unknown}'`);
  process.exit(2);
}
process.env.QRAYD ??= resolve(values.build, 'bin/qrayd');
process.env.QRAY ??= resolve(values.build, 'bin/qray');
if (!existsSync(process.env.QRAYD)) {
  console.error(`soak.mjs: no ${process.env.QRAYD}: build it, or name a build with --build`);
  process.exit(2);
}

const rows = [];
const report = {
  // What must hold. A time says nothing about the server when the machine is anybody's: in the
  // short form it is only shown.
  bar(what, bar, measured, ok) { rows.push([what, bar, String(measured), ok ? 'yes' : 'NO']); },
  time(what, unit, limit, measured) {
    const shown = `${measured.toFixed(measured < 10 ? 2 : 1)} ${unit}`;
    const ok = values.short ? '-' : measured <= limit ? 'yes' : 'NO';
    rows.push([what, `<= ${limit} ${unit}`, shown, ok]);
  },
  show(what, measured) { rows.push([what, '', String(measured), '-']); },
  skip(what, why) { rows.push([what, '', `skipped: ${why}`, '-']); },
};

function print_table() {
  const all = [['what', 'bar', 'measured', 'ok'], ['---', '---', '---', '---'], ...rows];
  const widths = [0, 1, 2].map((i) => Math.max(...all.map((row) => row[i].length)));
  for (const row of all) {
    console.log(`| ${row.map((cell, i) => cell.padEnd(widths[i] ?? 0)).join(' | ')} |`);
  }
}

const number = (text, otherwise) => (text === undefined ? otherwise : Number(text));
const options = { short: values.short, minutes: number(values.minutes, 10),
  kills: number(values.kills, 100), turns: number(values.turns, 7),
  clients: number(values.clients, 16) };
for (const part of parts) {
  const begin = performance.now();
  try {
    const { run } = await import(`./part_${part.replace('-', '_')}.mjs`);
    await run(options, report);
  } catch (error) {
    report.bar(`${part}: runs to its end`, '', error.message.slice(0, 300), false);
    console.error(error.stack);
  }
  console.error(`${part}: ${((performance.now() - begin) / 1000).toFixed(0)} s`);
}
print_table();
process.exit(rows.some((row) => row[3] === 'NO') ? 1 : 0);
