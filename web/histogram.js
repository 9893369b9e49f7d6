// How a picture's values are spread over stops: a column of a quarter of a stop for each channel,
// as high as the logarithm of its pixels. The band behind is what the exposure shows, from black
// that an eye can tell to white. Counted while it is open, at most twice a second.
import { significant } from './format.js';
import { luminance } from './look.js';
import { decode_rgb9e5 } from './rgb9e5.js';

const kStops = [-12, 8];
const kColumnsAStop = 4;
const kColumns = (kStops[1] - kStops[0]) * kColumnsAStop;
const kMostPixels = 300_000; // of a larger picture, one in so many rows
const kLeastMs = 500;
const kColors = ['#f33', '#2b2', '#36f'];
const kShownStops = 8; // below white, of an 8-bit picture

// Of what came so far; null before anything did.
export function spread(picture) {
  const { width, height, texels } = picture;
  const step = Math.max(1, Math.ceil((width * height) / kMostPixels));
  const columns = [0, 1, 2].map(() => new Uint32Array(kColumns));
  const all = { columns, pixels: 0, black: 0, least: Infinity, greatest: 0, sum: 0 };
  for (let y = 0; y < height; y += step) {
    for (let x = 0; x < width; ++x) {
      if (!picture.has_tile(x, y)) continue;
      const value = decode_rgb9e5(texels[y * width + x]);
      const bright = luminance(value);
      ++all.pixels;
      all.sum += bright;
      all.least = Math.min(all.least, bright);
      all.greatest = Math.max(all.greatest, bright);
      if (bright === 0) ++all.black;
      value.forEach((v, channel) => {
        if (v <= 0) return;
        const at = Math.floor((Math.log2(v) - kStops[0]) * kColumnsAStop);
        ++columns[channel][Math.min(Math.max(at, 0), kColumns - 1)];
      });
    }
  }
  return all.pixels ? all : null;
}

export class Histogram {
  #root;
  #rows;
  #viewer;
  #address;
  #timer = 0;
  #counted = 0;

  constructor(root, viewer, address) {
    this.#root = root;
    this.#rows = root.querySelector('.histogram-rows');
    this.#viewer = viewer;
    this.#address = address;
    root.addEventListener('toggle', () => this.#soon());
    viewer.addEventListener('update', () => this.#soon());
  }

  #soon() {
    if (!this.#root.open || this.#timer) return;
    const wait = Math.max(0, this.#counted + kLeastMs - performance.now());
    this.#timer = setTimeout(() => {
      this.#timer = 0;
      this.#counted = performance.now();
      this.#show();
    }, wait);
  }

  #show() {
    const found = this.#viewer.pictures.filter(({ job_id }) => job_id)
      .map((picture) => [picture, spread(picture)]).filter(([, all]) => all);
    while (this.#rows.children.length < found.length) this.#add_row();
    [...this.#rows.children].forEach((row, index) => {
      row.hidden = index >= found.length;
      if (!row.hidden) this.#fill(row, ...found[index], found.length > 1);
    });
  }

  #add_row() {
    const row = document.createElement('figure');
    const canvas = Object.assign(document.createElement('canvas'), { width: 4 * kColumns,
      height: 96 });
    canvas.setAttribute('role', 'img');
    row.append(canvas, document.createElement('figcaption'));
    this.#rows.append(row);
  }

  #fill(row, picture, all, named) {
    const { ev, offset } = this.#address.view;
    const [canvas, words] = row.children;
    const context = canvas.getContext('2d');
    const { width, height } = canvas;
    const at = (stop) => ((stop - kStops[0]) / (kStops[1] - kStops[0])) * width;
    context.clearRect(0, 0, width, height);
    context.globalCompositeOperation = 'source-over';
    context.fillStyle = '#8884';
    const white = offset < 1 ? Math.log2(1 - offset) - ev : kStops[0];
    context.fillRect(at(white - kShownStops), 0, at(white) - at(white - kShownStops), height);
    context.globalAlpha = 0.6;
    const most = Math.log(1 + Math.max(...all.columns.flatMap((column) => [...column])));
    all.columns.forEach((column, channel) => {
      context.fillStyle = kColors[channel];
      column.forEach((count, i) => {
        const high = most > 0 ? (Math.log(1 + count) / most) * height : 0;
        context.fillRect(4 * i, height - high, 3, high);
      });
    });
    context.globalAlpha = 1;
    const share = (part) => `${significant((100 * part) / all.pixels, 2)} %`;
    const text = `${named ? `${picture.job_id}: ` : ''}luminance ${significant(all.least)} to ` +
      `${significant(all.greatest)}, mean ${significant(all.sum / all.pixels)}` +
      `${all.black ? `, ${share(all.black)} black` : ''}`;
    if (words.textContent !== text) words.textContent = text;
    canvas.setAttribute('aria-label', `Pixels by stop, from ${kStops[0]} to ${kStops[1]}: ${text}`);
  }
}
