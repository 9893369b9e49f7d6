// What a job learned of the directions at one surface: the server's sphere picture, and, where the
// directions are a tree, the tree's cells in the unit square under the hemisphere.
import { count } from './format.js';
import { viridis } from './look.js';

const kSquarePx = 220;

export class LobeView {
  #image = document.createElement('img');
  #square = document.createElement('canvas');
  #words = document.createElement('figcaption');
  root = document.createElement('figure');

  constructor(job_id) {
    this.root.className = 'lobe';
    this.root.dataset.job = job_id;
    this.root.hidden = true;
    this.#square.className = 'lobe-cells';
    this.#square.setAttribute('role', 'img');
    this.root.append(this.#image, this.#square, this.#words);
  }

  // `lobe` as the server tells it, or null; `picture`: its sphere as a blob, or null.
  show(lobe, picture, { x, y }) {
    this.root.hidden = !lobe;
    this.#put_picture(lobe && picture);
    if (!lobe) return;
    const { directions, cells } = lobe;
    const strongest = directions.reduce((best, one) => (one.pdf_w > best.pdf_w ? one : best),
      { pdf_w: 0, wi: [0, 0, 0] });
    const toward = strongest.wi.map((v) => v.toFixed(2)).join(', ');
    const what = cells ? `a tree of ${count(cells.length)} cells` :
      `${directions.length} directions`;
    this.#words.textContent = `${this.root.dataset.job}, pixel ${x}, ${y}: ${what}; densest ` +
      `toward (${toward}), ${strongest.pdf_w.toPrecision(3)} per steradian.`;
    this.#image.alt = `Directions learned at pixel ${x}, ${y}, on a sphere`;
    this.#square.hidden = !cells;
    if (cells) this.#draw_cells(cells);
  }

  clear() {
    this.#put_picture(null);
  }

  #put_picture(blob) {
    const old = this.#image.src;
    this.#image.hidden = !blob;
    if (blob) this.#image.src = URL.createObjectURL(blob);
    else this.#image.removeAttribute('src');
    if (old.startsWith('blob:')) URL.revokeObjectURL(old);
  }

  #draw_cells(cells) {
    const square = this.#square;
    const side = kSquarePx * devicePixelRatio;
    square.width = square.height = side;
    square.setAttribute('aria-label', `The tree's ${cells.length} cells in the unit square; ` +
      'brighter ones are likelier');
    const context = square.getContext('2d');
    const most = Math.max(...cells.map(({ pdf_w }) => pdf_w), 1e-9);
    for (const { u, v, size, pdf_w } of cells) {
      const box = [u * side, v * side, size * side, size * side];
      context.fillStyle = viridis(Math.sqrt(pdf_w / most));
      context.fillRect(...box);
      context.strokeStyle = 'rgb(255 255 255 / 0.35)';
      context.strokeRect(...box);
    }
  }
}
