// A camera that mouse, touch and keys move: it orbits its target, or flies. on_move() after each
// change.

const add = (a, b, s = 1) => a.map((v, i) => v + s * b[i]);
const sub = (a, b) => a.map((v, i) => v - b[i]);
const dot = (a, b) => a.reduce((sum, v, i) => sum + v * b[i], 0);
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2],
  a[0] * b[1] - a[1] * b[0]];
const length = (a) => Math.hypot(...a);
const unit = (a) => a.map((v) => v / length(a));
// Rodrigues' rotation about a unit axis.
const turned = (v, axis, angle) => add(add(v.map((x) => x * Math.cos(angle)),
  cross(axis, v), Math.sin(angle)), axis, dot(axis, v) * (1 - Math.cos(angle)));

const kTurnPerPx = 0.006;
const kTurnPerSecond = 1.2;
const kMovePerSecond = 0.5; // of the distance to the target
const kSteepest = 0.985; // sine: never quite up or down
const kMoves = { KeyW: [0, 0, 1], KeyS: [0, 0, -1], KeyA: [-1, 0, 0], KeyD: [1, 0, 0],
  KeyE: [0, 1, 0], KeyQ: [0, -1, 0] };
const kTurns = { ArrowLeft: [1, 0], ArrowRight: [-1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };

export class LiveCamera {
  #element;
  #on_move;
  #camera;
  #home;
  #pace = 1; // metres that a key moves in a second
  #keys = new Set();
  #pointers = new Map();
  #last_ms = 0;
  mode = 'orbit';

  constructor(element, on_move) {
    this.#element = element;
    this.#on_move = on_move;
    element.addEventListener('pointerdown', (event) => {
      element.setPointerCapture(event.pointerId);
      this.#pointers.set(event.pointerId, [event.clientX, event.clientY]);
    });
    element.addEventListener('pointermove', (event) => this.#drag(event));
    for (const name of ['pointerup', 'pointercancel'])
      element.addEventListener(name, (event) => this.#pointers.delete(event.pointerId));
    element.addEventListener('wheel', (event) => {
      event.preventDefault();
      this.#nearer(Math.exp(event.deltaY * 0.001));
    }, { passive: false });
    element.addEventListener('keydown', (event) => this.#key(event));
    element.addEventListener('keyup', (event) => this.#keys.delete(event.code));
    element.addEventListener('blur', () => this.#keys.clear());
  }

  get camera() {
    return structuredClone(this.#camera);
  }
  set camera(camera) {
    this.#camera = structuredClone(camera);
    this.#home ??= structuredClone(camera);
    this.#pace = kMovePerSecond * length(sub(camera.target, camera.position));
  }
  // A wall stopped it here. In flight it looks on in the same direction.
  stop_at(position) {
    const c = this.#camera;
    const back = sub(position, c.position);
    c.position = position;
    if (this.mode !== 'fly') return;
    c.target = add(c.target, back);
    this.#on_move();
  }
  // As if it had been moved there.
  go_to(camera) {
    this.camera = camera;
    this.#on_move();
  }
  // The first camera again; `forget`: another scene's comes next.
  go_home() {
    this.go_to(this.#home);
  }
  forget() {
    this.#home = null;
  }

  // By angles, and by shares of #pace along right, up and the view.
  step([yaw, pitch], [right, up, forward], seconds = 1) {
    if (yaw || pitch) this.#turn(yaw, pitch, this.mode === 'orbit' ? 'position' : 'target');
    const c = this.#camera;
    const view = unit(sub(c.target, c.position));
    const side = unit(cross(view, c.up));
    const move = add(add(side.map((v) => v * right), unit(c.up), up), view, forward)
      .map((v) => v * this.#pace * seconds);
    c.position = add(c.position, move);
    c.target = add(c.target, move);
    this.#on_move();
  }

  // Moves one end of the line of sight about the other.
  #turn(yaw, pitch, moving) {
    const c = this.#camera;
    const fixed = moving === 'position' ? 'target' : 'position';
    const up = unit(c.up);
    const sign = moving === 'position' ? 1 : -1;
    let arm = turned(sub(c[moving], c[fixed]), up, yaw);
    const side = unit(cross(arm, up));
    const tilted = turned(arm, side, sign * -pitch);
    if (Math.abs(dot(unit(tilted), up)) < kSteepest) arm = tilted;
    c[moving] = add(c[fixed], arm);
  }

  #nearer(factor) {
    const c = this.#camera;
    const arm = sub(c.position, c.target).map((v) => v * factor);
    if (length(arm) < 1e-3) return;
    // Parallel rays show no more from farther away.
    if (c.projection === 'orthographic' && c.height) c.height *= factor;
    else c.position = add(c.target, arm);
    this.#on_move();
  }

  #drag(event) {
    const before = this.#pointers.get(event.pointerId);
    if (!before) return;
    const now = [event.clientX, event.clientY];
    const delta = sub(now, before);
    const others = [...this.#pointers].filter(([id]) => id !== event.pointerId);
    this.#pointers.set(event.pointerId, now);
    if (others.length > 0) {
      const other = others[0][1];
      this.#nearer(length(sub(before, other)) / Math.max(length(sub(now, other)), 1));
    } else {
      this.drag(delta);
    }
  }

  // By pixels.
  drag([dx, dy]) {
    const sign = this.mode === 'orbit' ? -1 : 1;
    this.step([dx * kTurnPerPx * sign, dy * kTurnPerPx], [0, 0, 0]);
  }

  #key(event) {
    if (!(event.code in kMoves || event.code in kTurns) || event.ctrlKey || event.metaKey ||
        event.altKey) return;
    event.preventDefault();
    const moving = this.#keys.size > 0;
    this.#keys.add(event.code);
    this.#keys[event.shiftKey ? 'add' : 'delete']('Shift');
    if (moving) return;
    this.#last_ms = performance.now();
    requestAnimationFrame((now) => this.#fly(now));
  }

  #fly(now_ms) {
    const pressed = [...this.#keys].filter((key) => key !== 'Shift');
    if (pressed.length === 0) return;
    const fast = this.#keys.has('Shift') ? 3 : 1;
    const seconds = Math.min(Math.max(now_ms - this.#last_ms, 0) / 1000, 0.1) * fast;
    this.#last_ms = now_ms;
    let [turn, move] = [[0, 0], [0, 0, 0]];
    for (const key of pressed) {
      if (key in kTurns) turn = add(turn, kTurns[key], kTurnPerSecond * seconds);
      if (key in kMoves) move = add(move, kMoves[key]);
    }
    this.step(turn, move, seconds);
    requestAnimationFrame((now) => this.#fly(now));
  }
}
