// Which part of the pictures the stage shows, the same part of each: wheel, drag, pinch, double
// click and keys move it. The centre is kept as shares of the picture, so pictures of other sizes
// follow. Tells on_place(place) with every move, on_settled(place) once it rests, and
// on_click(share_x, share_y) when a point was chosen, on_hover(share_x, share_y | null).
// A mouse or finger that drags the whole picture, which cannot move, is told by on_pull([dx, dy]),
// and null once it lets go. A finger that goes up or down scrolls the page as everywhere.

const kMostPixelPx = 128; // how large one pixel gets
const kSettleMs = 250;
const kDragFromPx = 4;
const kPullFromPx = 12;

export class StagePlace {
  #stage;
  #handlers;
  #place = { zoom: 1, x: 0.5, y: 0.5 };
  #most_zoom = 64;
  #pointers = new Map(); // id -> [x, y]
  #moved = 0;
  #settle_timer = 0;

  constructor(stage, handlers) {
    this.#stage = stage;
    this.#handlers = handlers;
    stage.addEventListener('wheel', (event) => this.#wheel(event), { passive: false });
    stage.addEventListener('pointerdown', (event) => this.#down(event));
    stage.addEventListener('pointermove', (event) => this.#move(event));
    for (const end of ['pointerup', 'pointercancel']) {
      stage.addEventListener(end, (event) => this.#up(event));
    }
    stage.addEventListener('pointerleave', () => handlers.on_hover(null));
    stage.addEventListener('dblclick', (event) => {
      if (this.#is_divider(event)) return;
      this.zoom_by(event.shiftKey ? 0.5 : 2, this.#share(event));
    });
  }

  get place() {
    return this.#place;
  }

  // `width` of the picture in pixels bounds the zoom.
  set picture_width(width) {
    const stage_px = this.#pane_box(0).width;
    this.#most_zoom = Math.max(1, width * kMostPixelPx / Math.max(stage_px, 1));
  }
  // The zoom at which one pixel of the picture is one of the screen.
  one_to_one(width) {
    return width / Math.max(this.#pane_box(0).width * devicePixelRatio, 1);
  }

  // From the address; tells nobody that it settled.
  restore(place) {
    this.#put(place);
  }

  zoom_to(zoom) {
    this.zoom_by(zoom / this.#place.zoom);
  }

  // `around`: shares of the stage that stay where they are.
  zoom_by(factor, around = [0.5, 0.5]) {
    const { zoom, x, y } = this.#place;
    const next = Math.min(Math.max(zoom * factor, 1), this.#most_zoom);
    const shift = (1 / zoom - 1 / next);
    this.#go({ zoom: next, x: x + (around[0] - 0.5) * shift, y: y + (around[1] - 0.5) * shift });
  }

  // So that a point of the picture is seen.
  reveal(x, y) {
    const half = 0.5 / this.#place.zoom;
    const inside = (v, centre) => Math.min(Math.max(centre, v - half * 0.9), v + half * 0.9);
    this.#go({ ...this.#place, x: inside(x, this.#place.x), y: inside(y, this.#place.y) });
  }

  #go(place) {
    this.#put(place);
    clearTimeout(this.#settle_timer);
    this.#settle_timer = setTimeout(() => this.#handlers.on_settled(this.#place), kSettleMs);
  }

  #put({ zoom, x, y }) {
    const half = 0.5 / zoom;
    const bound = (v) => Math.min(Math.max(v, half), 1 - half);
    this.#place = { zoom, x: bound(x), y: bound(y) };
    const { style } = this.#stage;
    style.setProperty('--zoom', zoom);
    style.setProperty('--tx', `${50 - 100 * zoom * this.#place.x}%`);
    style.setProperty('--ty', `${50 - 100 * zoom * this.#place.y}%`);
    this.#stage.classList.toggle('zoomed', zoom > 1);
    this.#handlers.on_place(this.#place);
  }

  #is_divider(event) {
    return event.target.matches('.divider');
  }

  // The pane under the pointer; in a split view they lie over each other.
  #pane_box(x, y = 0) {
    const panes = [...this.#stage.querySelectorAll('.pane:not([hidden])')]
      .map((pane) => pane.getBoundingClientRect());
    return panes.find((box) => x >= box.left && x <= box.right && y >= box.top && y <= box.bottom)
      ?? panes[0] ?? this.#stage.getBoundingClientRect();
  }

  #share({ clientX, clientY }) {
    const box = this.#pane_box(clientX, clientY);
    return [(clientX - box.left) / box.width, (clientY - box.top) / box.height];
  }

  #in_picture(event) {
    const [sx, sy] = this.#share(event);
    const { zoom, x, y } = this.#place;
    return [x + (sx - 0.5) / zoom, y + (sy - 0.5) / zoom];
  }

  // Where the whole picture is seen already, turning back scrolls the page as everywhere.
  #wheel(event) {
    if (event.deltaY > 0 && this.#place.zoom === 1 && !event.ctrlKey) return;
    event.preventDefault();
    const pixels = event.deltaY * (event.deltaMode === 1 ? 30 : 1);
    this.zoom_by(2 ** (-pixels / 240), this.#share(event));
  }

  #down(event) {
    if (event.button !== 0 || this.#is_divider(event)) return;
    this.#pointers.set(event.pointerId, [event.clientX, event.clientY]);
    if (this.#pointers.size === 1) this.#moved = 0;
    this.#stage.setPointerCapture(event.pointerId);
  }

  #move(event) {
    const old = this.#pointers.get(event.pointerId);
    if (!old) {
      if (!this.#is_divider(event)) this.#handlers.on_hover(...this.#in_picture(event));
      return;
    }
    const now = [event.clientX, event.clientY];
    const box = this.#pane_box(...now);
    const delta = now.map((v, i) => v - old[i]);
    this.#moved += Math.hypot(...delta);
    if (this.#pointers.size === 2) {
      const other = [...this.#pointers].find(([id]) => id !== event.pointerId)[1];
      const spread = (at) => Math.hypot(at[0] - other[0], at[1] - other[1]);
      const middle = now.map((v, i) => (v + other[i]) / 2);
      this.zoom_by(spread(now) / Math.max(spread(old), 1),
        [(middle[0] - box.left) / box.width, (middle[1] - box.top) / box.height]);
    }
    if (this.#place.zoom > 1 && this.#moved >= kDragFromPx) {
      const { zoom, x, y } = this.#place;
      const share = 1 / this.#pointers.size;
      this.#go({ zoom, x: x - share * delta[0] / box.width / zoom,
        y: y - share * delta[1] / box.height / zoom });
    } else if (this.#moved >= kPullFromPx && this.#pointers.size === 1) {
      this.#handlers.on_pull(delta);
    }
    this.#pointers.set(event.pointerId, now);
  }

  #up(event) {
    if (!this.#pointers.delete(event.pointerId)) return;
    this.#handlers.on_pull(null);
    if (event.type === 'pointercancel') return;
    if (this.#moved < kDragFromPx && this.#pointers.size === 0) {
      this.#handlers.on_click(...this.#in_picture(event));
    }
  }
}
