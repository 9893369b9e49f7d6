// Several jobs of the list at once: which are chosen, and what is done to all of them.
import { ApiError, delete_job, extend_job, post_job } from './api.js';
import { has_ended } from './format.js';

const kMore = 64; // samples
const kMost = 500; // jobs that "All" lists and chooses

export class JobChoice {
  #root;
  #list;
  #store;
  #on_choosing;

  // on_choosing(): whether jobs are chosen is another now.
  constructor(root, list, store, on_choosing) {
    this.#root = root;
    this.#list = list;
    this.#store = store;
    this.#on_choosing = on_choosing;
    this.#part('toggle').addEventListener('click', () =>
      this.#choosing(!list.classList.contains('choosing')));
    this.#part('all').addEventListener('click', () => this.#choose_all());
    list.addEventListener('change', () => this.#show());
    this.#part('delete').addEventListener('click', () => this.#delete());
    this.#part('extend').addEventListener('click', () => this.#extend());
    this.#part('again').addEventListener('click', () => this.#each(
      'rendered again, each as a new job',
      ({ request }) => post_job(request).then((job) => store.put(job)), has_ended, 'not ended'));
  }

  #boxes() {
    return [...this.#list.querySelectorAll('.row-choose')];
  }
  // Jobs that are chosen and listed.
  #chosen() {
    return this.#boxes().filter(({ checked }) => checked)
      .map((box) => this.#store.get(box.closest('li').dataset.job)).filter((job) => job);
  }

  // Of all jobs that the search finds, so many that the list has them all; or none.
  async #choose_all() {
    const none = this.#boxes().length > 0 && this.#chosen().length === this.#boxes().length;
    this.#part('tools').inert = true;
    try {
      await this.#store.answered();
      while (!none && this.#more() && this.#boxes().length < kMost) {
        this.#part('status').textContent = `${this.#boxes().length} are listed …`;
        await this.#store.load_older();
      }
    } catch (error) {
      if (!(error instanceof ApiError)) throw error;
    }
    this.#part('tools').inert = false;
    for (const box of this.#boxes()) box.checked = !none;
    this.#show(!none && this.#more() ? 'The search finds more: older ones are not chosen.' : '');
  }

  // There are jobs that fit and are not listed.
  #more() {
    return !document.getElementById('older').hidden;
  }

  #choosing(on) {
    this.#list.classList.toggle('choosing', on);
    this.#on_choosing();
    this.#part('toggle').setAttribute('aria-pressed', String(on));
    this.#part('tools').hidden = !on;
    for (const box of this.#boxes()) box.checked = false;
    this.#show();
  }

  #show(words = '') {
    const count = this.#chosen().length;
    for (const name of ['delete', 'extend', 'again']) this.#part(name).disabled = count === 0;
    this.#part('status').textContent = [count ? `${count} chosen.` : '', words].join(' ').trim();
  }

  async #delete() {
    const count = this.#chosen().length;
    if (!confirm(`Delete ${count} ${count === 1 ? 'job' : 'jobs'} and their pictures?`)) return;
    await this.#each('deleted', async ({ id }) => {
      await delete_job(id);
      await this.#store.refresh(id); // it is gone
    }, has_ended, 'not ended');
  }

  async #extend() {
    const more = Number(prompt('How many samples a pixel more?', kMore));
    if (!(more > 0)) return;
    await this.#each('extended', async ({ id }) => this.#store.put(await extend_job(id, more)),
      ({ extendable }) => extendable, 'nothing that can be extended');
  }

  // One after the other. Those that are not `fit` are left out, and counted as what `unfit` says.
  async #each(done, act, fit, unfit) {
    const jobs = this.#chosen();
    const good = jobs.filter(fit);
    const problems = new Set();
    let count = 0;
    this.#part('tools').inert = true;
    for (const job of good) {
      this.#part('status').textContent = `${count} of ${good.length} ${done} …`;
      try {
        await act(job);
        ++count;
      } catch (error) {
        if (!(error instanceof ApiError)) throw error;
        problems.add(error.message);
      }
    }
    this.#part('tools').inert = false;
    const left = jobs.length - good.length;
    this.#show([`${count} ${done}.`, left ? `${left} ${left === 1 ? 'has' : 'have'} ${unfit}.` : '',
      ...problems].filter(Boolean).join(' '));
  }

  #part(name) {
    return this.#root.querySelector(`.choice-${name}`);
  }
}
