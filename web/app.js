// The page: wires the store, the event stream, the form, the list and the viewer. Which jobs are
// shown stands in the address (#job=j000001&with=j000002), so a reload or a link shows the same.
import {
  ApiError, check_access, list_scenes, list_weights, on_unauthorized,
} from './api.js';
import { EventStream } from './event_stream.js';
import { has_ended, state_words } from './format.js';
import { JobForm } from './job_form.js';
import { JobList } from './job_list.js';
import { JobStore } from './job_store.js';
import { SceneDrop } from './scene_drop.js';
import { SignIn } from './sign_in.js';
import { Viewer } from './viewer.js';

const by_id = (id) => document.getElementById(id);
const address = (job_id, with_id = null) =>
  `#job=${encodeURIComponent(job_id)}` + (with_id ? `&with=${encodeURIComponent(with_id)}` : '');

function from_address() {
  const parts = new URLSearchParams(location.hash.slice(1));
  const job = parts.get('job') || null;
  const other = parts.get('with') || null;
  return { job, with: job && other !== job ? other : null };
}

const sign_in = new SignIn(by_id('sign-in'));
on_unauthorized(() => sign_in.ask());
const store = new JobStore();
let selected = from_address();
let announced = '';

const list = new JobList(by_id('jobs'), by_id('row-template'), (id) => address(id));
export const viewer = new Viewer(by_id('viewer'), by_id('panel-template'), store,
  (id) => address(id), (with_id) => {
    location.hash = address(selected.job, with_id);
  });

const form = new JobForm(by_id('job-form'), (jobs) => {
  jobs.forEach((job) => store.put(job));
  location.hash = address(jobs[0].id, jobs[1]?.id);
  if (matchMedia('(max-width: 800px)').matches) by_id('new-job').open = false;
  by_id('viewer').scrollIntoView({ block: 'nearest' });
});

new SceneDrop(by_id('upload'), by_id('upload-status'), async ({ name }) => {
  form.show_scenes(await list_scenes());
  await form.render(name);
});

function ask_for_selected() {
  for (const id of [selected.job, selected.with]) {
    const job = id && store.get(id);
    if (id && !(job && has_ended(job))) store.refresh(id);
  }
}

function show_all() {
  const jobs = store.newest_first();
  list.update(jobs, [selected.job, selected.with]);
  by_id('no-jobs').hidden = jobs.length > 0;
  by_id('older').hidden = !store.has_older;
  viewer.update();
}

function announce(text) {
  if (text === announced) return;
  announced = text;
  by_id('announcer').textContent = text;
}

function select_from_address() {
  selected = from_address();
  ask_for_selected();
  viewer.select(selected.job, selected.with);
  show_all();
}

store.addEventListener('change', ({ detail: job }) => {
  if (job && by_id('jobs').querySelector(`[data-job="${CSS.escape(job.id)}"]`)) {
    list.update_one(job);
    if ([selected.job, selected.with].includes(job.id)) viewer.update();
  } else {
    show_all();
  }
  const shown = selected.job && store.get(selected.job);
  if (shown) announce(`Job ${shown.id}: ${state_words(shown.state)}`);
});

// Whatever fails here is asked again when the stream comes back.
async function sync() {
  try {
    ask_for_selected();
    viewer.restart();
    await Promise.all([store.load(), list_scenes().then((scenes) => form.show_scenes(scenes)),
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
      viewer.pull(data.job, data.cursor);
      return;
    }
    store.refresh(data.job);
    if (name === 'table') store.load_tables().catch(() => {});
    viewer.pull(data.job);
  },
});

by_id('older').addEventListener('click', () => store.load_older().catch(() => {}));
addEventListener('hashchange', select_from_address);
if (selected.job && matchMedia('(max-width: 800px)').matches) by_id('new-job').open = false;
select_from_address();
check_access().catch(() => {}).then(() => stream.open());
