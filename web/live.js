// Live over the stage of the viewer: a session that follows mouse, fingers and keys, perhaps a
// second one without what is being compared. Controls set the address (`live`: the camera, `off`,
// `dark`, `beside`), and follow() shows what it says. Loaded when it is first needed
// (live_gate.js).
import { keep_camera, kept_cameras } from './live_bookmarks.js';
import { LiveCamera } from './live_camera.js';
import { camera_text, with_text } from './live_camera_text.js';
import { show_measures } from './live_measures.js';
import { LiveSession } from './live_session.js';

const kSwitches = ['learning', 'recovery', 'reprojection'];
const kStageWords = { moving: 'moving: history and recovery',
  settling: 'at rest: new samples displace the history',
  still: 'at rest: samples, recovered where they are few' };
const kMostSide = 640; // pixels of a picture on the page
const kFrameMs = 75; // a camera waits for up to two frames, the one under way and its own
const kMeasuresMs = 250;
const kRestMs = 300; // until a camera stands in the address

const parts_of = (text) => (text ? text.split(',') : []);

function size_of({ width, height }) {
  const scale = Math.min(1, kMostSide / Math.max(width, height));
  const even = (side) => Math.max(2, 2 * Math.round((side * scale) / 2));
  return { width: even(width), height: even(height) };
}

export class Live {
  #root;
  #layer;
  #address;
  #say;
  #base = null; // the first camera
  #first = 0; // number of the camera that is shown first
  #given = {}; // what the sessions have of the address
  #pulled = [0, 0]; // pixels of a drag that no session has seen
  #rest_timer = 0;
  main = null;
  other = null;
  camera;
  mix = ''; // how a job is lit as the lights are switched

  // say(problem, ended): in words; `ended`: the first session is gone.
  constructor(root, address, say) {
    this.#root = root;
    this.#layer = this.#part('layer');
    this.#address = address;
    this.#say = say;
    this.camera = new LiveCamera(this.#layer, () => this.#look());
    setInterval(() => {
      const seen = [this.main, this.other].filter((session) => session?.frame);
      if (this.main?.frame) show_measures(this.#part('measures'), seen);
    }, kMeasuresMs);
    this.#part('switches').addEventListener('change', () => this.#set_off('switches', 'off'));
    this.#part('lights').addEventListener('change', () => this.#set_off('lights', 'dark'));
    this.#part('move').addEventListener('change', ({ target }) => {
      this.camera.mode = target.value;
    });
    this.#part('walls').addEventListener('change', () => this.#show_walls());
    this.#part('camera').addEventListener('change', () => this.#choose_camera());
    this.#part('keep').addEventListener('click', () => this.#keep_camera());
    this.#part('forget').addEventListener('click', () => {
      keep_camera(this.main.info.scene, this.#part('camera').selectedOptions[0].text, null);
      this.#show_cameras();
    });
    this.#part('home').addEventListener('click', () => this.camera.go_home());
    this.#layer.addEventListener('keydown', ({ code }) => {
      if (code === 'KeyG') this.#part('walls').click();
    });
    addEventListener('pagehide', () => this.close());
  }

  // `source`: {scene, camera, width, height}; without a camera it is the scene's. Throws when the
  // server or this browser cannot.
  async open({ scene, camera, width, height }) {
    const { view } = this.#address;
    this.main = this.#new_session('left', () => this.#on_frame(), (error) => this.#say(error
      ? `The live view is lost: ${error.message}.` : 'The live view has ended.', true));
    const main = this.main;
    if (!main.supported) throw new Error('This browser has no WebGL2, which it needs.');
    const size = size_of({ width, height });
    const info = await main.open({ scene, ...size, ...this.#switches(), frame_ms: kFrameMs,
      ...(camera && { camera }) });
    if (main !== this.main) return;
    this.#given = { off: view.off, dark: '', beside: '', live: 'on' };
    // In a picture of all directions one looks around.
    const around = info.camera.projection === 'equirectangular';
    this.#base = around ? { ...info.camera, projection: 'perspective', vertical_fov_deg: 75 }
      : info.camera;
    this.camera.mode = this.#part('move').value = around ? 'fly' : 'orbit';
    this.camera.forget();
    this.camera.camera = this.#base;
    this.#first = around ? main.look(this.#base) : 0;
    main.on_stop = (position) => this.camera.stop_at(position);
    this.#show_walls();
    this.#show_cameras();
    this.#show_lights(info.lights);
    this.follow();
    const pulled = this.#pulled.splice(0, 2, 0, 0);
    if (pulled.some((v) => v !== 0)) this.drag(...pulled);
  }

  close() {
    clearTimeout(this.#rest_timer);
    for (const name of ['main', 'other']) {
      this[name]?.close();
      this[name] = null;
    }
    this.#pulled = [0, 0];
    this.#layer.hidden = true;
    this.#part('label').textContent = '';
    this.mix = '';
  }

  // By pixels; before there is a session they are kept for it.
  drag(dx, dy) {
    if (this.main?.info) this.camera.drag([dx, dy]);
    else this.#pulled = [this.#pulled[0] + dx, this.#pulled[1] + dy];
  }

  // The address changed.
  follow() {
    const { view } = this.#address;
    this.#layer.style.setProperty('--split', `${view.split}%`);
    for (const session of [this.main, this.other]) if (session) session.look_of = view;
    if (!this.main?.info) return;
    const old = this.#given;
    this.#given = { off: view.off, dark: view.dark, beside: view.beside, live: view.live };
    if (view.live !== old.live) this.#go_to(view.live);
    if (view.off !== old.off) this.#put('switches');
    if (view.dark !== old.dark) this.#put('lights');
    if (view.beside !== old.beside) this.#compare();
    this.#show_boxes('switches', view.off);
    this.#show_boxes('lights', view.dark);
    this.#label();
  }

  #go_to(text) {
    const camera = with_text(this.#base, text) ?? this.#base;
    this.camera.camera = camera;
    const number = this.main.look(camera);
    this.other?.look(camera);
    if (this.#layer.hidden) this.#first = number;
  }

  // It moved.
  #look() {
    if (!this.main?.info) return;
    const { camera } = this.camera;
    this.main.look(camera);
    this.other?.look(camera);
    clearTimeout(this.#rest_timer);
    this.#rest_timer = setTimeout(() => {
      this.#given.live = camera_text(this.camera.camera);
      this.#address.set({ live: this.#given.live });
    }, kRestMs);
  }

  // What was there stays until the first frame of what is asked for.
  #on_frame() {
    if (this.#layer.hidden && this.main.frame.camera >= this.#first) {
      this.#layer.hidden = false;
      this.#say('');
    }
    this.#label();
  }

  #label() {
    const off = parts_of(this.#address.view.off);
    const stage = this.main?.frame ? kStageWords[this.main.frame.stage] : '';
    const text = stage + (off.length ? `, without ${off.join(', ')}` : '');
    if (this.#part('label').textContent !== text) this.#part('label').textContent = text;
  }

  #new_session(name, on_frame, on_end) {
    return new LiveSession(this.#part(name), on_frame, on_end);
  }

  // What a session does; `without`: 'all', or one of them that it does not do either.
  #switches(without = '') {
    const off = parts_of(this.#address.view.off);
    return Object.fromEntries(kSwitches.map((name) =>
      [name, !off.includes(name) && without !== 'all' && without !== name]));
  }
  #factors() {
    const dark = parts_of(this.#address.view.dark);
    return this.main.info.lights.map((_, index) => (dark.includes(String(index)) ? 0 : 1));
  }

  async #put(what) {
    const main = this.main;
    try {
      if (what === 'switches') {
        this.other?.put(what, this.#switches(this.#address.view.beside)).catch(() => {});
        await main.put(what, this.#switches());
        return;
      }
      const factors = this.#factors();
      this.other?.put(what, { factors }).catch(() => {});
      const info = await main.put(what, { factors });
      if (main !== this.main) return;
      this.mix = info.factors.some((factor) => factor !== 1) ? info.mix : '';
      if (!info.mix) {
        this.#say('This scene has more lights than a job can keep apart: a job of this view has ' +
          'them all.');
      }
    } catch (error) {
      this.#say(error.message);
    }
  }

  // A second session beside the first, without what is compared.
  async #compare() {
    const { beside } = this.#address.view;
    this.other?.close();
    this.other = null;
    for (const name of ['right', 'other-label', 'split-tool', 'second']) {
      this.#part(name).hidden = !beside;
    }
    this.#layer.classList.toggle('split', Boolean(beside));
    if (!beside) return;
    this.#part('other-label').textContent = `without ${beside === 'all' ? 'any of them' : beside}`;
    const { scene, width, height } = this.main.info;
    const other = this.#new_session('right', () => {}, () => {});
    this.other = other;
    other.look_of = this.#address.view;
    try {
      await other.open({ scene, width, height, ...this.#switches(beside), frame_ms: kFrameMs });
      if (other !== this.other) return;
      other.look(this.camera.camera);
      await other.put('lights', { factors: this.#factors() });
    } catch (error) {
      if (other !== this.other) return;
      this.#say(`There is no second view: ${error.message}`);
      this.#address.set({ beside: '' });
    }
  }

  #show_walls() {
    if (this.main) this.main.walls = this.#part('walls').checked;
  }

  // Those that the scene names, and those that were kept.
  #show_cameras(chosen = '') {
    const { scene, cameras } = this.main.info;
    const own = kept_cameras(scene);
    this.#part('camera-tool').hidden = cameras.length + own.length === 0;
    const groups = [['The scene\u2019s', cameras.map(({ name }, index) => [name, index])],
      ['Kept', own]].filter(([, options]) => options.length).map(([label, options]) => {
      const group = Object.assign(document.createElement('optgroup'), { label });
      group.append(...options.map(([name, value]) => new Option(name, value)));
      return group;
    });
    this.#part('camera').replaceChildren(new Option('choose one', ''), ...groups);
    this.#part('camera').value = chosen;
    this.#part('forget').hidden = !chosen.includes(',');
  }
  #choose_camera() {
    const { value } = this.#part('camera');
    const is_own = value.includes(',');
    this.#part('forget').hidden = !is_own;
    if (!value || !this.main?.info) return;
    const camera = is_own ? with_text(this.#base, value) : this.main.info.cameras[value].camera;
    if (camera) this.camera.go_to(camera);
  }
  #keep_camera() {
    if (!this.main?.info) return;
    const { scene } = this.main.info;
    const name = prompt('What is this camera called?', `View ${kept_cameras(scene).length + 1}`);
    if (!name?.trim()) return;
    const text = camera_text(this.camera.camera);
    keep_camera(scene, name.trim(), text);
    this.#show_cameras(text);
  }

  #show_lights(names) {
    const labels = names.map((name, index) => {
      const label = document.createElement('label');
      label.append(Object.assign(document.createElement('input'),
        { type: 'checkbox', value: index, checked: true }), ` ${name}`);
      return label;
    });
    this.#part('lights').hidden = !names.length;
    this.#part('lights').replaceChildren(this.#part('lights').querySelector('legend'), ...labels);
  }

  // What is not checked stands in the address.
  #set_off(boxes, member) {
    this.#address.set({ [member]: [...this.#part(boxes).querySelectorAll('input')]
      .filter(({ checked }) => !checked).map(({ value }) => value).join() });
  }
  #show_boxes(boxes, off) {
    for (const box of this.#part(boxes).querySelectorAll('input')) {
      box.checked = !parts_of(off).includes(box.value);
    }
  }

  #part(name) {
    return this.#root.querySelector(`.live-${name}`);
  }
}
