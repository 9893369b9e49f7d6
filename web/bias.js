// How much brighter a biased method's picture is than that of the unbiased job beside it: asked of
// the server when their pictures change much.
import { get_compare } from './api.js';
import { brightness_words, has_ended, is_biased } from './format.js';
import { Latest } from './latest.js';

// Another value as a running job's picture changes much: with every half as many samples more.
// `moment`: the number of its past that is shown, or null.
export function picture_age(job, moment) {
  if (moment !== null) return moment;
  return has_ended(job) ? job.state : `${Math.floor(2 * Math.log2(1 + job.progress.samples))} live`;
}

export class Bias {
  #on_change;
  #key = '';
  #jobs = ''; // whose ratio it is
  #ratio = null;
  #ask = new Latest();

  constructor(on_change) {
    this.#on_change = on_change;
  }

  // `jobs`: the one or two that are shown; `moments`: job -> number, absent for the newest.
  follow(jobs, moments) {
    const biased = jobs.find(is_biased);
    const other = jobs.find((job) => !is_biased(job));
    const fit = biased && other && jobs.every((job) => job.progress.samples > 0);
    const [a_moment, b_moment] = [biased, other].map((job) => moments.get(job?.id) ?? null);
    const key = fit ? JSON.stringify([biased.id, other.id, picture_age(biased, a_moment),
      picture_age(other, b_moment)]) : '';
    if (key === this.#key) return;
    this.#key = key;
    const pair = fit ? `${biased.id} ${other.id}` : '';
    if (pair !== this.#jobs) {
      this.#jobs = pair;
      this.#ratio = null;
      this.#ask.stop();
    }
    if (!fit) return;
    // What is refused has no ratio: pictures of other sizes.
    this.#ask.run(() => get_compare({ a: biased.id, b: other.id, a_moment, b_moment }),
      ({ difference }) => {
        this.#ratio = difference.mean_ratio;
        this.#on_change();
      });
  }

  // "2.2 times as bright as j000001"; '' where it is not known. Without `named` the other is not.
  words(job, jobs, named = false) {
    const other = jobs.find((one) => !is_biased(one));
    if (!is_biased(job) || !other || this.#ratio === null) return '';
    return brightness_words(this.#ratio, named ? other.id : '');
  }
}
