// One selected job under its picture: state in words, progress, what it was asked,
// which table it used and made, what it cost; pause, cancel and downloads.
import { ApiError, act_on_job, exr_url, png_url } from './api.js';
import { badge_word, big, bytes, can_cancel, count, exact,
  frames_words, has_ended, is_biased, is_recovered,
  method_words, pause_or_resume, progress_words, samples_words, seconds,
  state_words, why_words } from './format.js';
import { title_of } from './scene_library.js';

const kPixelsWords = {
  quarter: 'a quarter, the rest is not sampled',
  'by-noise': 'a quarter, more samples where they scatter',
};

export class JobPanel {
  #root;
  #store;
  #link_to;
  #job = null;
  #look = { ev: 0, moment: null, frame: 0 };
  #bias = '';
  #pause = ''; // what its button does

  constructor(template, store, link_to, on_duplicate) {
    this.#root = template.content.firstElementChild.cloneNode(true);
    this.#store = store;
    this.#link_to = link_to;
    this.#part('cancel').addEventListener('click', () => this.#act('cancel', 'cancel'));
    this.#part('pause').addEventListener('click', () => this.#act('pause', this.#pause));
    this.#part('duplicate').addEventListener('click', () => on_duplicate(this.#job));
  }

  get root() {
    return this.#root;
  }

  set side(words) {
    this.#part('side').textContent = words;
    this.#part('side').hidden = !words;
  }

  // What downloads follow: {ev, moment, frame, mix}.
  set look(value) {
    this.#look = value;
  }
  // How far off its picture is, in words.
  set bias(words) {
    this.#bias = words;
  }

  // `has_picture`: at least one tile came.
  update(job, has_picture) {
    this.#job = job;
    this.#root.dataset.state = job.state;
    this.#root.dataset.job = job.id;
    this.#set('title', `${title_of(job.request.scene)}, ${method_words(job.request.method)}`);
    this.#mark(job);
    this.#set('state-words', state_words(job.state));
    this.#set('numbers', progress_words(job));
    this.#set('why', why_words(job));
    this.#part('why').hidden = !this.#part('why').textContent;
    const bar = this.#part('bar');
    bar.hidden = has_ended(job);
    if (job.state === 'preparing' && job.loading) bar.value = job.loading.fraction;
    else if (job.progress.fraction > 0) bar.value = job.progress.fraction;
    else bar.removeAttribute('value');
    this.#part('error').hidden = !job.error;
    this.#set('error-message', job.error?.message ?? '');
    this.#set('error-where', job.error?.where ?? '');
    this.#part('cancel').hidden = !can_cancel(job);
    this.#pause = pause_or_resume(job);
    this.#part('pause').hidden = !this.#pause;
    this.#set('pause', this.#pause === 'resume' ? 'Resume' : 'Pause');
    this.#part('exr').hidden = this.#part('png').hidden = !has_picture;
    this.#part('samples').hidden = !has_picture || !is_recovered(job);
    this.#link_downloads();
    this.#show_facts(job);
  }

  // Why the picture is not, or not only, what the samples say.
  #mark(job) {
    const recovered = is_recovered(job);
    this.#part('badge').hidden = !badge_word(job);
    this.#set('badge', badge_word(job));
    this.#part('bias-note').hidden = !is_biased(job);
    this.#set('bias-words', this.#bias && `Here it is ${this.#bias}.`);
    this.#part('recovered-note').hidden = !recovered;
  }

  #link_downloads() {
    const { id, request } = this.#job;
    const best = is_recovered(this.#job) ? 'recovered' : 'sampled';
    const { ev, moment, frame, mix } = this.#look;
    this.#part('exr').href = exr_url(id, best, frame, mix);
    this.#part('png').href = png_url(id, best, ev, moment, frame, mix);
    this.#part('samples').href = exr_url(id, 'sampled', frame);
    this.#part('bench').href = this.#link_to(id, null, { page: 'bench' });
    this.#part('around').hidden = request.width !== 2 * request.height;
    this.#part('around').href = `live_around.html#${id},${this.#look.ev}`;
  }

  async #act(part, action) {
    const button = this.#part(part);
    button.disabled = true;
    try {
      this.#store.put(await act_on_job(this.#job.id, action));
    } catch (error) {
      if (!(error instanceof ApiError)) throw error;
      await this.#store.refresh(this.#job.id); // 409: it ended by itself
    }
    button.disabled = false;
  }

  #show_facts(job) {
    const { request } = job;
    const facts = [['Job', job.id], ['Method', this.#method(request)],
      ['Size', this.#size(request)], ['Asked for', this.#budget(request)],
      ['Seed', exact(request.seed)]];
    if (request.frames) facts.push(['Frames', frames_words(request.frames)]);
    if (request.pixels !== 'all') facts.push(['Pixels', kPixelsWords[request.pixels]]);
    if (request.region) facts.push(['First', this.#region(request.region)]);
    if (request.recover !== 'none') facts.push(['Recovery', this.#recovery(job)]);
    if (request.method !== 'none') {
      facts.push(['Table used', this.#table_used(job)], ['Table made', this.#table_made(job)]);
    }
    const labels = Object.entries(request.labels ?? {}).map((label) => label.join(': '));
    if (labels.length) facts.push(['Labels', labels.join(', ')]);
    if (request.priority) facts.push(['Priority', String(request.priority)]);
    const { stats } = job;
    if (stats?.rays_per_second) facts.push(['Speed', `${big(stats.rays_per_second)} rays/s`]);
    if (stats?.dropped_samples) facts.push(['Dropped samples', count(stats.dropped_samples)]);
    for (const warning of job.warnings ?? []) facts.push(['Warning', warning]);
    const list = this.#part('facts');
    const key = JSON.stringify(facts.map(([name, value]) => [name, value.outerHTML ?? value]));
    if (list.dataset.key === key) return; // keep focus inside the list
    list.dataset.key = key;
    list.replaceChildren(...facts.map(([name, value]) => {
      const row = document.createElement('div');
      const term = document.createElement('dt');
      const detail = document.createElement('dd');
      term.textContent = name;
      detail.append(value);
      row.append(term, detail);
      return row;
    }));
  }

  // Both stay unknown until the scene is loaded, where the request leaves them to it.
  #size(request) {
    if (!request.width || !request.height) return "the scene's own";
    return `${request.width} × ${request.height}`;
  }

  #region({ x = 0, y = 0, width, height }) {
    return `${width} × ${height} pixels, ${x} from the left and ${y} from the top`;
  }

  #recovery({ request, stats }) {
    if (!stats?.recovery) return `${request.recover}, when it is done`;
    return `${stats.recovery}, ${(stats.recovery_seconds * 1000).toFixed(0)}\u00a0ms`;
  }

  #budget(request) {
    return request.samples ? `${samples_words(request.samples)} a pixel` : seconds(request.seconds);
  }

  #method(request) {
    const nee = request.nee ? 'with' : 'without';
    return `${method_words(request.method)}, ${nee} direct light sampling`;
  }

  #table_used(job) {
    if (job.table_in) return this.#table_words(job.table_in);
    if (job.request.table === 'none') return 'none, as asked';
    if (['queued', 'preparing'].includes(job.state)) return 'not chosen yet';
    return has_ended(job) && job.progress.samples === 0 ? 'none' : 'none fits: started cold';
  }

  #table_made(job) {
    if (job.table_out) return this.#table_words(job.table_out);
    if (job.request.table === 'none') return 'not kept, as asked';
    return has_ended(job) ? 'none' : 'when it is done';
  }

  // "3f2a91c0 · 8,123 states · 1.6 MiB · by j000001"
  #table_words(id) {
    const words = document.createElement('span');
    words.title = id;
    const table = this.#store.table(id);
    const short = document.createElement('code');
    short.textContent = id.slice(0, 8);
    words.append(short);
    if (!table) return words;
    words.append(` · ${count(table.states)} states · ${bytes(table.bytes)}`);
    if (table.job && table.job !== this.#job.id) {
      const link = document.createElement('a');
      link.href = this.#link_to(table.job);
      link.textContent = table.job;
      words.append(' · from ', link);
    }
    return words;
  }

  #part(name) {
    return this.#root.querySelector(`.panel-${name}`);
  }

  #set(name, text) {
    const part = this.#part(name);
    if (part.textContent !== text) part.textContent = text;
  }
}
