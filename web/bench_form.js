// The form of a new experiment: what it asks for, and how many jobs that is.
import { jobs_of, variants_of } from './bench_plan.js';
import { method_words, seconds } from './format.js';
import { title_of } from './scene_library.js';

const kFirst = ['none', 'adaptive'];
const kMethods = ['none', 'adaptive', 'huang', 'dahm-keller', 'ppg', 'huang-published'];

function box(name, value, words, checked) {
  const label = document.createElement('label');
  const input = Object.assign(document.createElement('input'), { type: 'checkbox', name, value,
    checked });
  label.append(input, ` ${words}`);
  return label;
}

export class BenchForm {
  #form;
  #fields;
  #cameras; // (scene) -> [[words, camera]]
  #offered = [];

  // on_submit(name, jobs): requests.
  constructor(form, scenes, fields, cameras, on_submit) {
    this.#form = form;
    this.#fields = fields;
    this.#cameras = cameras;
    const methods = fields.find(({ path }) => path === 'method').choices.map(({ value }) => value)
      .sort((a, b) => kMethods.indexOf(a) - kMethods.indexOf(b));
    form.querySelector('.bench-scenes').append(...scenes.filter(({ width }) => width)
      .map(({ name }, i) => box('scene', name, title_of(name), i === 0)));
    form.querySelector('.bench-methods').append(...methods.map((method) =>
      box('method', method, method_words(method), kFirst.includes(method))));
    form.elements.by.append(...methods.filter((method) => method !== 'huang-published')
      .map((method) => new Option(method_words(method), method)));
    form.addEventListener('input', () => this.#follow());
    form.addEventListener('submit', (event) => {
      event.preventDefault();
      const plan = this.#plan();
      on_submit(plan.name, jobs_of(plan, fields));
    });
    this.#follow();
  }

  // Its scene, size, camera and budget.
  fill({ scene, width, height, camera, samples, seconds: time }) {
    const { elements } = this.#form;
    for (const input of this.#boxes('scene')) input.checked = input.value === scene;
    Object.assign(elements.width, { value: width ?? '' });
    Object.assign(elements.height, { value: height ?? '' });
    elements.budget.value = time ? 'seconds' : 'samples';
    elements.amount.value = time ?? samples ?? 64;
    this.#follow();
    const at = this.#offered.findIndex(([, one]) => JSON.stringify(one) === JSON.stringify(camera));
    elements.camera.value = at < 0 ? '' : String(at);
  }

  #boxes(name) {
    return [...this.#form.querySelectorAll(`input[name=${name}]`)];
  }
  #checked(name) {
    return this.#boxes(name).filter(({ checked }) => checked).map(({ value }) => value);
  }

  #plan() {
    const { elements: e } = this.#form;
    const number = (input) => (input.value === '' ? null : Number(input.value));
    const scenes = this.#checked('scene');
    return {
      name: e.name.value.trim() || e.name.placeholder,
      scenes,
      variants: [...new Set([...this.#checked('method'), ...variants_of(e.variants.value)])],
      seeds: Math.min(100, Math.max(1, Math.round(Number(e.seeds.value) || 1))),
      budget: e.budget.value,
      amount: Number(e.amount.value),
      width: number(e.width),
      height: number(e.height),
      camera: this.#offered[e.camera.value]?.[1] ?? null,
      reference: e.reference.checked
        ? { method: e.by.value, times: Math.max(1, Number(e.times.value) || 1) } : null,
    };
  }

  #follow() {
    const { elements } = this.#form;
    const now = new Date();
    const plan = this.#plan();
    this.#offered = plan.scenes.length === 1 ? this.#cameras(plan.scenes[0]) : [];
    const words = ["each scene's own", ...this.#offered.map(([text]) => text)];
    if (elements.camera.dataset.key !== words.join('\n')) {
      elements.camera.dataset.key = words.join('\n');
      elements.camera.replaceChildren(...words.map((text, i) =>
        new Option(text, i ? String(i - 1) : '')));
    }
    elements.times.disabled = elements.by.disabled = !elements.reference.checked;
    elements.name.placeholder ||= `${now.toISOString().slice(0, 10)} ${
      now.toTimeString().slice(0, 8)}`;
    const jobs = jobs_of(plan, this.#fields);
    const time = plan.budget === 'seconds' ? jobs.reduce((sum, job) => sum + job.seconds, 0) : 0;
    const halves = jobs.filter(({ labels }) => labels.part !== 'run').length;
    this.#form.querySelector('.bench-count').textContent =
      `${plan.variants.length} methods × ${plan.seeds} seeds × ${plan.scenes.length} scenes` +
      `${halves ? ` and ${halves} halves of references` : ''}: ${jobs.length} jobs` +
      `${time ? `, ${seconds(time)} of rendering` : ''}.`;
    this.#form.querySelector('[type=submit]').disabled = jobs.length === halves;
  }
}
