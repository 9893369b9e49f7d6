// The frames of the shown job: a strip of small pictures that comes while they form, a slider, and
// a film of them over the stage. What is chosen stands in the address; the stage shows it in full.
import { ApiError, act_on_frame, get_frame_preview, get_frames } from './api.js';
import { exact, samples_words, seconds, significant } from './format.js';

const kSide = 320; // pixels of a preview
const kStates = { waiting: 'waits', rendering: 'renders', done: 'done', canceled: 'left out' };

export class FrameStrip {
  #root;
  #player; // a canvas over the stage
  #address;
  #store;
  #job = null; // its id
  #frames = [];
  #previews = new Map(); // frame -> {bitmap, version}
  #busy = false;
  #again = false;
  #fetching = false;
  #playing = 0; // the animation's request; 0: it stands
  #shown = 0; // the frame that the player has

  constructor(root, player, store, address) {
    this.#root = root;
    this.#player = player;
    this.#store = store;
    this.#address = address;
    this.#part('play').addEventListener('click', () => this.play(!this.#playing));
    this.#part('slider').addEventListener('input', ({ target }) => {
      this.play(false);
      this.#choose(Number(target.value));
    });
    this.#part('leave').addEventListener('click', () => this.#leave());
    this.#part('strip').addEventListener('click', ({ target }) => {
      const button = target.closest('button');
      if (!button) return;
      this.play(false);
      this.#choose(Number(button.dataset.frame));
    });
  }

  // The stage shows another job, frame or look.
  update() {
    const job = this.#store.get(this.#address.view.job);
    const id = job?.request.frames ? job.id : null;
    this.#root.hidden = !id;
    if (id !== this.#job) {
      this.play(false);
      this.#job = id;
      this.#frames = [];
      for (const { bitmap } of this.#previews.values()) bitmap?.close();
      this.#previews.clear();
      this.#part('strip').replaceChildren();
      if (id) this.refresh(id);
    }
    if (id) this.#show();
  }

  // A hint that a frame of the job has changed.
  async refresh(id) {
    if (id !== this.#job) return;
    this.#again = true;
    if (this.#busy) return;
    this.#busy = true;
    while (this.#again) {
      this.#again = false;
      try {
        const { job, frames } = await get_frames(this.#job);
        if (job === this.#job) this.#frames = frames;
      } catch (error) {
        if (!(error instanceof ApiError)) throw error;
      }
      this.#show();
    }
    this.#busy = false;
    this.#fetch_previews();
  }

  // Frames one after the other over the stage, or the chosen one on it again.
  play(on) {
    cancelAnimationFrame(this.#playing);
    this.#playing = 0;
    this.#part('play').textContent = on ? 'Pause' : 'Play';
    this.#part('play').setAttribute('aria-pressed', String(on));
    if (!on) {
      if (!this.#player.hidden) this.#choose(this.#shown);
      this.#player.hidden = true;
      return;
    }
    let last = -Infinity;
    const step = (now) => {
      this.#playing = requestAnimationFrame(step);
      if (now - last < 1000 / Number(this.#part('fps').value) - 4) return;
      last = now;
      this.#draw(this.#next(this.#shown));
    };
    this.#shown = this.#address.view.frame;
    this.#playing = requestAnimationFrame(step);
  }

  // The next frame that has a picture.
  #next(frame) {
    const count = this.#frames.length;
    for (let i = 1; i <= count; ++i) {
      const at = (frame + i) % count;
      if (this.#previews.get(at)?.bitmap) return at;
    }
    return frame;
  }

  // Leaves the chosen frame out, or renders it after all.
  async #leave() {
    const { frame } = this.#address.view;
    const canceled = this.#frames[frame]?.state === 'canceled';
    try {
      const { frames } = await act_on_frame(this.#job, canceled ? 'retry' : 'cancel', frame);
      this.#frames = frames;
    } catch (error) {
      if (!(error instanceof ApiError)) throw error; // it ended by itself
    }
    this.refresh(this.#job);
  }

  #choose(frame) {
    this.#address.set({ frame });
  }

  #draw(frame) {
    const bitmap = this.#previews.get(frame)?.bitmap;
    if (!bitmap) return;
    this.#shown = frame;
    Object.assign(this.#player, { width: bitmap.width, height: bitmap.height, hidden: false });
    this.#player.getContext('2d').drawImage(bitmap, 0, 0);
    this.#mark(frame);
  }

  #show() {
    const frames = this.#frames;
    const strip = this.#part('strip');
    while (strip.children.length > frames.length) strip.lastChild.remove();
    while (strip.children.length < frames.length) {
      strip.append(this.#new_item(strip.children.length));
    }
    frames.forEach((frame, index) => {
      const button = strip.children[index].firstElementChild;
      button.dataset.state = frame.state;
      const words = [`Frame ${index}`, frame.camera, kStates[frame.state],
        frame.samples ? `${samples_words(frame.samples)} a pixel` : ''].filter((word) => word);
      button.setAttribute('aria-label', words.join(', '));
      button.title = words.slice(1).join(', ');
    });
    const { ev, frame } = this.#address.view;
    // Previews are 8-bit: their exposure is near that of the stage, whose curve is sRGB's.
    const bright = `brightness(${2 ** (ev / 2.2)})`;
    strip.style.filter = this.#player.style.filter = ev === 0 ? '' : bright;
    const slider = this.#part('slider');
    slider.max = String(Math.max(0, frames.length - 1));
    const done = frames.filter(({ state }) => state === 'done').length;
    this.#set('progress', frames.length ? `${done} of ${frames.length} frames done` : '');
    if (!this.#playing) this.#mark(frame);
    for (const link of this.#root.querySelectorAll('.frames-downloads a')) {
      const { file, query } = link.dataset;
      const values = new URLSearchParams(query);
      if (ev !== 0 && values.get('format') !== 'exr') values.set('exposure', String(ev));
      if (file.endsWith('gif') || file.endsWith('mp4')) values.set('fps', this.#part('fps').value);
      link.href = `/v1/jobs/${encodeURIComponent(this.#job)}/${file}?${values}`;
    }
  }

  #mark(at) {
    const strip = this.#part('strip');
    [...strip.children].forEach((item, index) => {
      const button = item.firstElementChild;
      if ((button.getAttribute('aria-pressed') === 'true') === (index === at)) return;
      button.setAttribute('aria-pressed', String(index === at));
      if (index === at) {
        // Sideways alone: the page stays where it is.
        strip.scrollLeft = item.offsetLeft - strip.offsetLeft - (strip.clientWidth -
          item.offsetWidth) / 2;
      }
    });
    const frame = this.#frames[at];
    this.#part('leave').textContent = frame?.state === 'canceled' ? 'Render it' : 'Leave out';
    this.#part('leave').disabled = !frame || frame.state === 'done';
    this.#part('slider').value = String(at);
    this.#part('slider').setAttribute('aria-valuetext', `Frame ${at}`);
    this.#set('words', frame ? [`Frame ${exact(at)}`, frame.camera, samples_words(frame.samples),
      seconds(frame.seconds), frame.noise ? `noise ${significant(frame.noise)}` : '']
      .filter((word) => word).join(' · ') : '');
  }

  #new_item(frame) {
    const item = document.createElement('li');
    const button = Object.assign(document.createElement('button'), { type: 'button' });
    button.dataset.frame = String(frame);
    const canvas = Object.assign(document.createElement('canvas'), { width: 96, height: 72 });
    const number = Object.assign(document.createElement('span'), { textContent: String(frame) });
    button.append(canvas, number);
    item.append(button);
    return item;
  }

  // Of the frames that have changed, one at a time.
  async #fetch_previews() {
    if (this.#fetching) return;
    this.#fetching = true;
    for (;;) {
      const id = this.#job;
      const old = this.#frames.find(({ frame, samples }) =>
        samples > 0 && this.#previews.get(frame)?.version !== samples);
      if (!id || !old) break;
      const entry = this.#previews.get(old.frame) ?? {};
      this.#previews.set(old.frame, { ...entry, version: old.samples }); // also when it fails
      try {
        const bitmap = await createImageBitmap(await get_frame_preview(id, old.frame, kSide));
        if (id === this.#job) this.#put(old.frame, bitmap);
        else bitmap.close();
      } catch (error) {
        if (!(error instanceof ApiError)) throw error;
      }
    }
    this.#fetching = false;
  }

  #put(frame, bitmap) {
    const entry = this.#previews.get(frame);
    entry.bitmap?.close();
    entry.bitmap = bitmap;
    const canvas = this.#part('strip').children[frame]?.querySelector('canvas');
    if (!canvas) return;
    canvas.height = Math.round(canvas.width * bitmap.height / bitmap.width);
    const context = canvas.getContext('2d');
    context.imageSmoothingQuality = 'high';
    context.drawImage(bitmap, 0, 0, canvas.width, canvas.height);
    canvas.classList.add('drawn');
  }

  #part(name) {
    return this.#root.querySelector(`.frames-${name}`);
  }

  #set(name, text) {
    const part = this.#part(name);
    if (part.textContent !== text) part.textContent = text;
  }
}
