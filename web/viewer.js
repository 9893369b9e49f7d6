// The stage and a panel for each job: one picture, two with a divider, in a row, one at a time or
// as a map of how they differ, or three in a row.
import { get_map, get_view } from './api.js';
import { Bias, picture_age } from './bias.js';
import { has_ended, is_recovered, method_words, samples_words, seconds,
  state_words } from './format.js';
import { JobPanel } from './job_panel.js';
import { Picture } from './picture.js';
import { title_of } from './scene_library.js';
import { frame_of, in_order, moments_of, pictures_of, side_words } from './shown_pictures.js';
import { StagePlace } from './stage_place.js';
import { StageTools } from './stage_tools.js';

const kUnknownSize = { width: 4, height: 3 }; // the stage before the scene is loaded
const kSides = ['left', 'right', 'third'];
const kOverlayWords = { state: 'states', gain: 'gain of guiding',
  beta: 'share of guided directions', samples: 'samples a pixel', noise: 'variance' };
const kMaps = { signed: 'signed', 'flip-map': 'flip' };

export class Viewer extends EventTarget {
  #root;
  #store;
  #job_moments;
  #address;
  #tools;
  #pictures; // left, right, third
  #panels; // of the one job or the two
  #place;
  #problem = '';
  #hovered = null; // {job, number}: a moment that the pointer is on in the chart
  #bias = new Bias(() => this.update());

  constructor(root, templates, store, job_moments, address, on_duplicate) {
    super();
    this.#root = root;
    this.#store = store;
    this.#job_moments = job_moments;
    this.#address = address;
    this.#pictures = kSides.map((side) => this.#new_picture(templates.pane, side));
    this.#panels = [0, 1].map(() => new JobPanel(templates.panel, store,
      (...of) => address.link(...of), on_duplicate));
    this.#part('panels').append(...this.#panels.map((panel) => panel.root));
    this.#tools = new StageTools(root, store, address);
    this.#place = new StagePlace(this.#part('stage'), {
      on_place: (place) => this.#show_place(place),
      on_settled: (place) => this.#keep_place(place),
      on_click: (x, y) => this.inspect(this.#pixel_at(x, y)),
      on_hover: (x, y) => this.dispatchEvent(new CustomEvent('hover', {
        detail: x === null ? null : this.#pixel_at(x, y) })),
      on_pull: (delta) => this.dispatchEvent(new CustomEvent('pull', { detail: delta })),
    });
    this.#part('flip').addEventListener('click', () => this.flip());
    for (const [name, act] of [['zoom-in', () => this.zoom_by(2)],
      ['zoom-out', () => this.zoom_by(0.5)], ['fit', () => this.#place.zoom_to(1)],
      ['one-to-one', () => this.one_to_one()]]) {
      this.#part(name).addEventListener('click', act);
    }
    this.#part('no-webgl').hidden = this.#pictures[0].supported;
    this.#restore_place();
  }

  get pictures() {
    return this.#pictures;
  }
  // The ids, in the order of the address.
  get shown_jobs() {
    const { job, with: other } = this.#address.view;
    return [job, other].filter((id) => id && this.#pictures.some(({ job_id }) => job_id === id));
  }
  // How several pictures lie: 'row', or one over the other with the divider at `split` per cent.
  get arrangement() {
    return this.#root.classList.contains('row') ? 'row' : 'over';
  }
  get split() {
    return this.#address.view.split;
  }
  method_of(job_id) {
    return this.#store.get(job_id).request.method;
  }
  // The moment that a job is shown at, or null.
  moment_of(job_id) {
    return this.#pictures.find((picture) => picture.job_id === job_id)?.moment ?? null;
  }

  // The address changed from `old`; update() comes next.
  follow(old) {
    const { view } = this.#address;
    if (old.job !== view.job || old.with !== view.with) this.#problem = '';
    if (['zoom', 'cx', 'cy', 'job'].some((name) => old[name] !== view[name])) {
      this.#restore_place();
    }
  }

  // {job, factors}: what its groups of lights are mixed by; null: as they are.
  set mix(mix) {
    for (const picture of this.#pictures) {
      picture.mix = mix && picture.job_id === mix.job ? mix.factors : null;
    }
  }

  // The frame that a job is shown at.
  frame_of(job_id) {
    return this.#pictures.find((picture) => picture.job_id === job_id)?.frame ?? 0;
  }

  // A hint that the job's film has tiles up to `newest`; `frame`: of which frame, null: of any.
  pull(job_id, newest = null, frame = null) {
    for (const picture of this.pictures) {
      if (picture.job_id === job_id && (frame === null || frame === picture.frame)) {
        picture.pull(newest);
      }
    }
  }

  restart() {
    this.pictures.forEach((picture) => picture.restart());
  }

  // Shows a moment of a job while the pointer is on it; null: as the address has it again.
  hover_moment(hovered) {
    if (this.#hovered?.job === hovered?.job && this.#hovered?.number === hovered?.number) return;
    this.#hovered = hovered;
    this.update();
  }

  flip() {
    const { view } = this.#address;
    if (!view.with) return;
    const side = view.mode === 'flip' && view.side === 'right' ? 'left' : 'right';
    this.#address.set({ mode: 'flip', side });
  }

  zoom_by(factor) {
    this.#place.zoom_by(factor);
  }
  fit() {
    this.#place.zoom_to(1);
  }
  one_to_one() {
    this.#place.zoom_to(this.#place.one_to_one(this.#pictures[0].width || 1));
  }

  // The pixels of the first picture that are seen, as a job's region; null: all of them.
  get seen_part() {
    const { width, height } = this.#size();
    const { zoom, x, y } = this.#place.place;
    if (!width || zoom === 1) return null;
    const span = (centre, size) => {
      const first = Math.max(0, Math.floor((centre - 0.5 / zoom) * size));
      return [first, Math.min(size, Math.ceil((centre + 0.5 / zoom) * size)) - first];
    };
    const [[left, wide], [top, high]] = [span(x, width), span(y, height)];
    return { x: left, y: top, width: wide, height: high };
  }

  // `pixel`: [x, y] of the first picture, or null.
  inspect(pixel) {
    const { width, height } = this.#size();
    if (pixel && width) {
      const [x, y] = [[pixel[0], width], [pixel[1], height]]
        .map(([v, size]) => Math.min(Math.max(v, 0), size - 1));
      this.#address.set({ at: [x, y] });
      this.#place.reveal((x + 0.5) / width, (y + 0.5) / height);
    } else {
      this.#address.set({ at: null });
    }
  }

  update() {
    this.#tools.update();
    const { job: job_id, with: with_id, scene } = this.#address.view;
    const ids = [job_id, with_id].filter((id) => id !== null);
    const jobs = ids.map((id) => this.#store.get(id));
    const missing = ids.find((id) => this.#store.is_missing(id));
    this.#part('missing').hidden = !missing;
    this.#part('missing').textContent = missing ? `There is no job ${missing}.` : '';
    const is_scene = job_id === null && scene !== null; // live, without a job
    this.#part('empty').hidden = job_id !== null || is_scene;
    const known = jobs.length > 0 && jobs.every((job) => job);
    this.#root.classList.toggle('has-picture', known || is_scene);
    this.#root.classList.toggle('live-only', is_scene);
    if (is_scene) this.#part('title').textContent = title_of(scene);
    if (known) this.#show(jobs);
    else this.pictures.forEach((picture) => picture.show(null));
    this.dispatchEvent(new Event('update'));
  }

  #new_picture(template, side) {
    const root = template.content.firstElementChild.cloneNode(true);
    root.classList.add(side);
    root.querySelector('.half-label').classList.add(`view-${side}-label`);
    root.querySelector('canvas.picture').setAttribute('aria-label',
      { left: 'The picture so far', right: 'The picture of the second job so far',
        third: 'The third picture so far' }[side]);
    this.#part('divider').before(root);
    return new Picture(root, (problem) => {
      this.#problem = problem;
      this.update();
    });
  }

  #show(jobs) {
    const { view } = this.#address;
    const ordered = in_order(jobs);
    const views = pictures_of(ordered);
    const mode = views.length === 2 ? view.mode : views.length === 3 ? 'row' : 'split';
    const moments = moments_of(jobs, view, this.#job_moments, this.#hovered);
    this.#bias.follow(ordered, moments);
    this.#pictures.forEach((picture, index) => {
      const shown = views[index] ?? null;
      picture.show(shown?.job.id ?? null, shown?.which, moments.get(shown?.job.id) ?? null,
        frame_of(shown?.job, view));
      picture.look = view;
    });
    const is_map = mode in kMaps;
    this.#pictures.forEach((picture, index) => {
      const shown = views[index] ?? null;
      const labelled = !is_map && (views.length > 1 || picture.moment !== null);
      const bias = shown ? this.#bias.words(shown.job, ordered) : '';
      this.#label(index, labelled ? shown : null, bias);
      picture.root.classList.toggle('behind', (mode === 'flip' && index < 2 &&
        kSides[index] !== view.side) || (is_map && index === 1));
      this.#show_overlay(picture, index, shown, is_map ? { kind: kMaps[mode], ordered } : null);
      picture.marks.at = shown ? this.pixel_in(picture, view.at) : null;
    });
    this.#panels.forEach((panel, index) => {
      const job = ordered[index] ?? null;
      panel.root.hidden = !job;
      if (!job) return;
      panel.side = ordered.length > 1 ? side_words(views, job) : '';
      panel.look = { ev: view.ev, moment: moments.get(job.id) ?? null,
        frame: frame_of(job, view), mix: job.id === view.job ? view.mix : '' };
      panel.bias = this.#bias.words(job, ordered, true);
      // Without WebGL2 no tiles are fetched; the server has a picture from the first sample on.
      const has_tiles = this.#pictures.some((p) => p.job_id === job.id && p.has_picture);
      panel.update(job, has_tiles || job.progress.samples > 0);
    });
    this.#part('title').textContent = ordered.map((job) => title_of(job.request.scene))
      .filter((name, i, all) => all.indexOf(name) === i).join(' | ');
    const { classList } = this.#root;
    classList.toggle('two-jobs', ordered.length > 1);
    classList.toggle('split', views.length === 2 && mode === 'split');
    classList.toggle('row', mode === 'row');
    classList.toggle('three', views.length === 3);
    classList.toggle('map', is_map);
    this.#part('divider').hidden = views.length !== 2 || mode !== 'split';
    this.#part('divider').setAttribute('aria-valuetext', `${Math.round(view.split)} % left`);
    for (const part of ['mode-tool', 'equal-tool']) this.#part(part).hidden = views.length !== 2;
    this.#show_stage(ordered);
    this.#tools.show(this.#pictures);
  }

  #show_stage(jobs) {
    const stage = this.#part('stage');
    const size = this.#size(jobs[0]);
    const frame = stage.parentElement;
    frame.style.setProperty('--w', size.width || kUnknownSize.width);
    frame.style.setProperty('--h', size.height || kUnknownSize.height);
    stage.style.setProperty('--split', `${this.#address.view.split}%`);
    if (size.width) this.#place.picture_width = size.width;
    this.#show_zoom(this.#place.place);
    const waiting = this.#pictures[0].supported && !this.pictures.some((p) => p.has_picture);
    this.#part('waiting').hidden = !waiting;
    this.#part('waiting').textContent = jobs.every(has_ended)
      ? 'No picture was made.' : `${state_words(jobs.at(-1).state)} …`;
    this.#part('problem').hidden = !this.#problem;
    this.#part('problem').textContent = this.#problem;
  }

  // In pixels, of the first picture; a job's request knows it before a tile came.
  #size(job = this.#store.get(this.#address.view.job)) {
    const [picture] = this.#pictures;
    return picture.width ? picture : job?.request ?? picture;
  }

  #label(index, view, bias) {
    const label = this.#part(`${kSides[index]}-label`);
    label.hidden = !view;
    if (!view) return;
    const { job, which } = view;
    const words = [method_words(job.request.method)];
    if (is_recovered(job)) words.push(which === 'recovered' ? 'recovered' : 'its samples');
    const picture = this.#pictures[index];
    if (!picture.has_picture) words.push(state_words(job.state));
    const moment = this.#job_moments.of(job.id).moments.find((m) => m.number === picture.moment);
    if (moment) words.push(samples_words(moment.samples), seconds(moment.seconds));
    if (bias) words.push(`biased: ${bias}`);
    const text = words.join(' · ');
    if (label.textContent !== text) label.textContent = text;
  }

  #show_overlay(picture, index, shown, map) {
    const { overlay } = picture;
    const { view } = this.#address;
    if (map) {
      const [b, a] = map.ordered;
      const values = { a: a.id, b: b.id, map: map.kind, a_moment: this.moment_of(a.id),
        b_moment: this.moment_of(b.id) };
      const ages = [a, b].map((job) => picture_age(job, this.moment_of(job.id)));
      const key = JSON.stringify([values, ...ages]);
      overlay.show(index === 0 ? key : '', (signal) => get_map(values, signal), map.kind === 'flip'
        ? 'Map of the differences that an eye sees (FLIP)'
        : 'Map of where the right picture is brighter or darker than the left one');
    } else if (view.overlay && shown) {
      const { id } = shown.job;
      const { moment, frame } = picture;
      const key = JSON.stringify([id, view.overlay, picture_age(shown.job, moment), frame]);
      overlay.show(key, (signal) => get_view(id, view.overlay, { moment, frame }, signal),
        `Over the picture: ${kOverlayWords[view.overlay]}`);
    } else {
      overlay.show('');
    }
  }

  #show_place(place) {
    for (const picture of this.#pictures) picture.place = place;
    this.#show_zoom(place);
  }

  // 100 %: a pixel of the picture is one of the screen.
  #show_zoom({ zoom }) {
    const { width } = this.#pictures[0];
    const percent = width ? 100 * zoom / this.#place.one_to_one(width) : 100;
    this.#part('zoom-value').value = `${Math.round(percent)}\u00a0%`;
  }

  #restore_place() {
    const { zoom, cx, cy } = this.#address.view;
    // Shares of the picture; the address has them in parts of ten thousand.
    this.#place.restore({ zoom, x: cx === null ? 0.5 : cx / 1e4, y: cy === null ? 0.5 : cy / 1e4 });
  }

  #keep_place({ zoom, x, y }) {
    const part = (v) => (zoom === 1 ? null : Math.round(1e4 * v * 10) / 10);
    this.#address.set({ zoom: Math.round(zoom * 1000) / 1000, cx: part(x), cy: part(y) });
  }

  #pixel_at(x, y) {
    const { width, height } = this.#size();
    return [Math.floor(x * width), Math.floor(y * height)];
  }

  // The same place in a picture of another size.
  pixel_in(picture, at) {
    const { width, height } = this.#size();
    if (!at || !picture.width || !width) return at;
    return [Math.floor((at[0] + 0.5) * picture.width / width),
      Math.floor((at[1] + 0.5) * picture.height / height)];
  }

  #part(name) {
    return this.#root.querySelector(`.view-${name}`);
  }
}
