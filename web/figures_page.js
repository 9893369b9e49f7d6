// The page of the thesis' figures: each is made of jobs of this server, which carry labels, so that
// a reload finds them again, and posts what still waited when the page was closed.
import { ApiError, get_compare, get_lobe, get_png, get_view, jobs_labelled,
  post_job } from './api.js';
import { brightness_words, has_ended, method_words, progress_words,
  state_words } from './format.js';
import { kFigures, kPageLabel, lesson_of, part_request, parts_of } from './figure_parts.js';

const is_stopped = ({ state }) => ['failed', 'canceled'].includes(state);

export class FiguresPage {
  #root;
  #store;
  #link_to;
  #cards = new Map(); // figure -> its card
  #jobs = new Map(); // part -> id, at the chosen size
  #wanted = new Map(); // parts to be posted once what they start from is there -> figures asked for
  #posting = false;
  #found = null; // a promise: the jobs of the size were looked up

  constructor(root, store, link_to) {
    this.#root = root;
    this.#store = store;
    this.#link_to = link_to;
    const template = root.querySelector('template');
    for (const figure of kFigures) {
      const card = template.content.firstElementChild.cloneNode(true);
      card.dataset.figure = figure.number;
      card.querySelector('.figure-title').textContent = `Figure ${figure.number}: ${figure.title}`;
      card.querySelector('.figure-text').textContent = figure.text;
      card.querySelector('.figure-make').addEventListener('click', () => this.#make([figure]));
      card.querySelector('.figure-make').setAttribute('aria-label', `Make figure ${figure.number}`);
      card.querySelector('.figure-pictures').append(...figure.pictures.map((p) => picture_box(p)));
      this.#cards.set(figure, card);
      this.#part('cards').append(card);
    }
    this.#part('all').addEventListener('click', () => this.#make(kFigures));
    this.#part('size').addEventListener('change', () => this.#find());
    store.addEventListener('change', () => root.hidden || this.update());
  }

  open() {
    this.#found ??= this.#find();
    this.update();
  }

  get #size() {
    return Number(this.#part('size').value);
  }

  async #find() {
    const size = this.#size;
    this.#jobs.clear();
    this.#wanted.clear();
    try {
      const [[name, value]] = Object.entries(kPageLabel);
      const jobs = await jobs_labelled(`${name}:${value}`);
      if (size !== this.#size) return;
      const asked = new Set();
      for (const job of jobs) {
        const { part, size: at, figures } = job.request.labels;
        if (at !== String(size)) continue;
        figures?.split(' ').forEach((number) => asked.add(Number(number)));
        this.#store.put(job);
        // The newest that was not stopped, else the newest.
        if (!this.#jobs.has(part) || (is_stopped(this.#job(part)) && !is_stopped(job)))
          this.#jobs.set(part, job.id);
      }
      this.#want(kFigures.filter(({ number }) => asked.has(number)), (part, job) => {
        const lesson = lesson_of(part) && this.#job(lesson_of(part));
        return !job && lesson && !is_stopped(lesson);
      });
    } catch (error) {
      this.#say(error);
    }
    this.update();
  }

  async #make(figures) {
    await this.#found;
    this.#say(null);
    this.#want(figures, (part, job) => !job || is_stopped(job));
    this.update();
    await this.#post_wanted();
  }

  #want(figures, is_missing) {
    const numbers = figures.map(({ number }) => number).join(' ');
    for (const part of figures.flatMap(parts_of)) {
      if (is_missing(part, this.#job(part))) this.#wanted.set(part, numbers);
    }
  }

  // Posts what is ready; parts that wait for a lesson come with the next change.
  async #post_wanted() {
    if (this.#posting) return;
    this.#posting = true;
    try {
      for (const [part, figures] of [...this.#wanted]) {
        const lesson = lesson_of(part) && this.#job(lesson_of(part));
        if (lesson_of(part) && !lesson?.table_out) {
          if (lesson && has_ended(lesson)) {
            this.#wanted.delete(part);
            throw new ApiError(0, `Job ${lesson.id} left nothing learned: no ${part} is made.`);
          }
          continue;
        }
        const size = this.#size;
        // All pages that wait for the lesson post what reads it: together one job.
        const job = lesson
          ? await post_job(part_request(part, size, lesson.table_out, {}),
            `${lesson.id} ${part} ${this.#jobs.get(part) ?? ''}`)
          : await post_job(part_request(part, size, null, { figures }));
        this.#wanted.delete(part);
        if (size === this.#size) this.#jobs.set(part, job.id);
        this.#store.put(job);
      }
    } catch (error) {
      this.#say(error);
      this.#wanted.clear();
    }
    this.#posting = false;
    this.update();
  }

  #job(part) {
    const id = this.#jobs.get(part);
    return id ? this.#store.get(id) : null;
  }

  #say(error) {
    if (error && !(error instanceof ApiError)) throw error;
    const more = error?.errors.map(({ pointer, detail }) => `${pointer}: ${detail}`) ?? [];
    this.#part('status').textContent = error ? [error.message, ...more].join(' ') : '';
  }

  update() {
    if ([...this.#wanted.keys()].some((part) => this.#is_ready(part))) this.#post_wanted();
    for (const [figure, card] of this.#cards) {
      const parts = parts_of(figure);
      const waits = parts.filter((part) => this.#wanted.has(part)).length;
      const jobs = parts.map((part) => this.#job(part)).filter(Boolean);
      const running = jobs.find((job) => !has_ended(job) && job.state !== 'queued') ??
        jobs.find((job) => !has_ended(job));
      const done = jobs.length === parts.length && jobs.every(({ state }) => state === 'succeeded');
      const failed = waits === 0 && jobs.find(is_stopped);
      card.querySelector('.figure-make').disabled = waits > 0 || Boolean(running) || done;
      const words = failed ? `${failed.id}: ${failed.error?.message ?? state_words(failed.state)}`
        : done ? '' : running
          ? `${running.id}: ${state_words(running.state)} ${progress_words(running)}`
          : waits ? 'Waiting for what it starts from' : 'Not made yet';
      card.querySelector('.figure-state').textContent = words;
      const boxes = card.querySelectorAll('.figure-box');
      figure.pictures.forEach((picture, i) => this.#show_picture(boxes[i], picture));
    }
  }

  #is_ready(part) {
    const lesson = lesson_of(part);
    return !this.#posting && (!lesson || Boolean(this.#job(lesson)?.table_out));
  }

  async #show_picture(box, picture) {
    const parts = picture.parts ?? [picture.view ?? picture.lobe];
    const jobs = parts.map((part) => this.#job(part));
    const done = jobs.every((job) => job?.state === 'succeeded');
    const key = done ? jobs.map(({ id }) => id).join() : '';
    if (box.dataset.key === key) return;
    box.dataset.key = key;
    for (const image of box.querySelectorAll('img')) {
      URL.revokeObjectURL(image.src);
      image.remove();
    }
    box.querySelector('.figure-note').textContent = '';
    if (!key) return;
    try {
      const blobs = await Promise.all(jobs.map(({ id, request: { width, height } }) => {
        if (picture.view) return get_view(id, 'state', {});
        if (picture.lobe) return get_lobe(id, width / 2, height / 2, {});
        return get_png(id);
      }));
      if (box.dataset.key !== key) return;
      const stage = box.querySelector('.figure-stage');
      stage.classList.toggle('halves', blobs.length > 1);
      stage.append(...blobs.map((blob, i) => Object.assign(new Image(), {
        src: URL.createObjectURL(blob),
        alt: picture.parts ? `${method_words(jobs[i].request.method)}, ` +
          `${jobs[i].request.samples} samples` : picture.title })));
      await this.#note(box, jobs);
    } catch (error) {
      box.querySelector('.figure-note').textContent = error.message;
      this.#say(error);
    }
  }

  // A link to the jobs, and how far the right half's mean is from the left half's.
  async #note(box, jobs) {
    const note = box.querySelector('.figure-note');
    const link = document.createElement('a');
    link.href = this.#link_to(jobs.at(-1).id, jobs.length > 1 ? jobs[0].id : null);
    link.textContent = jobs.length > 1 ? 'open side by side' : jobs[0].id;
    note.replaceChildren(link);
    if (jobs.length < 2) return;
    const { difference } = await get_compare({ a: jobs[1].id, b: jobs[0].id });
    note.replaceChildren(`The right half is ${brightness_words(difference.mean_ratio)}; `, link);
  }

  #part(name) {
    return this.#root.querySelector(`.figures-${name}`);
  }
}

function picture_box({ title, lobe }) {
  const box = document.createElement('figure');
  box.className = lobe ? 'figure-box wide' : 'figure-box';
  const stage = document.createElement('div');
  stage.className = 'figure-stage';
  const caption = document.createElement('figcaption');
  const name = document.createElement('strong');
  name.textContent = title;
  const note = document.createElement('p');
  note.className = 'figure-note hint';
  caption.append(name, note);
  box.append(stage, caption);
  return box;
}
