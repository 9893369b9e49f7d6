// What is drawn over a picture in the stage's own resolution: the numbers of pixels when they are
// close, the inspected pixel, and the directions learned there as rods in the scene.
import { viridis } from './look.js';

const kNumbersFromPx = 46; // a pixel's side on the screen
const kRod = { least_px: 8, most_px: 70 };

const short = (v) => {
  if (v === 0) return '0';
  if (v >= 1000 || v < 0.001) return v.toExponential(1);
  return v.toPrecision(3);
};

export class Marks {
  #canvas;
  #context;
  #picture;
  #place = { zoom: 1, x: 0.5, y: 0.5 };
  #at = null;
  #lobe = null;
  #frame = 0;

  constructor(canvas, picture) {
    this.#canvas = canvas;
    this.#context = canvas.getContext('2d');
    this.#picture = picture;
    new ResizeObserver(() => this.draw_soon()).observe(canvas);
  }

  set place(place) {
    this.#place = place;
    this.draw_soon();
  }
  // The inspected pixel [x, y] or null, and its lobe as the server tells it, or null.
  set at(at) {
    this.#at = at;
    this.draw_soon();
  }
  set lobe(lobe) {
    this.#lobe = lobe;
    this.draw_soon();
  }

  draw_soon() {
    if (this.#frame) return;
    this.#frame = requestAnimationFrame(() => {
      this.#frame = 0;
      this.#draw();
    });
  }

  #draw() {
    const { clientWidth: width, clientHeight: height } = this.#canvas;
    const picture = this.#picture;
    const close = picture.width && this.#pixel_px(width) >= kNumbersFromPx;
    if (!width || !(close || this.#at)) {
      this.#canvas.width = this.#canvas.height = 1; // nothing to hold or to compose
      return;
    }
    const [w, h] = [width, height].map((v) => Math.round(v * devicePixelRatio));
    if (this.#canvas.width !== w) this.#canvas.width = w;
    if (this.#canvas.height !== h) this.#canvas.height = h;
    const context = this.#context;
    context.setTransform(devicePixelRatio, 0, 0, devicePixelRatio, 0, 0);
    context.clearRect(0, 0, width, height);
    if (!picture.width) return;
    if (close) this.#draw_numbers(width, height);
    if (this.#lobe) this.#draw_rods(width, height);
    if (this.#at) this.#draw_cross(width, height);
  }

  #pixel_px(width) {
    return width * this.#place.zoom / this.#picture.width;
  }

  // Where a point of the picture (in pixels) is on the canvas.
  #on_canvas([x, y], width, height) {
    const { zoom, x: cx, y: cy } = this.#place;
    return [width / 2 + (x / this.#picture.width - cx) * width * zoom,
      height / 2 + (y / this.#picture.height - cy) * height * zoom];
  }

  #draw_numbers(width, height) {
    const context = this.#context;
    const side = this.#pixel_px(width);
    const [left, top] = this.#on_canvas([0, 0], width, height);
    const size = Math.min(side / 4.5, 15);
    context.font = `${size}px ui-monospace, "DejaVu Sans Mono", monospace`;
    context.textAlign = 'center';
    context.textBaseline = 'middle';
    context.lineWidth = 3;
    context.strokeStyle = 'rgb(0 0 0 / 0.75)';
    context.fillStyle = '#fff';
    const first = (edge) => Math.max(0, Math.floor(-edge / side));
    for (let y = first(top); y < this.#picture.height && top + y * side < height; ++y) {
      for (let x = first(left); x < this.#picture.width && left + x * side < width; ++x) {
        this.#picture.radiance(x, y)?.forEach((value, i) => {
          const place = [left + (x + 0.5) * side, top + (y + 0.5) * side + (i - 1) * size * 1.25];
          context.strokeText(short(value), ...place);
          context.fillText(short(value), ...place);
        });
      }
    }
  }

  #draw_cross(width, height) {
    const context = this.#context;
    const [x, y] = this.#on_canvas(this.#at, width, height);
    const side = Math.max(this.#pixel_px(width), 7);
    const off = (side - this.#pixel_px(width)) / 2;
    for (const [color, line] of [['#000', 3], ['#fff', 1.4]]) {
      context.strokeStyle = color;
      context.lineWidth = line;
      context.strokeRect(x - off, y - off, side, side);
    }
  }

  // Each direction as a rod from the point along it, as long and as bright as it is likely.
  #draw_rods(width, height) {
    const context = this.#context;
    const from = this.#on_canvas(this.#at.map((v) => v + 0.5), width, height);
    const most = Math.max(...this.#lobe.directions.map(({ pdf_w }) => pdf_w), 1e-9);
    context.lineCap = 'round';
    for (const { screen, pdf_w } of this.#lobe.directions) {
      if (!screen) continue;
      const tip = this.#on_canvas(screen, width, height);
      const [dx, dy] = [tip[0] - from[0], tip[1] - from[1]];
      const length = Math.hypot(dx, dy);
      if (length < 1e-3) continue;
      const share = pdf_w / most;
      const px = kRod.least_px + (kRod.most_px - kRod.least_px) * share;
      const to = [from[0] + dx / length * px, from[1] + dy / length * px];
      for (const [color, line] of [['rgb(0 0 0 / 0.7)', 4], [viridis(share), 2.2]]) {
        context.strokeStyle = color;
        context.lineWidth = line;
        context.beginPath();
        context.moveTo(...from);
        context.lineTo(...to);
        context.stroke();
      }
    }
  }
}
