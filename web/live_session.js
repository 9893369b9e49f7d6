// A session of the server and what it shows: frames onto a canvas, cameras to the server one at a
// time, the newest last; and what is measured of both.
import { ApiError, delete_live, open_live, put_live } from './api.js';
import { LiveCanvas } from './live_canvas.js';
import { LiveStream } from './live_stream.js';

const kRemembered = 240; // frames and cameras

export class LiveSession {
  #canvas;
  #stream = null;
  #info = null;
  #closed = false;
  #number = 0;
  #sent_ms = new Map(); // camera number -> when it was wanted
  #wanted = null; // a camera that waits for the one before it
  #sending = false;
  #shown_ms = [];
  #latencies = [];
  #frame = null;
  #on_frame;
  #on_end;
  walls = false; // surfaces stop the camera
  on_stop = () => {}; // (position): where one did

  constructor(element, on_frame, on_end) {
    this.#canvas = new LiveCanvas(element, 2, 2);
    this.#on_frame = on_frame;
    this.#on_end = on_end;
  }

  get info() {
    return this.#info;
  }
  get frame() {
    return this.#frame;
  }
  get supported() {
    return this.#canvas.supported;
  }
  get missed() {
    return this.#stream?.missed ?? 0;
  }
  // What frames come as, and how many bytes came.
  get encoding() {
    return this.#stream?.encoding ?? '';
  }
  get received() {
    return this.#stream?.received ?? 0;
  }
  // Of the last two seconds.
  get frames_per_second() {
    const now = performance.now();
    return this.#shown_ms.filter((t) => now - t < 2000).length / 2;
  }
  latency_ms(part) {
    const sorted = [...this.#latencies].sort((a, b) => a - b);
    return sorted.length ? sorted[Math.floor(part * (sorted.length - 1))] : NaN;
  }
  // How light becomes colour: members of the address.
  set look_of(view) {
    this.#canvas.look = view;
  }

  async open(request) {
    const info = await open_live(request);
    if (this.#closed) {
      delete_live(info.id).catch(() => {});
      return info;
    }
    this.#info = info;
    this.#canvas.resize(this.#info.width, this.#info.height);
    this.#read();
    return this.#info;
  }

  close() {
    this.#closed = true;
    this.#stream?.stop();
    this.#stream = null;
    if (this.#info) delete_live(this.#info.id).catch(() => {});
    this.#info = null;
  }

  // The answer is the number that frames of this camera have.
  look(camera) {
    this.#wanted = { camera, number: ++this.#number };
    this.#sent_ms.set(this.#number, performance.now());
    this.#send();
    return this.#number;
  }

  put(what, body) {
    return put_live(this.#info.id, what, body);
  }

  #read() {
    const id = this.#info.id;
    this.#stream = new LiveStream(id, (frame, pixels) => {
      this.#canvas.show(frame.width, frame.height, pixels);
      this.#frame = frame;
      requestAnimationFrame(() => this.#shown(frame));
    }, (error) => this.#info?.id === id && this.#on_end(error));
  }

  // Drawn, and about to be on the screen.
  #shown(frame) {
    if (this.#closed) return;
    const now = performance.now();
    this.#shown_ms = [...this.#shown_ms.slice(-kRemembered), now];
    for (const [number, wanted] of this.#sent_ms) {
      if (number > frame.camera) break;
      // Of cameras that one frame answers, the newest is what it shows.
      if (number === frame.camera) this.#latencies =
        [...this.#latencies.slice(-kRemembered), now - wanted];
      this.#sent_ms.delete(number);
    }
    this.#on_frame(frame);
  }

  async #send() {
    if (this.#sending || !this.#info) return;
    this.#sending = true;
    while (this.#wanted && this.#info) {
      const { camera, number } = this.#wanted;
      this.#wanted = null;
      try {
        const { position } = await put_live(this.#info.id, 'camera',
          { number, camera, walls: this.walls });
        if (position) this.on_stop(position);
      } catch (error) {
        if (!(error instanceof ApiError)) throw error; // the stream tells that it has ended
      }
    }
    this.#sending = false;
  }
}
