// The form that posts a job. The server is the judge of every value; its messages are shown at the
// fields they name.
import { ApiError, post_job } from './api.js';
import { ago } from './format.js';
import { title_of } from './scene_library.js';
import { add_fields, field_of, fill_fields, read_request, show_for_method } from './job_fields.js';

// What a newcomer sees first: easy to light, and smooth after few samples.
const kFirstScene = 'thesis-room';
const kFirstRecover = 'auto';
// Integers above this lose digits on the way through JSON numbers.
const kMaxSafe = Number.MAX_SAFE_INTEGER;

export class JobForm {
  #form;
  #button;
  #on_posted;
  #on_scene;
  #sizes = new Map(); // scene name -> its own {width, height}
  #tables = [];
  #fields = []; // the server's

  // on_posted(jobs): one job, or the job and its twin without learning or with all pixels.
  // on_scene(name): another one is chosen.
  constructor(form, on_posted, on_scene) {
    this.#form = form;
    this.#button = form.querySelector('button[type=submit]');
    this.#on_posted = on_posted;
    this.#on_scene = on_scene;
    form.addEventListener('submit', (event) => {
      event.preventDefault();
      this.#submit();
    });
    form.addEventListener('input', (event) => {
      this.#follow();
      if (event.target.name) this.#show_error(event.target.name, '');
    });
    this.#follow();
  }

  // What a job may be told, as the server says it.
  show_fields(fields) {
    if (this.#fields.length) return;
    this.#fields = fields;
    add_fields(this.#form, fields);
    this.#form.elements.recover.value = kFirstRecover;
    this.#follow();
  }

  // Networks that scenes have of their own, after those that serve any.
  show_weights(weights) {
    const select = this.#form.elements.recover;
    const chosen = select.value;
    select.querySelectorAll('option[data-own]').forEach((option) => option.remove());
    for (const { id, scene } of weights) {
      const option = new Option(`${scene}, ${id.slice(0, 8)}`, id);
      option.dataset.own = '';
      select.append(option);
    }
    if ([...select.options].some(({ value }) => value === chosen)) select.value = chosen;
  }

  show_scenes(scenes) {
    const select = this.#form.elements.scene;
    const chosen = select.value || kFirstScene;
    select.replaceChildren(...scenes.map(({ name }) => new Option(title_of(name), name)));
    if (scenes.some(({ name }) => name === chosen)) select.value = chosen;
    if (!this.#sizes.size) this.#button.disabled = false; // there was no scene to name
    this.#sizes = new Map(scenes.map(({ name, width, height }) => [name, { width, height }]));
    this.#follow();
  }

  // Those of the scene and method that are chosen can be chosen too.
  show_tables(tables) {
    this.#tables = tables;
    this.#follow();
  }

  // The form as it was for another job.
  fill(request) {
    this.#clear_errors();
    const fields = this.#form.elements;
    fill_fields(fields, this.#fields, { ...request, table: 'auto' });
    fields.twin.checked = fields.full.checked = false;
    this.#follow(); // offers the tables of its scene
    fill_fields(fields, this.#fields, request);
    this.#follow();
    fields.scene.focus();
  }

  choose(scene) {
    this.#form.elements.scene.value = scene;
    this.#form.elements.width.value = this.#form.elements.height.value = '';
    this.#follow();
  }

  // Posts the form as it is, but with this scene at its own size.
  render(scene) {
    this.choose(scene);
    return this.#submit();
  }

  // Fields that follow others: the scene's own size as the hint, and what learning alone needs.
  #follow() {
    const { scene, width, height, method, table, twin, pixels, recover, full } =
      this.#form.elements;
    const size = this.#sizes.get(scene.value);
    width.placeholder = size?.width ?? '';
    height.placeholder = size?.height ?? '';
    const learns = method.value !== 'none';
    table.disabled = twin.disabled = !learns;
    full.disabled = pixels.value === 'all' && recover.value === 'none';
    show_for_method(this.#form, method.value);
    this.#list_tables();
    this.#on_scene(scene.value);
  }

  #list_tables() {
    const { scene, method, table } = this.#form.elements;
    const kind = method.value === 'huang-published' ? 'huang' : method.value;
    const fitting = this.#tables.filter((one) => one.scene === scene.value && one.method === kind);
    const key = fitting.map(({ id }) => id).join();
    if (table.dataset.key === key) return;
    table.dataset.key = key;
    const chosen = table.value;
    table.querySelectorAll('option[data-own]').forEach((option) => option.remove());
    for (const { id, created } of fitting) {
      const option = new Option(`${id.slice(0, 8)}, ${ago(created)}`, id);
      option.dataset.own = '';
      table.append(option);
    }
    if ([...table.options].some(({ value }) => value === chosen)) table.value = chosen;
  }

  // What cannot be sent: text that is no number, or too long for one.
  #unsendable() {
    const errors = [];
    for (const input of this.#form.querySelectorAll('input[type=number]')) {
      if (input.validity.badInput) {
        errors.push({ pointer: `/${input.name}`, detail: 'expected a number' });
      } else if (Math.abs(Number(input.value)) > kMaxSafe) {
        errors.push({ pointer: `/${input.name}`, detail: `expected at most ${kMaxSafe}` });
      }
    }
    return errors;
  }

  async #submit() {
    this.#clear_errors();
    const errors = this.#unsendable();
    if (errors.length) return this.#show_errors(errors);
    this.#button.disabled = true;
    try {
      const request = read_request(this.#form.elements, this.#fields);
      const { twin, full } = this.#form.elements;
      const jobs = [await post_job(request)];
      if (full.checked && !full.disabled) {
        jobs.push(await post_job({ ...request, pixels: 'all', recover: 'none' }));
      } else if (twin.checked && !twin.disabled) {
        const { table, guide, ...without } = { ...request, method: 'none' };
        jobs.push(await post_job(without));
      }
      this.#on_posted(jobs);
    } catch (error) {
      if (!(error instanceof ApiError)) throw error;
      const retry = error.retry_after_s ? ` Try again in ${error.retry_after_s} s.` : '';
      this.#show_errors(error.errors, error.message + retry);
    } finally {
      this.#button.disabled = false;
    }
    return undefined;
  }

  #show_errors(errors, summary = '') {
    const rest = errors.filter(({ pointer, detail }) =>
      !this.#show_error(field_of(pointer), detail))
      .map(({ pointer, detail }) => `${pointer}: ${detail}`);
    const first = this.#form.querySelector('[aria-invalid]');
    const text = first ? rest.join(' ') : [summary, ...rest].join(' ');
    this.#form.querySelector('.form-error').textContent = text;
    const folded = first?.closest('details:not([open])');
    if (folded) folded.open = true;
    (first ?? this.#button).focus();
  }

  // False when the form has no place for a message about this field.
  #show_error(name, text) {
    const place = document.getElementById(`${name}-error`);
    const control = this.#form.elements[name];
    if (!place || !control) return false;
    place.textContent = text;
    if (text) control.setAttribute('aria-invalid', 'true');
    else control.removeAttribute('aria-invalid');
    return true;
  }

  #clear_errors() {
    for (const place of this.#form.querySelectorAll('.field-error')) {
      this.#show_error(place.id.replace('-error', ''), '');
    }
    this.#form.querySelector('.form-error').textContent = '';
  }
}
