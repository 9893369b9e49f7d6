// Curves over samples or seconds, both axes logarithmic, drawn by uPlot. The library is the
// server's (web/package.json); without it there is no chart.

const kUrl = '/lib/uPlot.esm.js';
const kHeightPx = 260;
const kPointed = 8; // of more lines the points would cover each other
// Okabe and Ito's colours without yellow and black, blue and vermilion first; told apart by dashes
// too. The ninth line and further have wider dashes.
const kColors = ['#0072b2', '#d55e00', '#009e73', '#cc79a7', '#e69f00', '#56b4e9', '#8c6bb1',
  '#7f7f7f'];
const kDashes = [[], [7, 4], [2, 3], [10, 3, 2, 3]];
// {stroke, dash} of the line of this number.
export const line_style = (i) => ({ stroke: kColors[i % kColors.length],
  dash: kDashes[(i + Math.floor(i / kColors.length)) % kDashes.length] });

let library = null;
function load_library() {
  library ??= import(kUrl).then((module) => module.default).catch(() => null);
  return library;
}

// The points' range and a little more; whole decades would be mostly empty.
const range = (u, least, most) => (least > 0 ? [least / 1.15, most * 1.15] : [0.1, 1]);
export function log_splits(least, most) {
  const splits = [];
  for (let power = Math.floor(Math.log10(least)); 10 ** power <= most; ++power) {
    for (let digit = 1; digit < 10; ++digit) splits.push(digit * 10 ** power);
  }
  return splits.filter((v) => v >= least && v <= most);
}
export const log_ticks = (splits) => splits.map((v) => {
  const digit = v / 10 ** Math.floor(Math.log10(v) + 1e-9);
  return Math.abs(digit - Math.round(digit)) < 1e-6 && [1, 2, 5].includes(Math.round(digit))
    ? String(+v.toPrecision(2)) : '';
});

export class ErrorChart {
  #root;
  #on_hover;
  #on_pick;
  #options_more;
  #plot = null;
  #shape = '';
  #lines = [];

  // on_hover(line index, x | null), on_pick(line index, x). `zooms`: a rectangle that is dragged is
  // enlarged, a double click shows all again; `legend`: uPlot's own.
  constructor(root, on_hover, on_pick, { zooms = false, legend = true } = {}) {
    this.#root = root;
    this.#on_hover = on_hover;
    this.#on_pick = on_pick;
    this.#options_more = { zooms, legend };
    new ResizeObserver(() => this.#plot?.setSize({ width: root.clientWidth, height: kHeightPx }))
      .observe(root);
  }

  // lines: [{label, points: [[x, y]], marks: [{x, text}], spread: [[least, most]] of each point, or
  // none}]. Resolves to false without the library.
  async show(lines, x_label, y_label) {
    const uPlot = await load_library();
    if (!uPlot) return false;
    this.#lines = lines;
    const drawn = lines.filter(({ points }) => points.length > 0);
    if (!drawn.length) {
      this.#clear();
      return true;
    }
    const data = uPlot.join(lines.map(({ points, spread }) => [points.map(([x]) => x),
      points.map(([, y]) => y), ...(spread ? [0, 1].map((i) => spread.map((s) => s[i])) : [])]));
    const shape = JSON.stringify([lines.map(({ label, spread }) => [label, Boolean(spread)]),
      x_label, y_label, getComputedStyle(this.#root).color]);
    if (this.#plot && this.#shape === shape) {
      this.#plot.setData(data);
      return true;
    }
    this.#clear();
    this.#shape = shape;
    this.#plot = new uPlot(this.#options(x_label, y_label), data, this.#root);
    this.#plot.over.addEventListener('click', () => {
      const at = this.#at();
      if (at) this.#on_pick(...at);
    });
    return true;
  }

  // uPlot's own; null without a chart.
  get plot() {
    return this.#plot;
  }

  #clear() {
    this.#plot?.destroy();
    this.#plot = null;
    this.#shape = '';
  }

  #options(x_label, y_label) {
    const style = getComputedStyle(this.#root);
    const { zooms, legend } = this.#options_more;
    const [text, grid] = [style.color, style.getPropertyValue('--line')];
    const axis = (label) => ({ label, stroke: text, labelSize: 22, font: '12px system-ui',
      labelFont: '12px system-ui', grid: { stroke: grid, width: 1 },
      ticks: { stroke: grid, width: 1 }, splits: (u, which, least, most) => log_splits(least, most),
      filter: (u, splits) => splits, values: (u, splits) => log_ticks(splits) });
    const series = [{ label: x_label }];
    const bands = [];
    this.#lines.forEach(({ label, spread }, i) => {
      const { stroke, dash } = line_style(i);
      series.push({ label, width: 2, spanGaps: true, stroke, dash,
        points: { show: this.#lines.length <= kPointed, size: 5 } });
      if (!spread) return;
      const edge = { width: 0, spanGaps: true, points: { show: false } };
      series.push({ ...edge, label: `${label}, least` }, { ...edge, label: `${label}, most` });
      bands.push({ series: [series.length - 1, series.length - 2], fill: `${stroke}30` });
    });
    return {
      width: this.#root.clientWidth,
      height: kHeightPx,
      scales: { x: { time: false, distr: 3, range }, y: { distr: 3, range } },
      axes: [axis(x_label), { ...axis(y_label), size: 56 }],
      series,
      bands,
      legend: { show: legend },
      cursor: { drag: { x: zooms, y: zooms }, y: false, points: { show: legend } },
      hooks: {
        draw: [(u) => this.#draw_marks(u)],
        setCursor: [() => {
          const at = this.#at();
          this.#on_hover(...(at ?? [0, null]));
        }],
      },
    };
  }

  // The line whose point is nearest to the pointer, and its x there.
  #at() {
    const { left, top, idx } = this.#plot.cursor;
    if (idx === null || idx === undefined || left < 0) return null;
    let best = null;
    this.#lines.forEach(({ points }, line) => {
      for (const [x, y] of points) {
        const far = Math.abs(this.#plot.valToPos(x, 'x') - left) +
          0.2 * Math.abs(this.#plot.valToPos(y, 'y') - top);
        if (!best || far < best.far) best = { far, at: [line, x] };
      }
    });
    return best?.at ?? null;
  }

  #draw_marks(u) {
    const { ctx } = u;
    const { left, top, width, height } = u.bbox;
    ctx.save();
    ctx.font = `${11 * devicePixelRatio}px system-ui`;
    ctx.textAlign = 'left';
    this.#lines.forEach(({ marks = [] }, line) => marks.forEach(({ x, text }, i) => {
      const at = u.valToPos(x, 'x', true);
      if (!(at >= left - 1 && at <= left + width + 1)) return;
      ctx.strokeStyle = ctx.fillStyle = line_style(line).stroke;
      ctx.lineWidth = devicePixelRatio;
      ctx.setLineDash([2, 3].map((v) => v * devicePixelRatio));
      ctx.beginPath();
      ctx.moveTo(at, top);
      ctx.lineTo(at, top + height);
      ctx.stroke();
      const wide = ctx.measureText(text).width + 4 * devicePixelRatio;
      const x_text = Math.min(at + 4 * devicePixelRatio, left + width - wide);
      // From the bottom: errors fall, so there the curves come last.
      ctx.fillText(text, x_text, top + height - (6 + 14 * (i + 2 * line)) * devicePixelRatio);
    }));
    ctx.restore();
  }
}
