// The farm's page: the processes that share the jobs, what each does, and draining one.
import { check_access, drain_worker, list_workers, on_unauthorized } from './api.js';
import { SignIn } from './sign_in.js';

const by_id = (id) => document.getElementById(id);
const kBetweenLooksMs = 2000;
const kSilentSeconds = 15; // longer, and its jobs are given to others

const sign_in = new SignIn();
on_unauthorized(() => sign_in.ask());
const rows = new Map(); // id -> row

const is_silent = (worker) => worker.silent_seconds > kSilentSeconds;

function what_it_does(worker) {
  if (is_silent(worker)) return 'silent: its jobs go to others';
  if (worker.aside) return `put aside: ${worker.aside}`;
  if (worker.draining) return worker.jobs.length ? 'draining: finishes its jobs' : 'drained';
  if (worker.threads === 0) return 'answers requests';
  const renders = worker.jobs.length ? 'renders' : worker.helps ? 'samples for another worker'
    : 'waits for jobs';
  return worker.kind === 'front' ? `answers requests, ${renders}` : renders;
}

function duration(seconds) {
  if (seconds < 90) return `${Math.round(seconds)} s`;
  if (seconds < 5400) return `${Math.round(seconds / 60)} min`;
  return seconds < 172800 ? `${Math.round(seconds / 3600)} h` : `${Math.round(seconds / 86400)} d`;
}

function speed(samples_per_second) {
  if (samples_per_second < 1000) return samples_per_second > 0 ? 'under 1 k samples/s' : '–';
  const [unit, word] = samples_per_second < 1e6 ? [1e3, 'k'] : [1e6, 'M'];
  return `${(samples_per_second / unit).toPrecision(3)} ${word} samples/s`;
}

function make_row(worker) {
  const row = by_id('worker').content.firstElementChild.cloneNode(true);
  const button = row.querySelector('.worker-drain');
  button.setAttribute('aria-label', `Drain ${worker.id}`);
  button.addEventListener('click', async () => {
    button.disabled = true;
    try {
      show(await drain_worker(worker.id));
    } catch (error) {
      say(error.message);
      button.disabled = false;
    }
  });
  return row;
}

function fill(row, worker) {
  const part = (name) => row.querySelector(`.worker-${name}`);
  part('host').textContent = worker.host;
  part('host').title = worker.id;
  part('state').textContent = what_it_does(worker);
  const jobs = worker.helps ? [...worker.jobs, worker.helps] : worker.jobs;
  part('jobs').replaceChildren(...jobs.flatMap((id) => {
    const link = document.createElement('a');
    link.href = `/#job=${encodeURIComponent(id)}`;
    link.textContent = id;
    return [link, ' '];
  }));
  part('speed').textContent = worker.threads ? speed(worker.samples_per_second) : '';
  part('age').textContent = duration(worker.age_seconds);
  part('silent').textContent = `${duration(worker.silent_seconds)} ago`;
  part('build').textContent = worker.build;
  part('build').title = worker.bits;
  part('drain').hidden = worker.draining || worker.threads === 0 || is_silent(worker);
}

function show({ workers }) {
  by_id('none').hidden = workers.length > 0;
  by_id('workers').hidden = workers.length === 0;
  for (const [id, row] of rows) {
    if (workers.some((worker) => worker.id === id)) continue;
    row.remove();
    rows.delete(id);
  }
  const body = by_id('workers').querySelector('tbody');
  workers.forEach((worker, index) => {
    if (!rows.has(worker.id)) rows.set(worker.id, make_row(worker));
    const row = rows.get(worker.id);
    fill(row, worker);
    if (body.children[index] !== row) body.insertBefore(row, body.children[index] ?? null);
  });
  const render = workers.filter((worker) => worker.threads > 0 && !is_silent(worker));
  const all = render.reduce((sum, worker) => sum + worker.samples_per_second, 0);
  const bits = new Set(render.map((worker) => worker.bits));
  by_id('summary').textContent = `${render.length} render` + (all ? `, ${speed(all)}` : '');
  say(bits.size > 1 ? 'Workers of several builds of qray, or on several kinds of processors: the '
    + 'bits of their pictures may differ, so they do not sample one picture together.' : '');
}

function say(text) {
  by_id('notice').textContent = text;
  by_id('notice').hidden = !text;
}

async function look() {
  try {
    show(await list_workers());
  } catch (error) {
    by_id('summary').textContent = 'Not connected';
    say(error.message);
  }
  setTimeout(look, kBetweenLooksMs);
}

check_access().catch(() => {}).then(look);
