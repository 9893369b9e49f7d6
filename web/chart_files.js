// Charts as files: SVG, drawn here as ErrorChart draws its lines; CSV; JSON. Loaded when one is
// first asked for.
import { line_style, log_splits, log_ticks } from './error_chart.js';

const kWidth = 720;
const kHeight = 420;
const kLeft = 64;
const kRight = 12;
const kTop = 28;
const kBottom = 46;
const kRow = 16; // of the legend

const escaped = (text) => String(text).replace(/[&<>"]/g,
  (c) => ({ '&': '&amp;', '<': '&lt;', '>': '&gt;', '"': '&quot;' })[c]);
const around = (values) => [Math.min(...values) / 1.15, Math.max(...values) * 1.15];

// `lines` as ErrorChart.show() has them. Black on white, for print.
export function chart_svg(lines, x_label, y_label, title) {
  const drawn = lines.map((line, i) => ({ ...line, ...line_style(i) }))
    .filter(({ points }) => points.length);
  const [x0, x1] = around(drawn.flatMap(({ points }) => points.map(([x]) => x)));
  const [y0, y1] = around(drawn.flatMap(({ points, spread }) =>
    [...points.map(([, y]) => y), ...(spread ?? []).flat()]));
  const bottom = kHeight - kBottom;
  const part = (v, least, most) => Math.log(v / least) / Math.log(most / least);
  const at_x = (x) => (kLeft + (kWidth - kLeft - kRight) * part(x, x0, x1)).toFixed(2);
  const at_y = (y) => (bottom - (bottom - kTop) * part(y, y0, y1)).toFixed(2);
  const path = (points) => points.map(([x, y]) => `${at_x(x)},${at_y(y)}`).join(' ');
  const text = (x, y, words, more = '') =>
    `<text x="${x}" y="${y}" ${more}>${escaped(words)}</text>`;
  const out = [];
  const [xs, ys] = [log_splits(x0, x1), log_splits(y0, y1)];
  log_ticks(xs).forEach((tick, i) => out.push(
    `<path d="M${at_x(xs[i])} ${kTop}V${bottom}" stroke="#ddd"/>`,
    tick && text(at_x(xs[i]), bottom + 16, tick, 'text-anchor="middle"')));
  log_ticks(ys).forEach((tick, i) => out.push(
    `<path d="M${kLeft} ${at_y(ys[i])}H${kWidth - kRight}" stroke="#ddd"/>`,
    tick && text(kLeft - 6, Number(at_y(ys[i])) + 4, tick, 'text-anchor="end"')));
  for (const { points, spread, stroke } of drawn.filter((line) => line.spread)) {
    const edge = (i) => points.map(([x], at) => [x, spread[at][i]]);
    out.push(`<polygon points="${path([...edge(0), ...edge(1).reverse()])}" fill="${stroke}" ` +
      'fill-opacity=".19"/>');
  }
  drawn.forEach(({ label, points, stroke, dash }, i) => {
    const look = `fill="none" stroke="${stroke}" stroke-width="2" stroke-dasharray="${dash}"`;
    const y = kHeight + 8 + kRow * i;
    out.push(`<polyline points="${path(points)}" ${look}/>`,
      ...points.map(([x, v]) => `<circle cx="${at_x(x)}" cy="${at_y(v)}" r="2" fill="${stroke}"/>`),
      `<path d="M${kLeft} ${y - 4}h28" ${look}/>`, text(kLeft + 36, y, label));
  });
  out.push(text(kLeft, 18, title, 'font-weight="bold"'),
    text((kLeft + kWidth) / 2, bottom + 36, x_label, 'text-anchor="middle"'),
    text(0, 0, y_label,
      `text-anchor="middle" transform="translate(14 ${(kTop + bottom) / 2}) rotate(-90)"`));
  const height = kHeight + 12 + kRow * drawn.length;
  return `<svg xmlns="http://www.w3.org/2000/svg" width="${kWidth}" height="${height}" ` +
    `viewBox="0 0 ${kWidth} ${height}" font-family="sans-serif" font-size="12">\n` +
    `<title>${escaped(title)}</title><path d="M0 0h${kWidth}v${height}H0z" fill="#fff"/>\n` +
    `${out.filter(Boolean).join('\n')}\n</svg>\n`;
}

// `rows`: objects; `columns`: their members, in this order.
export function csv(columns, rows) {
  const cell = (value) => {
    const text = value === null || value === undefined ? '' : String(value);
    return /[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
  };
  return [columns, ...rows.map((row) => columns.map((name) => row[name]))]
    .map((cells) => cells.map(cell).join(',')).join('\n') + '\n';
}

const kTypes = { svg: 'image/svg+xml', csv: 'text/csv', json: 'application/json' };

export function save(name, text) {
  const url = URL.createObjectURL(new Blob([text], { type: kTypes[name.split('.').at(-1)] }));
  Object.assign(document.createElement('a'), { href: url, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(url), 10_000);
}
