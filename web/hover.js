// The line under the picture: the pixel that the pointer is on, its radiance, and its state while
// what was learned is shown.
import { get_pixel } from './api.js';
import { significant } from './format.js';
import { state_line } from './inspector.js';
import { Latest } from './latest.js';

const kLearned = ['state', 'gain', 'beta'];

export class Hover {
  #line;
  #viewer;
  #address;
  #ask = new Latest();
  #at = '';

  constructor(line, viewer, address) {
    this.#line = line;
    this.#viewer = viewer;
    this.#address = address;
    viewer.addEventListener('hover', ({ detail }) => this.#show(detail));
  }

  #show(at) {
    const [picture] = this.#viewer.pictures;
    const inside = at?.every((v, i) => v >= 0 && v < [picture.width, picture.height][i]);
    const key = inside ? at.join() : '';
    if (key === this.#at) return;
    this.#at = key;
    if (!inside) {
      this.#ask.stop();
      this.#line.textContent = '';
      return;
    }
    const words = [`x ${at[0]}, y ${at[1]}`];
    for (const one of this.#viewer.pictures) {
      if (!one.job_id) continue;
      const place = this.#viewer.pixel_in(one, at);
      const radiance = one.radiance(...place);
      if (radiance) words.push(radiance.map((v) => significant(v)).join(' '));
    }
    this.#line.textContent = words.join(' · ');
    const learned = this.#viewer.pictures.filter(({ job_id }) => job_id).at(-1);
    if (!kLearned.includes(this.#address.view.overlay) || !learned) return;
    this.#ask.run(() => get_pixel(learned.job_id, ...this.#viewer.pixel_in(learned, at),
      learned), (pixel) => {
      if (this.#at === key) this.#line.textContent = [...words, state_line(pixel)].join(' · ');
    });
  }
}
