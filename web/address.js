// What the page shows, as it stands in the address: a reload or a link shows the same. Members that
// are as they begin are left out. Fires `change` when anything is another than before.

const number = (least, most) => ({
  read: (text) => {
    const value = Number(text);
    return text !== '' && value >= least && value <= most ? value : undefined;
  },
  write: (value) => String(Math.round(value * 1000) / 1000),
});
const text = { read: (value) => value || undefined, write: String };
const one_of = (...values) => ({
  read: (value) => (values.includes(value) ? value : undefined), write: String,
});
const pixel = {
  read: (value) => {
    const parts = value.split(',').map(Number);
    return parts.length === 2 && parts.every((v) => Number.isInteger(v) && v >= 0) ? parts
      : undefined;
  },
  write: (value) => value.join(','),
};

// name -> [how it is at first, how it is read and written]
const kMembers = {
  page: ['jobs', one_of('jobs', 'bench', 'tables', 'figures')],
  group: [null, text], // the experiment that is shown
  find: ['', text], // words that listed jobs contain
  state: ['', text], // and their states
  job: [null, text],
  scene: [null, text], // that is looked at live where there is no job
  live: ['', text], // 'on', or where the camera of the live view is (live.js)
  off: ['', text], // what the live view does without
  dark: ['', text], // numbers of its lights that are off
  beside: ['', one_of('learning', 'recovery', 'reprojection', 'all')], // off in a second one
  with: [null, text],
  mode: ['split', one_of('split', 'row', 'flip', 'signed', 'flip-map')],
  side: ['right', one_of('left', 'right')], // which one mode `flip` shows
  split: [50, number(0, 100)], // per cent
  equal: ['', one_of('samples', 'seconds')],
  frame: [0, number(0, 999)], // of a job of frames
  moment: [null, number(1, 1e9)], // of `job`; its newest when null
  ev: [0, number(-16, 16)],
  curve: ['srgb', one_of('srgb', 'gamma', 'filmic', 'false')],
  gamma: [2.2, number(1, 4)],
  offset: [0, number(-2, 2)], // added after the exposure
  channel: ['', one_of('r', 'g', 'b', 'luminance')],
  clipped: ['', one_of('on')], // stripes where it is out of range
  overlay: ['', one_of('state', 'gain', 'beta', 'samples', 'noise')],
  mix: ['', text], // factors of the groups of lights (light_mixer.js)
  zoom: [1, number(1, 1e6)], // times the size that fits
  cx: [null, number(0, 1e4)], // the centre, in ten-thousandths of the picture
  cy: [null, number(0, 1e4)],
  at: [null, pixel], // the inspected one
  axis: ['seconds', one_of('seconds', 'samples')], // of the chart
  ref: [null, text], // the job whose picture errors are against
};
export const kLook = ['find', 'state', 'ev', 'curve', 'gamma', 'offset', 'channel', 'clipped',
  'overlay', 'axis'];

const first_view = () =>
  Object.fromEntries(Object.entries(kMembers).map(([name, [first]]) => [name, first]));

function read_address(hash) {
  const view = first_view();
  for (const [name, value] of new URLSearchParams(hash.slice(1))) {
    if (name in kMembers) view[name] = kMembers[name][1].read(value) ?? view[name];
    // "#tables" is short for "#page=tables"
    else if (value === '') view.page = kMembers.page[1].read(name) ?? view.page;
  }
  if (view.with === view.job) view.with = null;
  if (!view.job) view.with = null;
  if (view.job) view.scene = null;
  else view.live = view.scene ? view.live || 'on' : '';
  return view;
}

function write_address(view) {
  const parts = view.page === 'jobs' ? [] : [view.page];
  for (const [name, [first, kind]] of Object.entries(kMembers)) {
    if (name === 'page' || view[name] === null || view[name] === first) continue;
    const value = kind.write(view[name]);
    if (value !== '' && (first === null || value !== kind.write(first))) {
      parts.push(`${name}=${encodeURIComponent(value).replaceAll('%2C', ',')}`);
    }
  }
  return `#${parts.join('&')}`;
}

// Browsers drop what a page writes into the address more than 200 times in ten seconds, which a
// slider at 60 frames a second does, and each takes milliseconds.
const kWrites = 20; // at once
const kWriteMs = 200; // from one to the next, once they are spent

export class Address extends EventTarget {
  #view = read_address(location.hash);
  #writes = kWrites;
  #written_ms = 0;
  #write_timer = 0; // what is shown waits to be written

  constructor() {
    super();
    addEventListener('hashchange', () => this.#take(read_address(location.hash)));
    addEventListener('popstate', () => this.#take(read_address(location.hash)));
  }

  get view() {
    return this.#view;
  }

  // `step`: the way back leads to what was shown before.
  set(change, { step = false } = {}) {
    const next = { ...this.#view, ...change };
    const hash = write_address(next);
    if (hash === write_address(this.#view)) return;
    if (step) {
      this.write();
      history.pushState(null, '', hash);
    }
    this.#take(next);
    if (!step) this.#write_soon();
  }

  // What is shown stands in the address from now on.
  write() {
    clearTimeout(this.#write_timer);
    this.#write_timer = 0;
    const hash = write_address(this.#view);
    if (hash !== (location.hash || '#')) history.replaceState(null, '', hash);
  }

  #write_soon() {
    if (this.#write_timer) return;
    const now = performance.now();
    this.#writes = Math.min(kWrites, this.#writes + (now - this.#written_ms) / kWriteMs);
    this.#written_ms = now;
    if (this.#writes < 1) {
      this.#write_timer = setTimeout(() => this.write(), kWriteMs);
      return;
    }
    this.#writes -= 1;
    this.write();
  }

  // Where these jobs are shown with the look and the list of now.
  link(job_id, with_id = null, more = {}) {
    const kept = Object.fromEntries(kLook.map((name) => [name, this.#view[name]]));
    return write_address({ ...first_view(), ...kept, job: job_id, with: with_id, ...more });
  }

  // Where an experiment is shown, or a new one is made like a job.
  group_link(group, job = null) {
    return this.link(job, null, { page: 'bench', group });
  }

  // Shows these jobs, as a link of link() does.
  go(job_id, with_id = null) {
    this.write();
    location.hash = this.link(job_id, with_id);
  }

  #take(view) {
    if (write_address(view) === write_address(this.#view)) return;
    const old = this.#view;
    this.#view = view;
    this.dispatchEvent(new CustomEvent('change', { detail: old }));
  }
}
