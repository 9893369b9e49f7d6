// What is measured of live sessions, in a table: a row for each measure, a column for each session.

const fixed = (v, digits) => (Number.isFinite(v) ? v.toFixed(digits) : '–');
const kMeasures = [
  ['frames/s', (s) => fixed(s.frames_per_second, 1)],
  ['latency, median', (s) => `${fixed(s.latency_ms(0.5), 0)} ms`],
  ['latency, p95', (s) => `${fixed(s.latency_ms(0.95), 0)} ms`],
  ['frame', (s) => `${fixed(s.frame.ms.whole, 0)} ms`],
  ['· features', (s) => `${fixed(s.frame.ms.features, 1)} ms`],
  ['· reprojection', (s) => `${fixed(s.frame.ms.reprojection, 1)} ms`],
  ['· samples', (s) => `${fixed(s.frame.ms.samples, 1)} ms`],
  ['· learning', (s) => `${fixed(s.frame.ms.learning, 1)} ms`],
  ['· recovery', (s) => `${fixed(s.frame.ms.recovery, 1)} ms`],
  ['rays a frame', (s) => `${fixed(s.frame.rays / 1000, 0)} k`],
  ['samples a pixel', (s) => fixed(s.frame.samples_per_pixel, 1)],
  ['noise of samples', (s) => (s.frame.noise ? `${fixed(100 * s.frame.noise, 1)} %` : '–')],
  ['sent as', (s) => (s.encoding === 'rgb9e5' ? 'HDR' : s.encoding.toUpperCase())],
  ['rendered at', (s) => `${s.frame.percent} % of ${s.frame.width} × ${s.frame.height}`],
  ['guided', (s) => (s.frame.guided ? 'yes' : 'not yet')],
];

// `sessions`: those that have a frame.
export function show_measures(body, sessions) {
  body.replaceChildren(...kMeasures.map(([name, text]) => {
    const row = document.createElement('tr');
    const head = document.createElement('th');
    head.scope = 'row';
    head.textContent = name;
    row.append(head);
    for (const session of sessions) row.insertCell().textContent = text(session);
    return row;
  }));
}
