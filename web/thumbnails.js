// Small pictures of jobs for the list: fetched one at a time, only for rows that are seen, and
// drawn into a canvas of their size, so that no full picture stays in memory.
import { ApiError, get_png } from './api.js';
import { has_ended } from './format.js';

// Another text when another picture is worth fetching: with every doubling of the samples.
const version = (job) => {
  if (!job.progress.samples) return '';
  return has_ended(job) ? job.state : String(Math.floor(Math.log2(job.progress.samples)));
};

// A picture over the whole canvas, cut where their shapes differ.
export async function draw_over(canvas, blob) {
  const { width, height } = canvas;
  const bitmap = await createImageBitmap(blob);
  const scale = Math.max(width / bitmap.width, height / bitmap.height);
  const [w, h] = [bitmap.width * scale, bitmap.height * scale];
  const context = canvas.getContext('2d');
  context.imageSmoothingQuality = 'high';
  context.drawImage(bitmap, (width - w) / 2, (height - h) / 2, w, h);
  bitmap.close();
  canvas.classList.add('drawn');
}

export class Thumbnails {
  #jobs = new Map(); // canvas -> job
  #seen = new Set();
  #busy = false;
  #observer = new IntersectionObserver((entries) => {
    for (const { target, isIntersecting } of entries) {
      if (isIntersecting) this.#seen.add(target);
      else this.#seen.delete(target);
    }
    this.#go_on();
  });

  show(canvas, job) {
    if (!this.#jobs.has(canvas)) this.#observer.observe(canvas);
    this.#jobs.set(canvas, job);
    if (this.#seen.has(canvas)) this.#go_on();
  }

  forget(canvas) {
    this.#observer.unobserve(canvas);
    this.#jobs.delete(canvas);
    this.#seen.delete(canvas);
  }

  async #go_on() {
    if (this.#busy) return;
    this.#busy = true;
    for (;;) {
      const canvas = [...this.#seen].find((one) => this.#is_old(one));
      if (!canvas) break;
      const job = this.#jobs.get(canvas);
      canvas.dataset.version = version(job); // also when it fails: it is not asked for again
      try {
        await draw_over(canvas, await get_png(job.id));
      } catch (error) {
        if (!(error instanceof ApiError)) throw error;
      }
    }
    this.#busy = false;
  }

  #is_old(canvas) {
    const job = this.#jobs.get(canvas);
    return Boolean(version(job)) && canvas.dataset.version !== version(job);
  }
}
