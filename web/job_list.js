// The list of jobs, of those that fit the filters. Rows are kept and updated in place, so focus and
// scrolling stay where they are.
import { ago, badge_word, has_ended, is_forming, method_words, progress_words,
  state_words } from './format.js';
import { title_of } from './scene_library.js';
import { Thumbnails } from './thumbnails.js';

const kClockMs = 30_000;
const kMostUnlisted = 200; // rows that are kept, with their pictures

// Whether a job is to be listed. `state`: one of the server's, 'running' for all that have not
// ended, '' for any. `find`: words that are all in its id, scene, method or labels.
export function fits(job, { state, find }) {
  if (state === 'running' ? has_ended(job) : state && job.state !== state) return false;
  const { scene, method, labels = {} } = job.request;
  const text = [job.id, scene, title_of(scene), method, method_words(method),
    ...Object.entries(labels).map((label) => label.join(':'))].join(' ').toLowerCase();
  return find.toLowerCase().split(/\s+/).every((word) => text.includes(word));
}

// Jobs that are one entry of the list: {name, words, page}; null for a job of its own.
function group_of({ request: { labels = {} } }) {
  if (labels.experiment) {
    return { name: labels.experiment, words: `Experiment ${labels.experiment}`, page: 'bench',
      jobs: Number(labels.jobs) };
  }
  return labels.page === 'thesis-figures'
    ? { name: 'figures', words: 'Figures of the thesis', page: 'figures' } : null;
}

export class JobList {
  #list;
  #open = new Set(); // groups whose jobs are listed
  #template;
  #link_to;
  #rows = new Map();
  #jobs = [];
  #selected = [];
  #thumbnails = new Thumbnails();

  // link_to(id): the address that shows the job, or with null and {page, group} a group
  constructor(list, template, link_to) {
    this.#list = list;
    this.#template = template;
    this.#link_to = link_to;
    setInterval(() => this.update(this.#jobs, this.#selected), kClockMs);
  }

  // `jobs`: those that are listed.
  update(jobs, selected) {
    this.#jobs = jobs;
    this.#selected = selected;
    const entries = this.#entries(jobs);
    const listed = new Set(entries.map(({ key }) => key));
    const are_many = this.#rows.size > jobs.length + kMostUnlisted;
    for (const [id, row] of this.#rows) {
      if (listed.has(id)) continue;
      row.remove();
      if (!are_many) continue; // it may come back
      this.#thumbnails.forget(row.querySelector('.row-picture'));
      this.#rows.delete(id);
    }
    entries.forEach(({ key, job, group, of }, index) => {
      const row = this.#row(key, group);
      if (group) this.#fill_group(row, group, of);
      else this.#fill(row, job);
      const present = this.#list.children[index];
      if (present !== row) this.#list.insertBefore(row, present);
    });
  }

  // Jobs, and groups of them where the newest of each would stand, with their jobs if it is open.
  // While jobs are chosen, each stands by itself.
  #entries(jobs) {
    const entries = [];
    const is_choosing = this.#list.classList.contains('choosing');
    const groups = new Map();
    for (const job of jobs) {
      const group = is_choosing ? null : group_of(job);
      const key = group && `${group.page} ${group.name}`;
      if (group && !groups.has(key)) {
        groups.set(key, { key, group, of: [] });
        entries.push(groups.get(key));
      }
      if (group) groups.get(key).of.push(job);
      else entries.push({ key: job.id, job });
    }
    return entries.flatMap((entry) => (entry.group && this.#open.has(entry.key)
      ? [entry, ...entry.of.map((job) => ({ key: job.id, job }))] : [entry]));
  }

  // One job that changed in place.
  update_one(job) {
    this.#fill(this.#row(job.id), job);
  }

  #row(key, group = null) {
    let row = this.#rows.get(key);
    if (!row) {
      row = this.#template.content.firstElementChild.cloneNode(true);
      this.#rows.set(key, row);
      if (!group) row.dataset.job = key;
      else this.#make_group(row, key);
    }
    return row;
  }

  #make_group(row, key) {
    row.dataset.group = key;
    row.querySelector('.row-choose').remove(); // its jobs are chosen one by one
    const button = Object.assign(document.createElement('button'),
      { type: 'button', className: 'row-open quiet' });
    button.addEventListener('click', () => {
      if (!this.#open.delete(key)) this.#open.add(key);
      this.update(this.#jobs, this.#selected);
    });
    row.append(button);
  }

  // `jobs`: those that are known, the newest first.
  #fill_group(row, { name, words, page, jobs: asked }, jobs) {
    const all = Math.max(asked || 0, jobs.length);
    const ended = jobs.filter(has_ended).length;
    const running = jobs.find((job) => is_forming(job));
    const failed = jobs.some(({ state }) => state === 'failed');
    row.dataset.state = running ? 'rendering' : failed ? 'failed'
      : ended === jobs.length ? 'succeeded' : 'queued';
    const set = (part, text) => {
      const place = row.querySelector(`.row-${part}`);
      if (place.textContent !== text) place.textContent = text;
    };
    set('scene', words);
    set('method', `${all} jobs`);
    set('state', all > jobs.length ? `${jobs.length} of them listed here`
      : ended === all ? 'All have ended' : `${ended} have ended`);
    set('time', ago(jobs[0].created));
    row.querySelector('.row-time').dateTime = jobs[0].created;
    const bar = row.querySelector('.row-progress');
    bar.hidden = ended === all;
    bar.value = ended / all;
    const pictured = jobs.find(({ progress }) => progress.samples > 0) ?? jobs[0];
    this.#thumbnails.show(row.querySelector('.row-picture'), pictured);
    const link = row.querySelector('a');
    const href = this.#link_to(null, { page, group: page === 'bench' ? name : null });
    if (link.getAttribute('href') !== href) link.href = href;
    const is_open = this.#open.has(row.dataset.group);
    const button = row.querySelector('.row-open');
    button.textContent = is_open ? 'Hide its jobs' : `List its jobs`;
    button.setAttribute('aria-expanded', String(is_open));
    button.setAttribute('aria-label', `${button.textContent}: ${words}`);
  }

  #fill(row, job) {
    const part = (name) => row.querySelector(`.${name}`);
    const set = (name, text) => {
      if (part(name).textContent !== text) part(name).textContent = text;
    };
    row.dataset.state = job.state;
    set('row-scene', title_of(job.request.scene));
    set('row-method', method_words(job.request.method));
    part('badge').hidden = !badge_word(job);
    set('badge', badge_word(job));
    set('row-state', state_words(job.state));
    set('row-numbers', progress_words(job));
    set('row-time', ago(job.created));
    part('row-time').dateTime = job.created;
    const bar = part('row-progress');
    bar.hidden = has_ended(job) || !is_forming(job);
    bar.value = job.progress.fraction;
    this.#thumbnails.show(part('row-picture'), job);
    part('row-choose').setAttribute('aria-label', `Choose ${job.id}`);
    const link = row.querySelector('a');
    const href = this.#link_to(job.id);
    if (link.getAttribute('href') !== href) link.href = href;
    if (this.#selected.includes(job.id)) link.setAttribute('aria-current', 'true');
    else link.removeAttribute('aria-current');
  }
}
