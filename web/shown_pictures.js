// Which pictures the stage shows of one job or two, where, and of which moment.
import { is_recovered } from './format.js';
import { matching } from './moments.js';

// From the left: the job that does not learn comes first, as in the thesis.
export function in_order(jobs) {
  const [first, second] = jobs;
  const swap = second?.request.method === 'none' && first.request.method !== 'none' &&
    !is_recovered(first);
  return swap ? [second, first] : jobs;
}

// [{job, which}] from the left; a job whose picture was recovered has its samples beside it.
export function pictures_of([first, second]) {
  const best = (job) => ({ job, which: is_recovered(job) ? 'recovered' : 'sampled' });
  const shown = is_recovered(first) ? [{ job: first, which: 'sampled' }] : [];
  shown.push(best(first));
  if (second) shown.push(best(second));
  return shown;
}

// Which of the job's frames; of one without frames the first, which is its picture.
export const frame_of = (job, view) => (job?.request.frames ? view.frame : 0);

// Job id -> the number of its moment; absent: its newest. `hovered`: {job, number}, or null.
export function moments_of([first, second], view, job_moments, hovered) {
  const pinned = new Map();
  if (view.moment !== null) pinned.set(first.id, view.moment);
  if (second && view.equal) {
    const [a, b] = matching(job_moments.of(first.id).moments, job_moments.of(second.id).moments,
      view.equal, view.moment);
    if (a) pinned.set(first.id, a.number);
    if (b) pinned.set(second.id, b.number);
  }
  if (hovered) pinned.set(hovered.job, hovered.number);
  return pinned;
}

export function side_words(shown, job) {
  if (shown.at(-1).job === job) return 'Right';
  return shown.length === 3 ? 'Left and middle' : 'Left';
}
