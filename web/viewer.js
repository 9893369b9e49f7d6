// The stage: one job's picture, or two with a divider, and a panel for each. In a split view the
// job that does not learn is on the left, as in the thesis' pictures.
import { exposure, has_ended, method_words, state_words } from './format.js';
import { JobPanel } from './job_panel.js';
import { Picture } from './picture.js';

const kUnknownSize = { width: 4, height: 3 }; // the stage before the scene is loaded

export class Viewer {
  #root;
  #store;
  #selected = { job: null, with: null };
  #sides; // [{picture, panel}], left and right
  #problem = '';

  // on_compare(id or null): another job was chosen for the right half.
  constructor(root, panel_template, store, link_to, on_compare) {
    this.#root = root;
    this.#store = store;
    const panels = this.#part('panels');
    this.#sides = [...root.querySelectorAll('canvas')].map((canvas) => {
      const picture = new Picture(canvas, (problem) => {
        this.#problem = problem;
        this.update();
      });
      const panel = new JobPanel(panel_template, store, link_to);
      panels.append(panel.root);
      return { picture, panel };
    });
    this.#part('exposure').addEventListener('input', () => this.#set_exposure());
    this.#part('exposure-reset').addEventListener('click', () => {
      this.#part('exposure').value = '0';
      this.#set_exposure();
    });
    this.#part('divider').addEventListener('input', () => this.#move_divider());
    this.#part('compare').addEventListener('change', (event) => {
      on_compare(event.target.value || null);
    });
    this.#part('no-webgl').hidden = this.#sides[0].picture.supported;
    this.#set_exposure();
    this.#move_divider();
  }

  get pictures() {
    return this.#sides.map(({ picture }) => picture);
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
    const split = jobs.length === 2;
    const ordered = split && jobs[1].request.method === 'none' && jobs[0].request.method !== 'none'
      ? [jobs[1], jobs[0]] : jobs;
    this.#sides.forEach(({ picture, panel }, index) => {
      const job = ordered[index] ?? null;
      picture.show(job?.id ?? null);
      panel.root.hidden = !job;
      panel.side = split ? ['Left', 'Right'][index] : '';
      // Without WebGL2 no tiles are fetched; the server has a picture from the first sample on.
      if (job) panel.update(job, picture.has_picture || job.progress.samples > 0);
      this.#label(index, split ? job : null);
    });
    this.#part('title').textContent = ordered.map((job) => job.request.scene)
      .filter((name, i, all) => all.indexOf(name) === i).join(' | ');
    this.#root.classList.toggle('split', split);
    this.#part('divider').hidden = !split;
    this.#show_stage(ordered);
    this.#list_others();
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

  #label(index, job) {
    const label = this.#part(['left-label', 'right-label'][index]);
    label.hidden = !job;
    if (!job) return;
    const state = this.pictures[index].has_picture ? '' : ` · ${state_words(job.state)}`;
    label.textContent = method_words(job.request.method) + state;
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
    for (const { picture, panel } of this.#sides) {
      picture.exposure_ev = ev;
      panel.exposure_ev = ev;
    }
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
