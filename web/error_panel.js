// Error against time of the shown jobs, in a chart, in words and in a row of moments: each finished
// pass is one. The pointer over the chart shows the picture of that moment, a click keeps it; the
// slider does the same by keyboard.
import { method_words, samples_words, seconds, significant } from './format.js';
import { ErrorChart } from './error_chart.js';
import { nearest, with_picture } from './moments.js';
import { show_options } from './view_controls.js';

export class ErrorPanel {
  #root;
  #viewer;
  #store;
  #job_moments;
  #address;
  #chart;

  constructor(root, viewer, store, job_moments, address) {
    this.#root = root;
    this.#viewer = viewer;
    this.#store = store;
    this.#job_moments = job_moments;
    this.#address = address;
    this.#chart = new ErrorChart(this.#part('chart'),
      (line, x) => viewer.hover_moment(x === null ? null : this.#moment_at(line, x)),
      (line, x) => this.#pin(this.#moment_at(line, x)));
    this.#part('chart').addEventListener('pointerleave', () => viewer.hover_moment(null));
    this.#part('moment').addEventListener('input', () => {
      const moments = this.#pictured();
      const index = this.#part('moment').valueAsNumber;
      address.set({ moment: moments[index]?.number ?? null });
    });
    this.#part('newest').addEventListener('click', () => address.set({ moment: null }));
    this.#part('ref').addEventListener('change', ({ target }) =>
      address.set({ ref: target.value || null }));
    this.#part('files').addEventListener('click', ({ target }) =>
      target.dataset.file && this.#save(target.dataset.file));
    matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => this.update());
    viewer.addEventListener('update', () => this.update());
  }

  // One moment on: -1 or 1.
  step(by) {
    const moments = this.#pictured();
    const { moment } = this.#address.view;
    const at = moment === null ? moments.length : moments.findIndex((m) => m.number === moment);
    const next = Math.max(0, at + by);
    if (moments.length) this.#address.set({ moment: moments[next]?.number ?? null });
  }

  async update() {
    const { view } = this.#address;
    const jobs = this.#viewer.shown_jobs;
    this.#job_moments.follow(jobs, view.ref);
    if (!jobs.length) return;
    this.#list_references(jobs);
    this.#show_moments();
    const lines = jobs.map((id) => this.#line(id));
    const problem = jobs.map((id) => this.#job_moments.of(id).problem).find(Boolean) ?? '';
    this.#part('problem').hidden = !problem;
    this.#part('problem').textContent = problem;
    this.#part('words').replaceChildren(...jobs.map((id) => this.#words(id)));
    this.#part('files').hidden = lines.every(({ points }) => !points.length);
    const drawn = await this.#chart.show(lines, ...this.#labels(view.axis, view.ref));
    this.#part('no-chart').hidden = drawn;
    this.#part('chart').hidden = !drawn || lines.every(({ points }) => !points.length);
  }

  // The chart as a file of this kind: every moment that is known, or the curves as they are drawn.
  async #save(kind) {
    const { chart_svg, csv, save } = await import('./chart_files.js');
    const { axis, ref } = this.#address.view;
    const jobs = this.#viewer.shown_jobs;
    const rows = jobs.flatMap((job) => this.#job_moments.of(job).moments
      .map(({ number, samples, seconds: s, noise, relmse, learning, guided }) => ({ job,
        method: this.#store.get(job).request.method, pass: number, samples, seconds: s, noise,
        relmse: relmse ?? null, learning, guided })));
    const text = {
      csv: () => csv(Object.keys(rows[0] ?? {}), rows),
      json: () => JSON.stringify({ jobs, reference: ref, passes: rows }, null, 1),
      svg: () => chart_svg(jobs.map((id) => this.#line(id)), ...this.#labels(axis, ref),
        `Error of ${jobs.join(' and ')}`),
    }[kind]();
    save(`errors-${jobs.join('-')}.${kind}`, text);
  }

  #labels(axis, ref) {
    return [axis === 'seconds' ? 'seconds of rendering' : 'samples a pixel',
      ref ? `relMSE against ${ref}` : 'relative error (estimate)'];
  }

  #measure(moment) {
    return this.#address.view.ref ? moment.relmse : moment.noise;
  }

  #line(id) {
    const { axis } = this.#address.view;
    const { moments } = this.#job_moments.of(id);
    const points = moments.map((moment) => [moment[axis], this.#measure(moment)])
      .filter(([x, y]) => x > 0 && y > 0);
    const marks = this.#marks(id, moments).map(({ moment, text }) => ({ x: moment[axis], text }));
    return { label: `${id} ${this.#method(id)}`, points, marks };
  }

  // Where learning ended, where the guide began to draw directions, and what it gained at last.
  #marks(id, moments) {
    const marks = [];
    const taught = moments.findLast(({ learning }) => learning);
    if (taught && moments.at(-1) !== taught) marks.push({ moment: taught, text: 'learning ends' });
    const guided = moments.find((moment) => moment.guided);
    const known = moments.findLast((moment) => moment.efficiency_gain > 0);
    if (guided) {
      const words = known ? `guided, gain ${significant(known.efficiency_gain, 2)}` : 'guided';
      marks.push({ moment: guided, text: words });
    }
    const { gate } = this.#job_moments.of(id);
    if (gate && gate !== 'on' && known) marks.push({ moment: known, text: 'guiding stopped' });
    return marks;
  }

  #words(id) {
    const { moments, gate } = this.#job_moments.of(id);
    const line = document.createElement('li');
    const measured = moments.filter((moment) => this.#measure(moment) > 0);
    const say = [];
    if (measured.length) {
      const tell = (moment) => `${significant(this.#measure(moment))} after ` +
        `${samples_words(moment.samples)}, ${seconds(moment.seconds)}`;
      say.push(`${measured.length > 1 ? `${tell(measured[0])}; ` : ''}${tell(measured.at(-1))}`);
    } else {
      const { frames } = this.#store.get(id)?.request ?? {};
      say.push(moments.length ? 'no error is known of its passes'
        : frames ? 'passes of many frames are not kept' : 'no finished pass yet');
    }
    for (const { moment, text } of this.#marks(id, moments)) {
      if (text === 'guiding stopped') continue; // below, with its reason
      say.push(`${text} at ${samples_words(moment.samples)}`);
    }
    if (gate) say.push(gate === 'on' ? 'guiding pays' : `guiding stopped: ${gate.slice(5)}`);
    line.textContent = `${id}, ${this.#method(id)}: ${say.join('; ')}.`;
    return line;
  }

  #method(id) {
    return method_words(this.#store.get(id).request.method);
  }

  #list_references(jobs) {
    const { ref } = this.#address.view;
    const first = this.#store.get(jobs[0]).request;
    const fit = this.#store.choices(({ id, request, progress }) => id === ref ||
      (!jobs.includes(id) && progress.samples > 0 && request.scene === first.scene &&
        request.width === first.width && request.height === first.height));
    const words = ({ id, request, progress }) =>
      `${id}: ${method_words(request.method)}, ${samples_words(progress.samples)}`;
    show_options(this.#part('ref'),
      [['', 'its own estimate'], ...fit.map((job) => [job.id, words(job)])], ref ?? '');
  }

  #pictured() {
    return with_picture(this.#job_moments.of(this.#address.view.job).moments);
  }

  #show_moments() {
    const { job, moment } = this.#address.view;
    const moments = this.#pictured();
    const shown = this.#viewer.moment_of(job) ?? moment;
    const at = moments.findIndex(({ number }) => number === shown);
    const slider = this.#part('moment');
    this.#part('moments').hidden = moments.length < 2;
    slider.max = moments.length;
    slider.value = at < 0 ? moments.length : at;
    const words = at < 0 ? 'newest' : `pass ${moments[at].number}: ` +
      `${samples_words(moments[at].samples)}, ${seconds(moments[at].seconds)}`;
    this.#part('moment-words').value = words;
    slider.setAttribute('aria-valuetext', words);
    this.#part('newest').hidden = moment === null;
  }

  #moment_at(line, x) {
    const id = this.#viewer.shown_jobs[line];
    const { moments } = this.#job_moments.of(id);
    const found = nearest(with_picture(moments), this.#address.view.axis, x);
    return found && { job: id, number: found.number };
  }

  // A moment of the second job is kept as that of the first that belongs to it.
  #pin(picked) {
    if (!picked) return;
    const { job, axis, equal } = this.#address.view;
    const by = equal || axis;
    const moment = this.#job_moments.of(picked.job).moments.find((m) => m.number === picked.number);
    const own = picked.job === job ? moment : nearest(this.#pictured(), by, moment[by]);
    if (own) this.#address.set({ moment: own.number });
  }

  #part(name) {
    return this.#root.querySelector(`.error-${name}`);
  }
}
