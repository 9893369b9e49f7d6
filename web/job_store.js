// What the page knows about jobs and tables, as the server last told it. Fires `change` (detail:
// the job, or null when many may have changed). Events from the stream only say what to ask for.
import { ApiError, get_job, kPage, list_jobs, list_tables } from './api.js';
import { has_ended, states_of } from './format.js';

const kKept = 500; // jobs; of more, those that were told of the longest ago are forgotten

export class JobStore extends EventTarget {
  #jobs = new Map();
  #tables = new Map();
  #sorted = null; // them, the newest first
  #missing = new Set();
  #asking = new Map(); // id -> {again: whether to ask once more, answered}
  #search = { find: '', state: '', states: [] };
  #wanted = null; // the last search, and when it has its answer
  #answered = Promise.resolve();
  #next; // where older jobs go on; undefined before the first answer, null after the last
  most = kPage; // that are listed
  pinned = []; // ids of jobs that are not forgotten

  get(id) {
    return this.#jobs.get(id) ?? null;
  }
  // The server said that there is no such job.
  is_missing(id) {
    return this.#missing.has(id);
  }
  table(id) {
    return this.#tables.get(id) ?? null;
  }
  // The newest first.
  tables() {
    return [...this.#tables.values()];
  }
  get has_older() {
    return Boolean(this.#next);
  }
  newest_first() {
    this.#sorted ??= [...this.#jobs.values()].sort(
      (a, b) => b.created.localeCompare(a.created) ||
        b.id.localeCompare(a.id, 'en', { numeric: true }));
    return this.#sorted;
  }

  // Of those that are `fit` the newest, as many as are listed, and those that are shown.
  choices(fit) {
    return this.newest_first().filter(fit)
      .filter(({ id }, at) => at < this.most || this.pinned.includes(id));
  }

  // From now on these are listed: of all jobs those that fit, the newest of them first.
  // Older pages that were asked for before stay as they are.
  // It is asked for after so many ms, unless another search comes before.
  search(wanted, after_ms = 0) {
    this.#wanted = wanted;
    const quiet = new Promise((resolve) => { setTimeout(resolve, after_ms); });
    this.#answered = quiet.then(() =>
      (wanted === this.#wanted ? this.#ask_for(wanted) : undefined));
    return this.#answered;
  }

  // The last search, one that waits included, has its answer; rejects as the search did.
  answered() {
    return this.#answered;
  }

  async #ask_for({ find, state }) {
    const old = this.#search;
    if (find !== old.find || state !== old.state) {
      this.#search = { find, state, states: states_of(state) };
      this.#next = undefined;
      this.most = kPage;
    }
    const asked = this.#search;
    const answer = await list_jobs(null, asked);
    this.#keep(answer.jobs);
    if (asked === this.#search && this.#next === undefined) this.#next = answer.next ?? null;
    this.#changed(null);
  }

  // Before the last search has its answer nobody knows where older ones begin.
  async load_older() {
    await this.answered();
    this.most += kPage;
    if (this.#next) {
      const answer = await list_jobs(this.#next, this.#search);
      this.#keep(answer.jobs);
      this.#next = answer.next ?? null;
    }
    this.#changed(null);
  }

  async load_tables() {
    this.#tables = new Map((await list_tables()).map((table) => [table.id, table]));
    this.#changed(null);
  }

  put(job) {
    this.#keep([job]);
    this.#changed(job);
  }

  // Asks for one job, and again after a hint that came meanwhile. Resolves after the last answer.
  refresh(id) {
    const present = this.#asking.get(id);
    if (present) {
      present.again = true;
      return present.answered;
    }
    const asking = { again: false };
    this.#asking.set(id, asking);
    asking.answered = this.#ask(id, asking);
    return asking.answered;
  }

  async #ask(id, asking) {
    do {
      asking.again = false;
      try {
        this.put(await get_job(id));
      } catch (error) {
        if (error instanceof ApiError && error.status === 404) {
          this.#missing.add(id);
          this.#jobs.delete(id);
          this.#sorted = null;
          this.#changed(null);
        }
        // Else the stream is lost too; all is asked again when it is back.
      }
    } while (asking.again);
    this.#asking.delete(id);
  }

  // How far a scene is loaded is told by events alone.
  apply_loading({ job: id, step, fraction }) {
    const job = this.get(id);
    if (!job) return this.refresh(id);
    job.loading = { step, fraction };
    if (job.state === 'queued') this.refresh(id);
    this.#changed(job);
    return undefined;
  }

  // A `progress` hint is applied as it is: asking would cost two requests a second.
  apply_progress({ job: id, fraction, samples, seconds }) {
    const job = this.get(id);
    if (!job) return this.refresh(id);
    if (has_ended(job) || fraction < job.progress.fraction) return undefined;
    job.progress = { fraction, samples, seconds };
    if (['queued', 'preparing'].includes(job.state)) this.refresh(id);
    this.#changed(job);
    return undefined;
  }

  #keep(jobs) {
    this.#sorted = null;
    for (const job of jobs) {
      this.#jobs.delete(job.id); // so that it comes last
      this.#jobs.set(job.id, job);
      this.#missing.delete(job.id);
    }
    let over = this.#jobs.size - Math.max(kKept, this.most + 2 * kPage);
    for (const id of this.#jobs.keys()) {
      if (over-- <= 0) break;
      if (!this.pinned.includes(id)) this.#jobs.delete(id);
    }
  }

  #changed(job) {
    this.dispatchEvent(new CustomEvent('change', { detail: job }));
  }
}
