// The groups of lights of the shown job, to mix: intensity, colour and switch of each. The mix
// stands in the address, so that a link, the downloads and a new job have it too.
import { ApiError, get_light_groups } from './api.js';
import { exposure } from './format.js';
import { rgb_of } from './look.js';

const kWhite = '#ffffff';
const to_linear = (v) => (v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4);
const to_display = (v) => (v <= 0.0031308 ? 12.92 * v : 1.055 * v ** (1 / 2.4) - 0.055);
const short = (v) => String(Number(v.toPrecision(4)));

// "1;0;2,1.5,1" -> [[1, 1, 1], ...]; null where it is no mix of so many groups.
export function parse_mix(text, count) {
  const factors = text.split(';').map((part) => {
    const numbers = part.split(',').map(Number);
    return numbers.length === 1 ? Array(3).fill(numbers[0]) : numbers;
  });
  const good = factors.length === count && factors.every((factor) => factor.length === 3 &&
    factor.every((v) => v >= 0 && v <= 1e6));
  return good ? factors : null;
}

const factor_text = ({ on, stops, color }) => {
  if (!on) return '0';
  const tint = rgb_of(color).map(to_linear);
  const most = Math.max(...tint) || 1;
  const factor = tint.map((v) => short(2 ** stops * (Math.max(...tint) ? v / most : 1)));
  return factor.every((v) => v === factor[0]) ? factor[0] : factor.join();
};

function settings_of(factor, old) {
  const most = Math.max(...factor);
  if (most === 0) return { on: false, stops: old?.stops ?? 0, color: old?.color ?? kWhite };
  const color = `#${factor.map((v) => Math.round(255 * to_display(v / most)).toString(16)
    .padStart(2, '0')).join('')}`;
  return { on: true, stops: Math.log2(most), color };
}

export class LightMixer {
  #root;
  #store;
  #viewer;
  #address;
  #post; // (request): posts a job
  #job = null;
  #asked = '';
  #groups = [];
  #settings = [];

  constructor(root, store, viewer, address, post) {
    this.#root = root;
    this.#store = store;
    this.#viewer = viewer;
    this.#address = address;
    this.#post = post;
    this.#part('reset').addEventListener('click', () => address.set({ mix: '' }));
    this.#part('post').addEventListener('click', () => {
      const { request } = store.get(this.#job);
      this.#post({ ...request, mix: address.view.mix });
    });
    this.#part('groups').addEventListener('input', () => this.#take());
  }

  update() {
    const job = this.#store.get(this.#address.view.job);
    const keeps = job?.request.light_groups && job.request.light_groups !== 'none';
    const id = keeps ? job.id : null;
    if (id !== this.#job) {
      this.#job = id;
      this.#groups = [];
      this.#settings = [];
    }
    // Their names are known once the scene is loaded.
    const asked = `${id} ${job?.state}`;
    if (id && !this.#groups.length && asked !== this.#asked) this.#ask(id, asked);
    this.#root.hidden = !this.#groups.length;
    this.#part('post').disabled = !this.#address.view.mix || Boolean(job?.request.mix);
    this.#show();
  }

  async #ask(id, asked) {
    this.#asked = asked;
    try {
      const { groups } = await get_light_groups(id);
      if (id !== this.#job) return;
      this.#groups = groups;
      this.#part('groups').replaceChildren(...groups.map((name, at) => this.#row(name, at)));
      this.update();
    } catch (error) {
      if (!(error instanceof ApiError)) throw error;
    }
  }

  #row(name, at) {
    const row = this.#part('row').content.firstElementChild.cloneNode(true);
    const [on, stops, color] = row.querySelectorAll('input');
    row.querySelector('label').htmlFor = on.id = `light-${at}`;
    row.querySelector('label').textContent = name;
    stops.setAttribute('aria-label', `Intensity of ${name}`);
    color.setAttribute('aria-label', `Colour of ${name}`);
    return row;
  }

  // The controls changed.
  #take() {
    this.#settings = [...this.#part('groups').children].map((row) => {
      const [on, stops, color] = row.querySelectorAll('input');
      return { on: on.checked, stops: Number(stops.value), color: color.value };
    });
    const parts = this.#settings.map(factor_text);
    this.#address.set({ mix: parts.every((part) => part === '1') ? '' : parts.join(';') });
  }

  #show() {
    const count = this.#groups.length;
    const { mix } = this.#address.view;
    const factors = count ? parse_mix(mix, count) : null;
    this.#viewer.mix = factors && { job: this.#job, factors };
    if (factors && !this.#settings.length) this.#root.open = true;
    const parts = factors ? mix.split(';') : Array(count).fill('1');
    parts.forEach((part, at) => {
      const old = this.#settings[at];
      // What the controls said stays: the colour of what is off, a slider's place.
      const now = old && factor_text(old) === part ? old
        : settings_of(factors?.[at] ?? [1, 1, 1], old);
      this.#settings[at] = now;
      const row = this.#part('groups').children[at];
      const [on, stops, color] = row.querySelectorAll('input');
      on.checked = now.on;
      stops.value = now.stops;
      color.value = now.color;
      row.querySelector('output').value = exposure(now.stops);
      stops.setAttribute('aria-valuetext', exposure(now.stops));
    });
  }

  #part(name) {
    return this.#root.querySelector(`.mixer-${name}`);
  }
}
