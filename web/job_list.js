// The list of jobs. Rows are kept and updated in place, so focus and scrolling stay where they are.
import { ago, badge_word, has_ended, is_forming, method_words, progress_words,
  state_words } from './format.js';

const kClockMs = 30_000;

export class JobList {
  #list;
  #template;
  #link_to;
  #rows = new Map();
  #jobs = [];
  #selected = [];

  // link_to(id): the address that shows the job
  constructor(list, template, link_to) {
    this.#list = list;
    this.#template = template;
    this.#link_to = link_to;
    setInterval(() => this.update(this.#jobs, this.#selected), kClockMs);
  }

  update(jobs, selected) {
    this.#jobs = jobs;
    this.#selected = selected;
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
      row.querySelector('a').href = this.#link_to(id);
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
    set('row-scene', job.request.scene);
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
    const link = row.querySelector('a');
    if (this.#selected.includes(job.id)) link.setAttribute('aria-current', 'true');
    else link.removeAttribute('aria-current');
  }
}
