// One scene of an experiment, at one size and camera: whether its runs can be compared, the chart,
// the table of methods.
import { curve_of, equal_time, summary_of } from './bench_measures.js';
import { chart_svg, save } from './chart_files.js';
import { ErrorChart, line_style } from './error_chart.js';
import { brightness_words, count, method_words, samples_words, significant } from './format.js';
import { title_of } from './scene_library.js';

const variant_words = (variant) => {
  const [method, settings] = variant.split(/:(.*)/);
  return method_words(method) + (settings ? `, ${settings.replaceAll(';', ', ')}` : '');
};
const number_of = (value, write = significant) => (value === null ? '–' : write(value));

export class BenchCase {
  root;
  #chart;
  #lines = [];
  #labels = ['', ''];
  #title = '';
  #link_to;

  constructor(template, link_to) {
    this.root = template.content.firstElementChild.cloneNode(true);
    this.#link_to = link_to;
    this.#chart = new ErrorChart(this.#part('chart'), (line, x) => this.#hover(line, x), () => {},
      { zooms: true, legend: false });
    this.#part('svg').addEventListener('click', () =>
      save(`${this.#title}.svg`, chart_svg(this.#lines, ...this.#labels, this.#title)));
  }

  // of: {request, runs, variants, halves, made, floor, others, is_done}; `made`: a reference was
  // asked for.
  async show(of, axis) {
    const { request, runs, variants, halves } = of;
    const { scene, width, height, camera } = request;
    this.#title = `${title_of(scene)}, ${width} × ${height}, ` +
      (camera ? 'a camera of its own' : "the scene's camera");
    this.#part('title').textContent = this.#title;
    this.root.querySelector('.scroller').setAttribute('aria-label', `Methods in ${this.#title}`);
    this.#lines = variants.map((variant) => ({ label: variant_words(variant),
      ...curve_of(runs.filter((run) => run.variant === variant), axis) }));
    this.#labels = [axis === 'seconds' ? 'seconds of rendering' : 'samples a pixel',
      halves ? 'relMSE' : 'relative error (estimate)'];
    this.#check(of);
    this.#fill_table(of);
    this.#part('svg').disabled = !this.#lines.some(({ points }) => points.length);
    const drawn = await this.#chart.show(this.#lines, ...this.#labels);
    this.#part('no-chart').hidden = drawn;
    this.#part('chart').hidden = !drawn || this.#part('svg').disabled;
  }

  // What can be compared, in sentences.
  #check({ request, runs, halves, made, floor, others, sizes }) {
    const say = runs.length
      ? [[`Size and camera are equal in all runs here: ${count(runs.length)} have ended.`]] : [];
    if (sizes > 1) {
      say.push([`This scene was rendered in ${sizes} sizes or cameras: each has a chart of its ` +
        'own, and no error is compared between them.', true]);
    }
    if (runs.length) {
      const { holds, least, most, beside } = equal_time(runs, others);
      const took = `${significant(least)} to ${significant(most)} s`;
      const ran = beside ? `, and ${beside} of them ran beside another job` : ', each alone';
      if (request.seconds) {
        say.push(holds ? [`Equal time holds: the runs took ${took}${ran}.`]
          : [`Equal time does not hold: the runs took ${took}${ran}.`, true]);
      } else {
        say.push([`The runs have equal samples, not equal time: they took ${took}${ran}. Compare ` +
          'the methods over seconds, or by efficiency.', Boolean(beside)]);
      }
    }
    if (halves) {
      const samples = halves.map(({ progress }) => progress.samples);
      say.push([`The reference is the mean of two halves of ${samples.map(count).join(' and ')} ` +
        `samples by ${method_words(halves[0].request.method)}` + (floor === null ? '.'
        : `; its own relMSE is ${significant(floor)}. Errors below twice that are not judged.`)]);
    } else {
      say.push([`${made ? 'The reference is not there' : 'No reference was made'}: errors are ` +
        'what the runs estimate of their noise, which does not see a bias.', made]);
    }
    this.#part('checks').replaceChildren(...say.map(([text, fails]) => {
      const line = document.createElement('li');
      line.textContent = text;
      line.classList.toggle('fails', Boolean(fails));
      return line;
    }));
  }

  #fill_table({ runs, variants, floor, halves }) {
    this.#part('error').textContent = halves ? 'relMSE' : 'Noise';
    this.#part('over').textContent = `Efficiency over ${variant_words(variants[0] ?? '')}`;
    const cell = (text, tag = 'td') => {
      const one = document.createElement(tag);
      one.textContent = text;
      if (tag === 'td') one.className = 'number';
      return one;
    };
    this.root.querySelector('tbody').replaceChildren(...summary_of(runs, variants, floor)
      .map((row, i) => {
        const line = document.createElement('tr');
        const name = cell('', 'th');
        name.scope = 'row';
        name.append(line_picture(i), variant_words(row.variant));
        const { efficiency } = halves ? row : {};
        const pictures = cell('', 'td');
        pictures.className = '';
        runs.filter(({ variant }) => variant === row.variant).forEach(({ job, seed }, at) => {
          const link = document.createElement('a');
          link.href = this.#link_to(job.id);
          link.textContent = seed;
          link.setAttribute('aria-label', `${variant_words(row.variant)}, seed ${seed}`);
          pictures.append(at ? ' ' : '', link);
        });
        line.append(name, cell(count(row.seeds)), cell(number_of(row.error)),
          cell(number_of(row.trimmed)), cell(number_of(row.flip)),
          cell(row.brightness === null ? '–' : brightness_words(row.brightness)),
          cell(number_of(row.samples, count)), cell(number_of(row.seconds)),
          cell(row.at_floor ? 'as good as the reference' : !efficiency ? '–'
            : `${significant(efficiency.ratio)}${efficiency.low === null ? ''
              : ` (${significant(efficiency.low, 2)} to ${significant(efficiency.high, 2)})`}`),
          pictures);
        return line;
      }));
  }

  #hover(line, x) {
    const { label, points, spread } = this.#lines[line] ?? {};
    const at = x === null || !points ? -1 : points.findIndex(([one]) => one === x);
    this.#part('hover').textContent = at < 0 ? '' : `${label}: ${significant(points[at][1])}` +
      (spread ? ` (${spread[at].map((v) => significant(v)).join(' to ')})` : '') +
      ` after ${this.#labels[0].startsWith('sec') ? `${significant(x)} s` : samples_words(x)}`;
  }

  #part(name) {
    return this.root.querySelector(`.case-${name}`);
  }
}

function line_picture(i) {
  const { stroke, dash } = line_style(i);
  const svg = document.createElementNS('http://www.w3.org/2000/svg', 'svg');
  const line = document.createElementNS('http://www.w3.org/2000/svg', 'path');
  for (const [name, value] of Object.entries({ d: 'M0 5h34', stroke, 'stroke-width': 2,
    'stroke-dasharray': dash.join(' ') })) line.setAttribute(name, value);
  svg.append(line);
  svg.setAttribute('class', 'case-line');
  svg.setAttribute('aria-hidden', 'true');
  return svg;
}
