// One pixel of the shown jobs: what the picture has there, how sure it is, and what was learned at
// the surface behind it. The pixel is chosen by click, fields or arrow keys.
import { get_lobe, get_pixel } from './api.js';
import { big, method_words, significant } from './format.js';
import { Latest } from './latest.js';
import { LobeView } from './lobe_view.js';
import { luminance } from './look.js';

const metres = (v) => v.map((part) => String(+part.toFixed(4))).join('  ');
const triple = (v, digits = 3) => v.map((part) => significant(part, digits)).join('  ');

// [name, job's answer -> text or node, or null when that is not known]
const kRows = [
  ['Radiance (R, G, B)', ({ radiance }) => triple(radiance, 4)],
  ['Luminance', ({ radiance }) => significant(luminance(radiance), 4)],
  ['Samples', ({ samples }) => big(samples)],
  ['Variance of a sample', ({ variance }) => known(variance)],
  ['Standard error', ({ standard_error }) => known(standard_error)],
  ['Place (m)', ({ surface }) => (surface ? metres(surface.position) : 'no surface')],
  ['Normal', ({ surface }) => surface && triple(surface.normal, 2)],
  ['Place that learns (state)', ({ state }) => state && swatch(state)],
  ['Its edge (m)', ({ state }) => known(state?.size)],
  ['Rays that taught it', ({ state }) =>
    (state?.visits ?? null) !== null ? big(state.visits) : null],
  ['Gain of guiding', ({ state }) => known(state?.gain)],
  ['Guided directions', ({ state }) => (state?.guide_fraction ?? null) !== null
    ? `${Math.round(100 * state.guide_fraction)} %` : null],
];
const known = (v) => (v === null || v === undefined ? null : significant(v));

function swatch({ id, color, known: is_known }) {
  const words = document.createElement('span');
  const box = document.createElement('span');
  box.className = 'swatch';
  box.style.background = color;
  words.append(box, is_known ? id : `${id}, no direction is drawn from it`);
  return words;
}

// "place 12ab · 0.12 m · 1.2K visits · gain 1.7" for a line under the picture.
export function state_line({ state }) {
  if (!state) return 'nothing is learned here';
  const words = [`place ${state.id.slice(0, 8)}`];
  if (state.size !== null) words.push(`${significant(state.size)} m`);
  if (state.visits !== null) words.push(`${big(state.visits)} visits`);
  if (known(state.gain) !== null) words.push(`gain ${known(state.gain)}`);
  return words.join(' · ');
}

export class Inspector {
  #root;
  #viewer;
  #address;
  #announce;
  #asks = new Map(); // job -> Latest
  #answers = new Map(); // job -> {key, pixel, problem}
  #lobes = new Map(); // job -> LobeView
  #told = '';

  constructor(root, viewer, address, announce) {
    this.#root = root;
    this.#viewer = viewer;
    this.#address = address;
    this.#announce = announce;
    for (const name of ['x', 'y']) {
      this.#part(name).addEventListener('input', () => {
        const at = ['x', 'y'].map((axis) => this.#part(axis).valueAsNumber);
        if (at.every(Number.isInteger)) viewer.inspect(at);
      });
    }
    this.#part('close').addEventListener('click', () => viewer.inspect(null));
    viewer.addEventListener('update', () => this.update());
  }

  update() {
    const { at } = this.#address.view;
    const [first] = this.#viewer.pictures;
    this.#part('hint').hidden = at !== null;
    this.#part('close').hidden = at === null;
    ['x', 'y'].forEach((axis, i) => {
      const field = this.#part(axis);
      const value = at ? String(at[i]) : '';
      if (field.value !== value && (at || document.activeElement !== field)) field.value = value;
      field.max = Math.max(0, [first.width, first.height][i] - 1);
    });
    const jobs = at ? this.#viewer.shown_jobs : [];
    for (const id of this.#asks.keys()) if (!jobs.includes(id)) this.#forget(id);
    jobs.forEach((id) => this.#ask(id, at));
    this.#show(jobs);
  }

  #forget(id) {
    this.#asks.get(id).stop();
    this.#asks.delete(id);
    this.#answers.delete(id);
    this.#lobes.get(id)?.root.remove();
    this.#lobes.get(id)?.clear();
    this.#lobes.delete(id);
    for (const { marks } of this.#viewer.pictures) marks.lobe = null;
  }

  #ask(id, at) {
    if (!this.#asks.has(id)) this.#asks.set(id, new Latest());
    const picture = this.#viewer.pictures.find((one) => one.job_id === id);
    const { moment } = picture;
    const [x, y] = this.#viewer.pixel_in(picture, at);
    const { frame } = picture;
    const key = [x, y, moment, frame, moment === null ? picture.tile_updates : ''].join();
    const old = this.#answers.get(id);
    if (old?.key === key) return;
    // What was there stays until the answer comes, unless it was another pixel.
    const same = old && old.key.startsWith(`${x},${y},`);
    this.#answers.set(id, { key, pixel: same ? old.pixel : null, problem: '' });
    this.#asks.get(id).run(
      async () => {
        const pixel = await get_pixel(id, x, y, { moment, frame });
        const lobe = pixel.lobe && await get_lobe(id, x, y, { moment, frame }).catch(() => null);
        return { pixel, lobe };
      },
      ({ pixel, lobe }) => {
        this.#answers.set(id, { key, pixel, problem: '' });
        this.#lobe_of(id).show(pixel.lobe, lobe, { x, y });
        for (const { job_id, marks } of this.#viewer.pictures) {
          if (job_id === id) marks.lobe = pixel.lobe;
        }
        this.#show(this.#viewer.shown_jobs);
        this.#tell(id, pixel);
      },
      (error) => {
        this.#answers.set(id, { key, pixel: null, problem: error.message });
        this.#show(this.#viewer.shown_jobs);
      });
  }

  #lobe_of(id) {
    if (!this.#lobes.has(id)) {
      this.#lobes.set(id, new LobeView(id));
      this.#part('lobes').append(this.#lobes.get(id).root);
    }
    return this.#lobes.get(id);
  }

  // Only a pixel that was chosen just now, not one whose values come in.
  #tell(id, { x, y, radiance }) {
    const place = `${x},${y}`;
    if (id !== this.#address.view.job || this.#told === place) return;
    this.#told = place;
    this.#announce(`Pixel ${x}, ${y}: ${triple(radiance)}`);
  }

  #show(ids) {
    const answers = ids.map((id) => this.#answers.get(id)).filter(Boolean);
    const problems = answers.map(({ problem }) => problem)
      .filter((words, i, all) => words && all.indexOf(words) === i);
    this.#part('problem').hidden = problems.length === 0;
    this.#part('problem').textContent = problems.join(' ');
    const table = this.#part('table');
    const pixels = answers.map(({ pixel }) => pixel);
    table.hidden = !pixels.some(Boolean);
    const cell = (name, content, attributes = {}) => {
      const made = Object.assign(document.createElement(name), attributes);
      made.append(content);
      return made;
    };
    const row = (...cells) => {
      const made = document.createElement('tr');
      made.append(...cells);
      return made;
    };
    const head = row(cell('td', ''), ...ids.map((id) =>
      cell('th', `${id}, ${method_words(this.#method(id))}`, { scope: 'col' })));
    const rows = kRows.map(([name, read]) => [name, pixels.map((pixel) => pixel && read(pixel))])
      .filter(([, values]) => values.some((value) => value !== null && value !== undefined))
      .map(([name, values]) => row(cell('th', name, { scope: 'row' }),
        ...values.map((value) => cell('td', value ?? '–'))));
    table.replaceChildren(...(ids.length > 1 ? [head] : []), ...rows);
  }

  #method(id) {
    return this.#viewer.method_of(id);
  }

  #part(name) {
    return this.#root.querySelector(`.pixel-${name}`);
  }
}
