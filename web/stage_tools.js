// The tools around the stage: what is compared, exposure and curve, and what the colours mean.
import { png_url } from './api.js';
import { exposure, method_words } from './format.js';
import { kFalseStops } from './look.js';
import { show_options, ViewControls } from './view_controls.js';
import { title_of } from './scene_library.js';

export class StageTools {
  #root;
  #store;
  #address;
  #controls;

  constructor(root, store, address) {
    this.#root = root;
    this.#store = store;
    this.#address = address;
    this.#controls = new ViewControls(root, address);
    this.#part('exposure-reset').addEventListener('click', () => address.set({ ev: 0, offset: 0 }));
    this.#part('exposure-auto').addEventListener('click', async () => {
      const { headers } = await fetch(png_url(address.view.job, 'sampled', 'auto'));
      address.set({ ev: Math.round(headers.get('Qray-Exposure') * 10) / 10 });
    });
    this.#part('compare').addEventListener('change', ({ target }) =>
      address.set({ with: target.value || null, mode: 'split', equal: '' }, { step: true }));
  }

  update() {
    this.#controls.update();
  }

  // `pictures`: of the stage; their overlays say what their colours mean.
  show(pictures) {
    const { view } = this.#address;
    this.#part('exposure-value').value = exposure(view.ev);
    this.#part('exposure').setAttribute('aria-valuetext', exposure(view.ev));
    this.#part('offset-value').value = view.offset.toFixed(2);
    this.#part('gamma-tool').hidden = view.curve !== 'gamma';
    this.#part('gamma-value').value = view.gamma.toFixed(1);
    this.#part('false-scale').hidden = view.curve !== 'false';
    const [dark, bright] = kFalseStops.map((stop) => (2 ** (stop - view.ev)).toPrecision(2));
    this.#part('false-dark').textContent = dark;
    this.#part('false-bright').textContent = bright;
    const said = pictures.map(({ overlay }) => overlay.problem || overlay.scale)
      .filter((words, i, all) => words && all.indexOf(words) === i).join(' ');
    this.#part('caption').hidden = !said;
    this.#part('caption').textContent = said;
    this.#list_others();
  }

  #list_others() {
    const { job: job_id, with: with_id } = this.#address.view;
    const words = ({ id, request: { scene, method } }) =>
      `${id} · ${title_of(scene)} · ${method_words(method)}`;
    const others = this.#store.choices((job) => job.id !== job_id);
    show_options(this.#part('compare'),
      [['', 'nothing'], ...others.map((job) => [job.id, words(job)])], with_id ?? '');
  }

  #part(name) {
    return this.#root.querySelector(`.view-${name}`);
  }
}
