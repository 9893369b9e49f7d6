// A picture on the stage: a canvas, the feed that fills it, a coloured view over it, and the marks
// on top. Three of them, one over the other or in a row, make the stage.
import { Marks } from './marks.js';
import { OverlayImage } from './overlay_image.js';
import { decode_rgb9e5 } from './rgb9e5.js';
import { TileCanvas } from './tile_canvas.js';
import { TileFeed } from './tile_feed.js';

const moment_is_now = ({ moment }) => moment === null;

export class Picture {
  #root;
  #canvas;
  #tiles;
  #feed = null;
  #shown = { job: null, which: '', moment: null, frame: 0 };
  #texels = new Uint32Array(0);
  #on_change;
  #mix = null; // factors of groups of lights
  #group_feeds = [];
  groups_came = false; // some tiles of each

  // on_change(problem): tiles or a view came, or `problem` (text) says why tiles cannot be shown.
  constructor(root, on_change) {
    this.#root = root;
    this.#canvas = root.querySelector('canvas.picture');
    this.#on_change = on_change;
    this.#tiles = new TileCanvas(this.#canvas, () => this.restart());
    this.overlay = new OverlayImage(root.querySelector('img.overlay'), () => on_change(''));
    this.marks = new Marks(root.querySelector('canvas.marks'), this);
    new ResizeObserver(() => this.#choose_scaling()).observe(this.#canvas);
  }

  get root() {
    return this.#root;
  }
  get job_id() {
    return this.#shown.job;
  }
  get moment() {
    return this.#shown.moment;
  }
  get frame() {
    return this.#shown.frame;
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
    return this.cursor > 0n || this.#texels.length > 0;
  }
  read_pixels() {
    return this.#tiles.read_pixels();
  }

  // Radiance at a pixel, or null where no tile came; to the precision of RGB9E5.
  radiance(x, y) {
    if (!this.#tiles.has_tile(x, y)) return null;
    if (this.#mix && this.groups_came) return this.#tiles.mixed_at(x, y);
    return decode_rgb9e5(this.#texels[y * this.width + x]);
  }

  // What came of the picture: RGB9E5 in rows from the top, and a test by place.
  get texels() {
    return this.#texels;
  }
  has_tile(x, y) {
    return this.#tiles.has_tile(x, y);
  }

  // The part of the view that every picture shares: how radiance becomes colour, and {zoom, x, y}
  // with the centre as shares of the picture.
  set look(look) {
    this.#tiles.look = look;
  }
  set place(place) {
    this.#tiles.zoom = place.zoom;
    this.marks.place = place;
    this.#choose_scaling();
  }

  // The light of groups of lights times these factors, in place of what was rendered; null: that.
  set mix(factors) {
    if (factors && !this.#tiles.can_mix) return;
    this.#mix = factors;
    this.#tiles.mix = factors;
    this.#follow_groups();
  }

  // The tiles of each group, once they are needed and the picture's size is known.
  #follow_groups() {
    if (!this.#mix || this.#group_feeds.length || !this.width) return;
    const { job, frame } = this.#shown;
    this.#group_feeds = this.#mix.map((_, group) => new TileFeed(job, group, null, frame, {
      on_tiles: (answer) => {
        this.#tiles.put_group(group, this.#group_feeds.length, answer);
        this.groups_came = this.#group_feeds.every(({ cursor }) => cursor > 0n);
        this.#on_change('');
      },
      on_error: (error) => this.#on_change(error.message),
    }));
    this.#group_feeds.forEach((feed) => feed.pull());
  }

  // Shows another of the jobs' pictures ('sampled' or 'recovered'), or none (null), as it is now or
  // as it was at a moment. The old one stays until the new one of the same job is there.
  show(job, which = 'sampled', moment = null, frame = 0) {
    const old = this.#shown;
    if (job === old.job && which === old.which && moment === old.moment &&
      frame === old.frame) return;
    this.#shown = { job, which, moment, frame };
    for (const feed of [this.#feed, ...this.#group_feeds]) feed?.stop();
    this.#feed = null;
    this.#group_feeds = [];
    this.groups_came = false;
    this.#root.hidden = job === null;
    this.#canvas.hidden = job === null;
    if (!this.supported) return;
    if (job !== old.job || which !== old.which) this.#clear();
    if (job === null) return;
    this.#feed = new TileFeed(job, which, moment, frame, {
      on_tiles: (answer) => this.#put(answer),
      on_error: (error) => this.#on_change(error.message),
    });
    this.#feed.pull();
  }

  pull(newest = null) {
    for (const feed of [this.#feed, ...this.#group_feeds]) feed?.pull(newest);
  }

  restart() {
    for (const feed of [this.#feed, ...this.#group_feeds]) feed?.restart();
  }

  #clear() {
    this.#tiles.clear();
    this.#texels = new Uint32Array(0);
    this.marks.draw_soon();
  }

  #put(answer) {
    const limit_px = this.#tiles.max_px;
    if (Math.max(answer.width, answer.height) > limit_px) {
      this.#on_change(`The picture is wider or higher than the ${limit_px} pixels that this ` +
        'browser can show. The downloads are complete.');
      return;
    }
    // A frame that has no picture yet must not look like the one before.
    if (answer.cursor === 0n && moment_is_now(this.#shown)) this.#clear();
    this.#tiles.put(answer);
    this.#follow_groups();
    if (this.#texels.length !== this.width * this.height) {
      this.#texels = new Uint32Array(this.width * this.height);
    }
    for (const { x, y, w, h, pixels } of answer.tiles) {
      for (let row = 0; row < h; ++row) {
        this.#texels.set(pixels.subarray(row * w, (row + 1) * w), (y + row) * this.width + x);
      }
    }
    this.#choose_scaling();
    this.marks.draw_soon();
    this.#on_change('');
  }

  // Enlarged pixels stay sharp squares; a reduced picture is smoothed.
  #choose_scaling() {
    this.#root.classList.toggle('enlarged', this.#tiles.shown_px() >= this.width);
  }
}
