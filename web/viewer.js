// The stage and a panel for each job: one picture, two with a divider, or three in a row. A job
// whose picture was recovered shows its samples beside it. In a split view the job that does not
// learn is on the left, as in the thesis' pictures.
import { exposure, has_ended, is_recovered, method_words, state_words } from './format.js';
import { JobPanel } from './job_panel.js';
import { Picture } from './picture.js';

const kUnknownSize = { width: 4, height: 3 }; // the stage before the scene is loaded

export class Viewer {
  #root;
  #store;
  #selected = { job: null, with: null };
  #pictures; // left, right, third
  #panels; // of the one job or the two
  #problem = '';

  // on_compare(id or null): another job was chosen for the right half.
  constructor(root, panel_template, store, link_to, on_compare) {
    this.#root = root;
    this.#store = store;
    this.#pictures = [...root.querySelectorAll('canvas')].map((canvas) =>
      new Picture(canvas, (problem) => {
        this.#problem = problem;
        this.update();
      }));
    this.#panels = [0, 1].map(() => new JobPanel(panel_template, store, link_to));
    this.#part('panels').append(...this.#panels.map((panel) => panel.root));
    this.#part('exposure').addEventListener('input', () => this.#set_exposure());
    this.#part('exposure-reset').addEventListener('click', () => {
      this.#part('exposure').value = '0';
      this.#set_exposure();
    });
    this.#part('divider').addEventListener('input', () => this.#move_divider());
    this.#part('compare').addEventListener('change', (event) => {
      on_compare(event.target.value || null);
    });
    this.#part('no-webgl').hidden = this.#pictures[0].supported;
    this.#set_exposure();
    this.#move_divider();
  }

  get pictures() {
    return this.#pictures;
  }

  select(job_id, with_id) {
    this.#selected = { job: job_id, with: with_id };
    this.#problem = '';
    this.update();
  }

  // A hint that the job's film has tiles up to `newest`.
  pull(job_id, newest = null) {
    for (const picture of this.pictures) if (picture.job_id === job_id) picture.pull(newest);
  }

  restart() {
    this.pictures.forEach((picture) => picture.restart());
  }

  update() {
    const { job: job_id, with: with_id } = this.#selected;
    const jobs = [job_id, with_id].filter((id) => id !== null).map((id) => this.#store.get(id));
    const missing = [job_id, with_id].find((id) => id !== null && this.#store.is_missing(id));
    this.#part('missing').hidden = !missing;
    this.#part('missing').textContent = missing ? `There is no job ${missing}.` : '';
    this.#part('empty').hidden = job_id !== null;
    const known = jobs.length > 0 && jobs.every((job) => job);
    this.#part('shown').hidden = !known;
    this.#root.classList.toggle('has-job', job_id !== null);
    if (known) this.#show(jobs);
    else this.pictures.forEach((picture) => picture.show(null));
  }

  #show(jobs) {
    const ordered = this.#ordered(jobs);
    const views = this.#views(ordered);
    this.#pictures.forEach((picture, index) => {
      const view = views[index] ?? null;
      picture.show(view?.job.id ?? null, view?.which);
      this.#label(index, views.length > 1 ? view : null);
    });
    this.#panels.forEach((panel, index) => {
      const job = ordered[index] ?? null;
      panel.root.hidden = !job;
      panel.side = job && ordered.length > 1 ? this.#side_words(views, job) : '';
      // Without WebGL2 no tiles are fetched; the server has a picture from the first sample on.
      const has_tiles = this.#pictures.some((p) => p.job_id === job?.id && p.has_picture);
      if (job) panel.update(job, has_tiles || job.progress.samples > 0);
    });
    this.#part('title').textContent = ordered.map((job) => job.request.scene)
      .filter((name, i, all) => all.indexOf(name) === i).join(' | ');
    this.#root.classList.toggle('two-jobs', ordered.length > 1);
    this.#root.classList.toggle('split', views.length === 2);
    this.#root.classList.toggle('row', views.length === 3);
    this.#part('divider').hidden = views.length !== 2;
    this.#show_stage(ordered);
    this.#list_others();
  }

  #ordered(jobs) {
    const [first, second] = jobs;
    const swap = second?.request.method === 'none' && first.request.method !== 'none' &&
      !is_recovered(first);
    return swap ? [second, first] : jobs;
  }

  // What the stage shows, from the left: [{job, which}].
  #views([first, second]) {
    const best = (job) => ({ job, which: is_recovered(job) ? 'recovered' : 'sampled' });
    const views = is_recovered(first) ? [{ job: first, which: 'sampled' }] : [];
    views.push(best(first));
    if (second) views.push(best(second));
    return views;
  }

  #side_words(views, job) {
    if (views.at(-1).job === job) return 'Right';
    return views.length === 3 ? 'Left and middle' : 'Left';
  }

  #show_stage(jobs) {
    const stage = this.#part('stage');
    const [picture] = this.pictures;
    const size = picture.width ? picture : jobs[0].request;
    stage.style.setProperty('--w', size.width || kUnknownSize.width);
    stage.style.setProperty('--h', size.height || kUnknownSize.height);
    const waiting = picture.supported && !this.pictures.some((p) => p.has_picture);
    this.#part('waiting').hidden = !waiting;
    this.#part('waiting').textContent = jobs.every(has_ended)
      ? 'No picture was made.' : `${state_words(jobs.at(-1).state)} …`;
    this.#part('problem').hidden = !this.#problem;
    this.#part('problem').textContent = this.#problem;
  }

  #label(index, view) {
    const label = this.#part(['left-label', 'right-label', 'third-label'][index]);
    label.hidden = !view;
    if (!view) return;
    const { job, which } = view;
    const words = [method_words(job.request.method)];
    if (is_recovered(job)) words.push(which === 'recovered' ? 'recovered' : 'its samples');
    if (!this.#pictures[index].has_picture) words.push(state_words(job.state));
    label.textContent = words.join(' · ');
  }

  #list_others() {
    const select = this.#part('compare');
    const others = this.#store.newest_first().filter((job) => job.id !== this.#selected.job);
    const words = (job) => `${job.id} · ${job.request.scene} · ${method_words(job.request.method)}`;
    const options = [['', 'nothing'], ...others.map((job) => [job.id, words(job)])];
    const key = JSON.stringify(options);
    if (select.dataset.key !== key) {
      select.dataset.key = key;
      select.replaceChildren(...options.map(([value, text]) => new Option(text, value)));
    }
    select.value = this.#selected.with ?? '';
  }

  #set_exposure() {
    const ev = Number(this.#part('exposure').value);
    this.#part('exposure-value').value = exposure(ev);
    this.#part('exposure').setAttribute('aria-valuetext', exposure(ev));
    for (const shown of [...this.#pictures, ...this.#panels]) shown.exposure_ev = ev;
  }

  #move_divider() {
    const divider = this.#part('divider');
    this.#part('stage').style.setProperty('--split', `${divider.value}%`);
    divider.setAttribute('aria-valuetext', `${Math.round(divider.value)} % left`);
  }

  #part(name) {
    return this.#root.querySelector(`.view-${name}`);
  }
}
