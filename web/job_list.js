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

export class JobList {
  #list;
  #template;
  #link_to;
  #rows = new Map();
  #jobs = [];
  #selected = [];
  #thumbnails = new Thumbnails();

  // link_to(id): the address that shows the job
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
    const listed = new Set(jobs.map(({ id }) => id));
    const are_many = this.#rows.size > jobs.length + kMostUnlisted;
    for (const [id, row] of this.#rows) {
      if (listed.has(id)) continue;
      row.remove();
      if (!are_many) continue; // it may come back
      this.#thumbnails.forget(row.querySelector('.row-picture'));
      this.#rows.delete(id);
    }
    jobs.forEach((job, index) => {
      const row = this.#row(job.id);
      this.#fill(row, job);
      const present = this.#list.children[index];
      if (present !== row) this.#list.insertBefore(row, present);
    });
  }

  // One job that changed in place.
  update_one(job) {
    this.#fill(this.#row(job.id), job);
  }

  #row(id) {
    let row = this.#rows.get(id);
    if (!row) {
      row = this.#template.content.firstElementChild.cloneNode(true);
      row.dataset.job = id;
      this.#rows.set(id, row);
    }
    return row;
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
