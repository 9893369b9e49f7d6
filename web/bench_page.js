// The page of experiments: a form that posts one, those that there are, and what one comes to.
// Loaded when it is first opened. An experiment is the jobs that share a label.
import { ApiError, act_on_job, delete_labelled, jobs_found, jobs_labelled, list_fields, list_scenes,
  post_job } from './api.js';
import { BenchCase } from './bench_case.js';
import { measure } from './bench_data.js';
import { BenchForm } from './bench_form.js';
import { equal_time, median, summary_of } from './bench_measures.js';
import { chart_command, kLabel } from './bench_plan.js';
import { csv, save } from './chart_files.js';
import { ago, has_ended, progress_words, state_words } from './format.js';
import { kept_cameras } from './live_bookmarks.js';
import { with_text } from './live_camera_text.js';
import { ViewControls } from './view_controls.js';

const kColumns = ['scene', 'width', 'height', 'method', 'seed', 'job', 'at', 'samples', 'seconds',
  'noise', 'error', 'trimmed', 'flip', 'brightness'];
const label_of = (job, name) => job.request.labels?.[name];
const is_run = (job) => !label_of(job, 'part')?.startsWith('reference');
const variant_of = (job) => label_of(job, 'variant') ?? job.request.method;
// What must be equal for errors to be compared.
const case_of = ({ request: { scene, width, height, camera } }) =>
  JSON.stringify([scene, width, height, camera ?? null]);

// The median seconds of the method that took longest.
const slowest = (runs) => Math.max(0.01, ...[...new Set(runs.map(({ variant }) => variant))]
  .map((variant) => median(runs.filter((run) => run.variant === variant)
    .map(({ end }) => end.seconds))));

export class BenchPage {
  #root;
  #store;
  #address;
  #template;
  #controls;
  #form = null;
  #opened = ''; // what of the address is shown
  #group = null; // its name
  #jobs = new Map(); // id -> job, of the group
  #measured = new Map(); // id -> {curve, end, floor}, or null: it is asked for
  #others = []; // jobs that may have run beside
  #cases = new Map(); // case -> BenchCase
  #measuring = false;
  #drawing = false;

  constructor(root, store, address) {
    this.#root = root;
    this.#store = store;
    this.#address = address;
  }

  // Once, before all else.
  async load() {
    document.head.append(Object.assign(document.createElement('link'),
      { rel: 'stylesheet', href: 'bench.css' }));
    const html = await (await fetch('/bench.html')).text();
    const parts = new DOMParser().parseFromString(html, 'text/html');
    this.#root.append(...parts.body.children);
    this.#template = this.#root.querySelector('.bench-case');
    this.#controls = new ViewControls(this.#root, this.#address);
    for (const [name, act] of Object.entries({ csv: () => this.#save_csv(),
      json: () => this.#save_json(), cancel: () => this.#cancel(),
      delete: () => this.#delete() })) this.#part(name).addEventListener('click', act);
    this.#store.addEventListener('change', ({ detail: job }) => {
      if (!job) this.#forget();
      else if (this.#group !== null && label_of(job, kLabel) === this.#group) {
        this.#jobs.set(job.id, job);
        this.#update_soon();
      }
    });
    await this.#say_problems(async () => {
      const [scenes, fields] = await Promise.all([list_scenes(), list_fields()]);
      this.#form = new BenchForm(this.#part('form'), scenes, fields,
        (scene) => this.#cameras(scene), (name, jobs) => this.#post(name, jobs));
    });
  }

  // The address changed.
  async open() {
    const { group, job } = this.#address.view;
    this.#controls.update();
    this.#part('start').hidden = group !== null;
    this.#part('view').hidden = this.#part('new').hidden = group === null;
    this.#root.querySelector('h2').textContent = group === null ? 'Experiments' : group;
    const key = JSON.stringify([group, job]);
    if (key === this.#opened) return group === null ? undefined : this.#update_soon();
    this.#opened = key;
    this.#group = group;
    for (const known of [this.#jobs, this.#measured, this.#cases]) known.clear();
    this.#part('cases').replaceChildren();
    return this.#say_problems(async () => {
      if (group === null) {
        const from = job && this.#store.get(job);
        if (from) this.#form.fill(from.request);
        await this.#list();
        return;
      }
      const jobs = await jobs_labelled(`${kLabel}:${group}`);
      if (group !== this.#group) return;
      for (const one of jobs) this.#jobs.set(one.id, one);
      if (!jobs.length) throw new ApiError(404, `There is no experiment ${group}.`);
      this.#update_soon();
    });
  }

  async #list() {
    const jobs = await jobs_found({ q: `${kLabel}:` });
    const names = new Map();
    for (const job of jobs) {
      const name = label_of(job, kLabel);
      if (name) names.set(name, [...(names.get(name) ?? []), job]);
    }
    this.#part('none').hidden = names.size > 0;
    this.#part('list').replaceChildren(...[...names].map(([name, own]) => {
      const line = document.createElement('li');
      const link = document.createElement('a');
      link.href = this.#address.group_link(name);
      link.textContent = name;
      line.append(link, `, ${label_of(own[0], 'jobs') ?? own.length} jobs, ${ago(own[0].created)}`);
      return line;
    }));
  }

  // Cameras of the scene: those that were kept by name, then those of its jobs, the newest first.
  #cameras(scene) {
    const cameras = new Map();
    for (const [name, text] of kept_cameras(scene)) {
      const camera = with_text({}, text);
      if (camera) cameras.set(JSON.stringify(camera), [name, camera]);
    }
    for (const { id, request } of this.#store.newest_first()) {
      const key = JSON.stringify(request.camera);
      if (request.scene !== scene || !request.camera || cameras.has(key)) continue;
      cameras.set(key, [`that of ${id}`, request.camera]);
    }
    return [...cameras.values()];
  }

  // Posted again, those that are there already stay as they are.
  async #post(name, jobs) {
    const button = this.#part('form').querySelector('[type=submit]');
    button.disabled = true;
    await this.#say_problems(async () => {
      for (const [i, job] of jobs.entries()) {
        try {
          this.#store.put(await post_job(job, `${kLabel} ${name} ${i}`));
        } catch (error) {
          if (!(error instanceof ApiError)) throw error;
          const more = error.errors.map(({ pointer, detail }) => `${pointer}: ${detail}`);
          throw new ApiError(error.status, error.status === 409
            ? `There is another experiment ${name}: choose another name.`
            : [`${i} of ${jobs.length} jobs are posted.`, error.message, ...more].join(' '));
        }
        this.#part('count').textContent = `${i + 1} of ${jobs.length} jobs are posted.`;
      }
      this.#address.set({ group: name, job: null, with: null }, { step: true });
    });
    button.disabled = false;
  }

  // A job may have been deleted.
  #forget() {
    for (const id of this.#jobs.keys()) {
      if (!this.#store.is_missing(id)) continue;
      this.#jobs.delete(id);
      this.#update_soon();
    }
  }

  #update_soon() {
    if (this.#drawing) return;
    this.#drawing = true;
    setTimeout(() => {
      this.#drawing = false;
      if (this.#group === null) return;
      this.#update();
      this.#measure();
    }, 100);
  }

  #update() {
    const jobs = [...this.#jobs.values()];
    const ended = jobs.filter(has_ended);
    const running = jobs.find((job) => !has_ended(job) && job.state !== 'queued');
    const bad = ended.filter(({ state }) => state !== 'succeeded');
    this.#part('progress').textContent = [`${ended.length} of ${jobs.length} jobs have ended.`,
      running ? `${running.id} ${is_run(running) ? '' : '(a half of the reference) '}is ${
        state_words(running.state).toLowerCase()}: ${progress_words(running)}.` : '',
      ...bad.map(({ id, state, error }) => `${id}: ${error?.message ?? state_words(state)}.`),
    ].filter(Boolean).join(' ');
    this.#part('bar').hidden = ended.length === jobs.length;
    this.#part('bar').value = ended.length / Math.max(1, jobs.length);
    this.#part('cancel').disabled = ended.length === jobs.length;
    this.#part('delete').disabled = ended.length !== jobs.length;
    const { axis } = this.#address.view;
    const results = this.#results();
    for (const of of results) {
      let shown = this.#cases.get(of.key);
      if (!shown) {
        shown = new BenchCase(this.#template, (id) => this.#address.link(id));
        this.#cases.set(of.key, shown);
        this.#part('cases').append(shown.root);
      }
      shown.show(of, axis);
    }
    for (const name of ['csv', 'json']) this.#part(name).disabled = !this.#measured.size;
    this.#show_command(results);
  }

  // By scene, size and camera.
  #results() {
    const jobs = [...this.#jobs.values()]
      .sort((a, b) => a.created.localeCompare(b.created) || a.id.localeCompare(b.id));
    const keys = [...new Set(jobs.map(case_of))];
    const scene_of = (key) => JSON.parse(key)[0];
    const variants = [...new Set(jobs.filter(is_run).map(variant_of))];
    return keys.map((key) => {
      const own = jobs.filter((job) => case_of(job) === key);
      const [{ request }] = own.filter(is_run).length ? own.filter(is_run) : own;
      const runs = own.filter((job) => is_run(job) && this.#measured.get(job.id)).map((job) => ({
        job, variant: variant_of(job), seed: job.request.seed, ...this.#measured.get(job.id) }));
      const floor = runs.find((run) => run.floor !== undefined)?.floor ?? null;
      const made = own.some((job) => !is_run(job));
      return { key, request, runs, variants, made, floor, halves: this.#halves(key),
        others: [...jobs, ...this.#others],
        sizes: keys.filter((one) => scene_of(one) === request.scene).length };
    });
  }

  // Of the reference, once both are there.
  #halves(key) {
    const halves = [...this.#jobs.values()].filter((job) => !is_run(job) &&
      job.state === 'succeeded' && case_of(job) === key);
    return halves.length >= 2 ? halves.slice(0, 2) : null;
  }

  // What is not known yet, one after the other.
  async #measure() {
    if (this.#measuring) return;
    this.#measuring = true;
    const group = this.#group;
    await this.#say_problems(async () => {
      for (;;) {
        const jobs = [...this.#jobs.values()];
        const next = jobs.find((job) => is_run(job) && job.state === 'succeeded' &&
          !this.#measured.has(job.id) && !jobs.some((other) => !is_run(other) &&
            !has_ended(other) && case_of(other) === case_of(job)));
        if (!next) break;
        this.#measured.set(next.id, null);
        const known = await measure(next, this.#halves(case_of(next)));
        if (group !== this.#group) return;
        this.#measured.set(next.id, known);
        await this.#ask_of_others();
        this.#update();
      }
    });
    this.#measuring = false;
    if (group !== this.#group) this.#update_soon();
  }

  // Other jobs of the server, of the 200 that were posted last before the end of this.
  async #ask_of_others() {
    const last = Math.max(...[...this.#jobs.values()].map(({ ended }) => Date.parse(ended ?? 0)));
    const found = await jobs_found({
      created_before: `${new Date(last + 1000).toISOString().slice(0, 19)}Z` });
    this.#others = found.filter(({ id }) => !this.#jobs.has(id));
  }

  #show_command(results) {
    const runs = results.flatMap((one) => one.runs);
    const [first] = [...this.#jobs.values()].filter(is_run);
    if (!first) return;
    const { seconds } = first.request;
    const sizes = new Set(results.map(({ request: { width, height } }) => `${width}x${height}`));
    const halves = results.flatMap((one) => one.halves ?? []);
    const round = (value) => +value.toPrecision(3);
    this.#part('command').textContent = chart_command({
      scenes: [...new Set(results.map(({ request }) => request.scene))],
      variants: results[0].variants,
      seconds: round(seconds ?? slowest(runs)),
      seeds: Math.max(2, ...[...this.#jobs.values()].filter(is_run).map(({ request }) =>
        request.seed)),
      size: sizes.size === 1 ? [...sizes][0] : null,
      reference_method: halves[0]?.request.method,
      reference_seconds: halves.length ? round(halves.slice(0, 2)
        .reduce((sum, { stats }) => sum + stats.seconds, 0)) : null,
      folder: `charts-${this.#group.replaceAll(/[^\w-]+/g, '-')}`,
    });
    const uploaded = results.some(({ request }) => request.scene.startsWith('up-'));
    this.#part('command-note').textContent = [
      seconds ? '' : 'The command stops by time: by the median time of the slowest method.',
      results.some(({ request }) => request.camera)
        ? 'It has no camera: it renders with the scene\'s own.' : '',
      uploaded ? 'In place of an uploaded scene\'s id it takes the path of its file.' : '',
    ].filter(Boolean).join(' ');
  }

  #rows() {
    return this.#results().flatMap(({ request, runs }) => runs.flatMap((run) => {
      const common = { scene: request.scene, width: request.width, height: request.height,
        method: run.variant, seed: run.seed, job: run.job.id };
      return [...run.curve.map((at) => ({ ...common, at: 'pass', ...at })),
        { ...common, at: 'end', ...run.end }];
    }));
  }

  #save_csv() {
    save(`${this.#group}.csv`, csv(kColumns, this.#rows()));
  }

  #save_json() {
    const cases = this.#results().map(({ request, runs, variants, halves, floor, others }) => ({
      scene: request.scene, width: request.width, height: request.height,
      camera: request.camera ?? null, error: halves ? 'relmse' : 'estimated noise',
      reference: halves && { jobs: halves.map(({ id }) => id), relmse: floor },
      equal_time: runs.length ? equal_time(runs, others) : null,
      methods: summary_of(runs, variants, floor),
      runs: runs.map(({ job, variant, seed, curve, end }) => ({ job: job.id, method: variant, seed,
        end, curve })) }));
    save(`${this.#group}.json`, JSON.stringify({ experiment: this.#group,
      command: this.#part('command').textContent, cases }, null, 1));
  }

  async #cancel() {
    await this.#say_problems(async () => {
      // From the last one, so that none starts meanwhile.
      for (const job of [...this.#jobs.values()].reverse()) {
        if (!has_ended(job)) this.#store.put(await act_on_job(job.id, 'cancel'));
      }
    });
  }

  async #delete() {
    const count = this.#jobs.size;
    if (!confirm(`Delete the experiment ${this.#group}, ${count} jobs and their pictures?`)) return;
    await this.#say_problems(async () => {
      await delete_labelled(`${kLabel}:${this.#group}`);
      this.#address.set({ group: null }, { step: true });
    });
  }

  async #say_problems(act) {
    this.#part('problem').textContent = '';
    try {
      await act();
    } catch (error) {
      if (!(error instanceof ApiError)) throw error;
      this.#part('problem').textContent = error.message;
    }
  }

  #part(name) {
    return this.#root.querySelector(`.bench-${name}`);
  }
}
