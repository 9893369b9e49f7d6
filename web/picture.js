// A picture on the stage: a canvas and the feed that fills it. Two of them, one over the other,
// make the split view.
import { TileCanvas } from './tile_canvas.js';
import { TileFeed } from './tile_feed.js';

export class Picture {
  #canvas;
  #tiles;
  #feed = null;
  #job_id = null;
  #which = '';
  #on_change;

  // on_change(problem): tiles came, or `problem` (text) says why they cannot be shown.
  constructor(canvas, on_change) {
    this.#canvas = canvas;
    this.#on_change = on_change;
    this.#tiles = new TileCanvas(canvas, () => this.#feed?.restart());
    new ResizeObserver(() => this.#choose_scaling()).observe(canvas);
  }

  get job_id() {
    return this.#job_id;
  }
  get which() {
    return this.#which;
  }
  get supported() {
    return this.#tiles.supported;
  }
  get width() {
    return this.#tiles.width;
  }
  get height() {
    return this.#tiles.height;
  }
  get tile_updates() {
    return this.#tiles.tile_updates;
  }
  get cursor() {
    return this.#feed?.cursor ?? 0n;
  }
  get has_picture() {
    return this.cursor > 0n;
  }
  read_pixels() {
    return this.#tiles.read_pixels();
  }
  set exposure_ev(value) {
    this.#tiles.exposure_ev = value;
  }

  // Shows another of the jobs' pictures ('sampled' or 'recovered'), or none (null).
  show(job_id, which = 'sampled') {
    if (job_id === this.#job_id && which === this.#which) return;
    this.#job_id = job_id;
    this.#which = which;
    this.#feed?.stop();
    this.#feed = null;
    this.#canvas.hidden = job_id === null;
    if (!this.supported) return;
    this.#tiles.clear();
    if (job_id === null) return;
    this.#feed = new TileFeed(job_id, which, {
      on_tiles: (answer) => this.#put(answer),
      on_error: (error) => this.#on_change(error.message),
    });
    this.#feed.pull();
  }

  pull(newest = null) {
    this.#feed?.pull(newest);
  }

  restart() {
    this.#feed?.restart();
  }

  #put(answer) {
    const limit_px = this.#tiles.max_px;
    if (Math.max(answer.width, answer.height) > limit_px) {
      this.#on_change(`The picture is wider or higher than the ${limit_px} pixels that this ` +
        'browser can show. The downloads are complete.');
      return;
    }
    this.#tiles.put(answer);
    this.#choose_scaling();
    this.#on_change('');
  }

  // Enlarged pixels stay sharp squares; a reduced picture is smoothed.
  #choose_scaling() {
    const shown_px = this.#canvas.clientWidth * devicePixelRatio;
    this.#canvas.classList.toggle('enlarged', shown_px >= this.#canvas.width);
  }
}
