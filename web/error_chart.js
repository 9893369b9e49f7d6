// Curves over samples or seconds, both axes logarithmic, drawn by uPlot. The library is the
// server's (web/package.json); without it there is no chart.

const kUrl = '/lib/uPlot.esm.js';
const kHeightPx = 260;
// Okabe and Ito's blue and vermilion, told apart by dashes too.
const kLines = [{ stroke: '#0072b2' }, { stroke: '#d55e00', dash: [7, 4] }];

let library = null;
function load_library() {
  library ??= import(kUrl).then((module) => module.default).catch(() => null);
  return library;
}

// The points' range and a little more; whole decades would be mostly empty.
const range = (u, least, most) => (least > 0 ? [least / 1.15, most * 1.15] : [0.1, 1]);
function log_splits(u, axis, least, most) {
  const splits = [];
  for (let power = Math.floor(Math.log10(least)); 10 ** power <= most; ++power) {
    for (let digit = 1; digit < 10; ++digit) splits.push(digit * 10 ** power);
  }
  return splits.filter((v) => v >= least && v <= most);
}
const log_ticks = (u, splits) => splits.map((v) => {
  const digit = v / 10 ** Math.floor(Math.log10(v) + 1e-9);
  return Math.abs(digit - Math.round(digit)) < 1e-6 && [1, 2, 5].includes(Math.round(digit))
    ? String(+v.toPrecision(2)) : '';
});

export class ErrorChart {
  #root;
  #on_hover;
  #on_pick;
  #plot = null;
  #shape = '';
  #lines = [];

  // on_hover(line index, x | null), on_pick(line index, x)
  constructor(root, on_hover, on_pick) {
    this.#root = root;
    this.#on_hover = on_hover;
    this.#on_pick = on_pick;
    new ResizeObserver(() => this.#plot?.setSize({ width: root.clientWidth, height: kHeightPx }))
      .observe(root);
  }

  // lines: [{label, points: [[x, y]], marks: [{x, text}]}]. Resolves to false without the library.
  async show(lines, x_label, y_label) {
    const uPlot = await load_library();
    if (!uPlot) return false;
    this.#lines = lines;
    const drawn = lines.filter(({ points }) => points.length > 0);
    if (!drawn.length) {
      this.#clear();
      return true;
    }
    const data = uPlot.join(lines.map(({ points }) =>
      [points.map(([x]) => x), points.map(([, y]) => y)]));
    const shape = JSON.stringify([lines.map(({ label }) => label), x_label, y_label,
      getComputedStyle(this.#root).color]);
    if (this.#plot && this.#shape === shape) {
      this.#plot.setData(data);
      return true;
    }
    this.#clear();
    this.#shape = shape;
    this.#plot = new uPlot(this.#options(uPlot, x_label, y_label), data, this.#root);
    this.#plot.over.addEventListener('click', () => {
      const at = this.#at();
      if (at) this.#on_pick(...at);
    });
    return true;
  }

  #clear() {
    this.#plot?.destroy();
    this.#plot = null;
    this.#shape = '';
  }

  #options(uPlot, x_label, y_label) {
    const style = getComputedStyle(this.#root);
    const [text, grid] = [style.color, style.getPropertyValue('--line')];
    const axis = (label) => ({ label, stroke: text, labelSize: 22, font: '12px system-ui',
      labelFont: '12px system-ui', grid: { stroke: grid, width: 1 },
      ticks: { stroke: grid, width: 1 }, splits: log_splits, filter: (u, splits) => splits,
      values: log_ticks });
    return {
      width: this.#root.clientWidth,
      height: kHeightPx,
      scales: { x: { time: false, distr: 3, range }, y: { distr: 3, range } },
      axes: [axis(x_label), { ...axis(y_label), size: 56 }],
      series: [{ label: x_label }, ...this.#lines.map(({ label }, i) => ({ label, width: 2,
        spanGaps: true, points: { show: true, size: 5 }, ...kLines[i] }))],
      cursor: { drag: { x: false, y: false }, y: false },
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
    this.#lines.forEach(({ marks }, line) => marks.forEach(({ x, text }, i) => {
      const at = u.valToPos(x, 'x', true);
      if (!(at >= left - 1 && at <= left + width + 1)) return;
      ctx.strokeStyle = ctx.fillStyle = kLines[line].stroke;
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
