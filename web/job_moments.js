// What the server keeps of the shown jobs' passes: one request at a time for each, asked again
// after a hint that came meanwhile. Calls on_change() with news.
import { ApiError, get_metrics } from './api.js';

const kNone = { moments: [], gate: null, problem: '' };

export class JobMoments {
  #on_change;
  #known = new Map(); // job -> {ref, moments, gate, problem, busy, again}

  constructor(on_change) {
    this.#on_change = on_change;
  }

  // {moments, gate, problem}
  of(job_id) {
    return this.#known.get(job_id) ?? kNone;
  }

  // Keeps up with these jobs and forgets all others.
  follow(job_ids, ref) {
    for (const id of this.#known.keys()) if (!job_ids.includes(id)) this.#known.delete(id);
    for (const id of job_ids) {
      const known = this.#known.get(id);
      if (known && known.ref === ref) continue;
      this.#known.set(id, { ...kNone, ...known, ref, busy: false });
      this.refresh(id);
    }
  }

  async refresh(job_id) {
    const entry = this.#known.get(job_id);
    if (!entry) return;
    entry.again = true;
    if (entry.busy) return;
    entry.busy = true;
    while (entry.again && this.#known.get(job_id) === entry) {
      entry.again = false;
      try {
        const { moments, gate } = await get_metrics(job_id, entry.ref);
        Object.assign(entry, { moments, gate, problem: '' });
      } catch (error) {
        if (!(error instanceof ApiError)) throw error;
        entry.problem = error.message;
      }
      if (this.#known.get(job_id) === entry) this.#on_change();
    }
    entry.busy = false;
  }
}
