// Wires the store, the event stream, the form, the list and the views.
import {
  ApiError, check_access, list_fields, list_scenes, list_weights, list_workers, on_unauthorized,
  post_job,
} from './api.js';
import { Address, kLook } from './address.js';
import { ErrorPanel } from './error_panel.js';
import { EventStream } from './event_stream.js';
import { FrameStrip } from './frame_strip.js';
import { FiguresPage } from './figures_page.js';
import { has_ended, state_words } from './format.js';
import { Histogram } from './histogram.js';
import { Hover } from './hover.js';
import { Inspector } from './inspector.js';
import { JobChoice } from './job_choice.js';
import { JobForm } from './job_form.js';
import { JobMoments } from './job_moments.js';
import { fits, JobList } from './job_list.js';
import { JobStore } from './job_store.js';
import { Keys } from './keys.js';
import { LightMixer } from './light_mixer.js';
import { LiveGate } from './live_gate.js';
import { kChannels } from './look.js';
import { Panes } from './panes.js';
import { SceneDrop } from './scene_drop.js';
import { SceneLibrary } from './scene_library.js';
import { share_link } from './share_link.js';
import { SignIn } from './sign_in.js';
import { Snapshot } from './snapshot.js';
import { TablesPage } from './tables_page.js';
import { ViewControls } from './view_controls.js';
import { Viewer } from './viewer.js';

const kSearchMs = 200; // after the last letter
// Members that the list or the page's parts show.
const kListed = ['page', 'group', 'job', 'with', ...kLook];
const by_id = (id) => document.getElementById(id);

const sign_in = new SignIn();
on_unauthorized(() => sign_in.ask());
export const address = new Address();
export const store = new JobStore();
const job_moments = new JobMoments(() => viewer.update());
let announced = '';
const panes = new Panes(by_id('panes'));

const list = new JobList(by_id('jobs'), by_id('row-template'),
  (id, more) => address.link(id, null, more));
new JobChoice(by_id('choice'), by_id('jobs'), store, () => show_all());
export const viewer = new Viewer(by_id('viewer'),
  { pane: by_id('pane-template'), panel: by_id('panel-template') }, store, job_moments, address,
  (job) => {
    by_id('new-job').open = true;
    form.fill(job.request);
  });
const errors = new ErrorPanel(by_id('errors'), viewer, store, job_moments, address);
const frames = new FrameStrip(by_id('frames'), by_id('frames-player'), store, address);
viewer.addEventListener('update', () => frames.update());
async function post(request) {
  const job = await post_job(request);
  store.put(job);
  address.go(job.id);
}
const part_first = by_id('part-first');
part_first.addEventListener('click', async () => {
  const { request } = store.get(address.view.job);
  try {
    await post({ ...request, region: viewer.seen_part });
  } catch (error) {
    if (!(error instanceof ApiError)) throw error;
    by_id('share-status').textContent = error.message;
  }
});
viewer.addEventListener('update', () => {
  const job = store.get(address.view.job);
  part_first.disabled = !job || job.request.pixels === 'by-noise' || !viewer.seen_part;
});
const mixer = new LightMixer(by_id('mixer'), store, viewer, address, post);
export const live_gate = new LiveGate(by_id('viewer'), viewer, store, address, post);
viewer.addEventListener('update', () => live_gate.update());
viewer.addEventListener('update', () => mixer.update());
new Inspector(by_id('pixel'), viewer, address, announce);
new Hover(by_id('readout'), viewer, address);
new Histogram(by_id('histogram'), viewer, address);
new Snapshot(by_id('snapshot'), by_id('copy-picture'), by_id('share-status'), viewer);
const filters = new ViewControls(document.querySelector('.filters'), address);
const tables = new TablesPage(by_id('tables-page'), store, (id) => address.link(id));
const figures = new FiguresPage(by_id('figures-page'), store,
  (id, with_id) => address.link(id, with_id));

const library = new SceneLibrary(by_id('library'), (name) => {
  form.choose(name);
  // Where no job is looked at, one looks around in the scene at once.
  const { job, scene } = address.view;
  if (job || scene === name || !live_gate.can_show(name)) return;
  address.set({ scene: name, live: 'on', off: '', dark: '', beside: '' }, { step: true });
}, show_scenes,
  (scene) => address.link(null, null, { scene, live: 'on' }));
const form = new JobForm(by_id('job-form'), (jobs) => {
  jobs.forEach((job) => store.put(job));
  if (matchMedia('(max-width: 800px)').matches) by_id('new-job').open = false;
  address.go(jobs[0].id, jobs[1]?.id);
}, (scene) => library.choose(scene));

async function show_scenes() {
  const scenes = await list_scenes();
  library.show(scenes);
  form.show_scenes(scenes);
  live_gate.scenes = scenes;
  show_all(); // their titles
}

new SceneDrop([by_id('upload')], by_id('upload-status'), by_id('drop-here'), async ({ name }) => {
  await show_scenes();
  await form.render(name);
});

function move_pixel(dx, dy) {
  const { at } = address.view;
  const [{ width, height }] = viewer.pictures;
  viewer.inspect(at ? [at[0] + dx, at[1] + dy] : [width >> 1, height >> 1]);
}

// The next (1) or previous (-1) job of the list.
function step_job(by) {
  const jobs = listed_jobs();
  const at = jobs.findIndex(({ id }) => id === address.view.job);
  const next = jobs[at < 0 ? 0 : at + by];
  if (next) address.go(next.id);
}

function cycle(name, values) {
  const at = values.indexOf(address.view[name]);
  address.set({ [name]: values[(at + 1) % values.length] });
}

function share() {
  address.write();
  share_link(by_id('share-status'));
}

const expose = (by) => address.set(
  { ev: Math.min(8, Math.max(-8, Math.round(10 * (address.view.ev + by)) / 10)) });
const offset = (by) => address.set(
  { offset: Math.min(2, Math.max(-2, Math.round(100 * (address.view.offset + by)) / 100)) });
new Keys(by_id('keys'), by_id('show-keys'), [
  ['f', 'Flip between the two pictures', () => viewer.flip()],
  ['d', 'Split, signed difference, visible difference', () => address.view.with &&
    cycle('mode', ['split', 'signed', 'flip-map'])],
  ['q', 'Now, at equal samples, at equal time', () => address.view.with &&
    cycle('equal', ['', 'samples', 'seconds'])],
  ['e', 'Brighter by half a stop', () => expose(0.5)],
  ['E', 'Darker by half a stop', () => expose(-0.5)],
  ['o', 'Lighter by an offset of .05', () => offset(0.05)],
  ['O', 'Darker by an offset of .05', () => offset(-0.05)],
  ['r', 'Next channel: red, green, blue, luminance, colour', () => cycle('channel', kChannels)],
  ['x', 'Stripes where clipped, or not', () => cycle('clipped', ['', 'on'])],
  ['c', 'Next curve', () => cycle('curve', ['srgb', 'gamma', 'filmic', 'false'])],
  ['s', 'Learned places over the picture, or not', () => cycle('overlay', ['', 'state'])],
  ['+', 'Zoom in', () => viewer.zoom_by(2)],
  ['-', 'Zoom out', () => viewer.zoom_by(0.5)],
  ['0', 'Fit', () => viewer.fit()],
  ['1', 'A pixel of the picture is one of the screen', () => viewer.one_to_one()],
  ['[', 'The moment before', () => errors.step(-1)],
  [']', 'The moment after', () => errors.step(1)],
  ['j', 'Next job of the list', () => step_job(1)],
  ['k', 'Previous job of the list', () => step_job(-1)],
  ['l', 'Copy a link to this view', share],
]);
by_id('share').addEventListener('click', share);
const kArrows = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
document.querySelector('.view-stage').addEventListener('keydown', (event) => {
  const arrow = kArrows[event.key];
  if (event.target.matches('.divider') || !arrow || event.ctrlKey || event.altKey) return;
  event.preventDefault();
  move_pixel(...arrow.map((v) => v * (event.shiftKey ? 10 : 1)));
});

function ask_for_selected() {
  store.pinned = [address.view.job, address.view.with, address.view.ref];
  for (const id of [address.view.job, address.view.with, address.view.ref]) {
    const job = id && store.get(id);
    if (id && !(job && has_ended(job))) store.refresh(id);
  }
}

const fitting_jobs = () => store.newest_first().filter((job) => fits(job, address.view));
const listed_jobs = () => fitting_jobs().slice(0, store.most);

function show_all() {
  const fitting = fitting_jobs();
  const jobs = fitting.slice(0, store.most);
  const has_older = store.has_older || fitting.length > jobs.length;
  const { job, with: other, page } = address.view;
  list.update(jobs, [job, other]);
  by_id('no-jobs').hidden = store.newest_first().length > 0;
  const filtered = address.view.find || address.view.state;
  by_id('filtered').textContent = filtered
    ? `${jobs.length}${has_older ? ' or more' : ''} of all jobs` : '';
  by_id('older').hidden = !has_older;
  form.show_tables(store.tables());
  for (const name of ['jobs', 'bench', 'tables', 'figures']) {
    by_id(`${name}-page`).hidden = page !== name;
  }
  by_id('panes').hidden = page !== 'jobs';
  for (const link of document.querySelectorAll('nav a')) {
    if (link.dataset.page === page) link.setAttribute('aria-current', 'page');
    else link.removeAttribute('aria-current');
  }
  if (page === 'tables') tables.update();
  if (page === 'figures') figures.open();
  if (page === 'bench') open_bench();
  viewer.update();
}

let bench = null; // a promise
async function open_bench() {
  bench ??= import('./bench_page.js').then(async ({ BenchPage }) => {
    const opened = new BenchPage(by_id('bench-page'), store, address);
    await opened.load();
    return opened;
  });
  (await bench).open();
}

function announce(text) {
  if (text === announced) return;
  announced = text;
  by_id('announcer').textContent = text;
}

address.addEventListener('change', ({ detail: old }) => {
  const { view } = address;
  filters.update();
  if (old.find !== view.find || old.state !== view.state) {
    store.search(view, kSearchMs).catch(() => {});
  }
  if (old.job !== view.job || old.with !== view.with || old.ref !== view.ref) ask_for_selected();
  viewer.follow(old);
  const shown = view.job ?? view.scene;
  if (shown && shown !== (old.job ?? old.scene)) panes.show('picture-pane');
  // The list's links keep the look. What moves with a slider or the picture is the viewer's alone.
  if (kListed.some((name) => old[name] !== view[name])) show_all();
  else viewer.update();
});

store.addEventListener('change', ({ detail: job }) => {
  const { view } = address;
  if (job && by_id('jobs').querySelector(`[data-job="${CSS.escape(job.id)}"]`) &&
    fits(job, view)) {
    list.update_one(job);
    if ([view.job, view.with].includes(job.id)) viewer.update();
  } else {
    show_all();
  }
  const shown = view.job && store.get(view.job);
  if (shown) announce(`Job ${shown.id}: ${state_words(shown.state)}`);
});

// Whatever fails here is asked again when the stream comes back.
async function sync() {
  try {
    ask_for_selected();
    viewer.restart();
    frames.refresh(address.view.job);
    for (const id of viewer.shown_jobs) job_moments.refresh(id);
    form.show_fields(await list_fields());
    await Promise.all([store.search(address.view), store.load_tables(), show_scenes(),
      list_weights().then((weights) => form.show_weights(weights))]);
  } catch (error) {
    if (!(error instanceof ApiError)) throw error;
    by_id('connection').textContent = error.message;
  }
}

const stream = new EventStream({
  on_sync: sync,
  on_connection(live) {
    by_id('connection').textContent = live ? 'Live' : 'Reconnecting …';
    by_id('connection').dataset.live = live;
    by_id('notice').hidden = live;
  },
  on_event(name, data) {
    if (name === 'loading') {
      store.apply_loading(data);
      return;
    }
    if (name === 'progress') {
      store.apply_progress(data);
      viewer.pull(data.job, data.cursor, data.frame);
      job_moments.refresh(data.job);
      return;
    }
    if (name !== 'frame') store.refresh(data.job);
    frames.refresh(data.job);
    if (name === 'table') store.load_tables().catch(() => {});
    viewer.pull(data.job);
    job_moments.refresh(data.job);
  },
});

by_id('older').addEventListener('click', () => store.load_older().catch(() => {}));
if (address.view.job ?? address.view.scene) panes.show('picture-pane');
if (address.view.job && matchMedia('(max-width: 800px)').matches) by_id('new-job').open = false;
ask_for_selected();
show_all();
check_access().catch(() => {}).then(() => {
  stream.open();
  return list_workers();
}).then(({ workers }) => document.body.classList.toggle('farm', workers.length > 0))
  .catch(() => {});
