// What an experiment's runs come to: medians and spreads over seeds, efficiency, and whether the
// runs can be compared at all. Pure functions over runs:
// {job, variant, seed, curve: [{samples, seconds, error}], end: {samples, seconds, error, trimmed,
// flip, brightness}}; errors are relMSE, or the estimated noise where there is no reference.

const kGrid = 24; // points of a curve whose runs were measured at different times
const kAlike = 1.02; // times that count as equal
const kStudent = [12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228];

export function median(values) {
  const sorted = [...values].sort((a, b) => a - b);
  const half = sorted.length >> 1;
  return sorted.length % 2 ? sorted[half] : (sorted[half - 1] + sorted[half]) / 2;
}
// 97.5 % of Student's T.
const student = (freedom) => kStudent[freedom - 1] ?? 1.96 + 2.4 / freedom + 3 / freedom ** 2;

// Straight between points on logarithmic axes; x within them.
function value_at(points, x) {
  const after = points.findIndex(([at]) => at >= x * (1 - 1e-9));
  if (after <= 0) return points[0][1];
  const [[x0, y0], [x1, y1]] = [points[after - 1], points[after]];
  if (x1 === x0) return y1;
  return y0 * (y1 / y0) ** (Math.log(x / x0) / Math.log(x1 / x0));
}

// {points: [[x, median]], spread: [[least, most]]} of the runs of one method over `axis`.
export function curve_of(runs, axis) {
  const curves = runs.map(({ curve }) => curve.map((at) => [at[axis], at.error])
    .filter(([x, y]) => x > 0 && y > 0)).filter((points) => points.length);
  if (!curves.length) return { points: [] };
  const [first] = curves;
  let xs = first.map(([x]) => x);
  if (!curves.every((one) => one.length === xs.length && one.every(([x], i) => x === xs[i]))) {
    const from = Math.max(...curves.map((one) => one[0][0]));
    const to = Math.min(...curves.map((one) => one.at(-1)[0]));
    const part = (i) => from * (to / from) ** (i / (kGrid - 1));
    xs = from < to ? Array.from({ length: kGrid }, (_, i) => part(i)) : [to];
  }
  const at = xs.map((x) => curves.map((points) => value_at(points, x)));
  return { points: xs.map((x, i) => [x, median(at[i])]),
    spread: curves.length > 1 ? at.map((all) => [Math.min(...all), Math.max(...all)]) : null };
}

// 1/(error x seconds) of `runs` over that of `base`, seed by seed: {ratio, low, high}, the mean of
// logarithms with Student's 95 % interval (null of one seed). Null where no seed has both.
export function efficiency(runs, base) {
  const logs = runs.flatMap(({ seed, end }) => base.filter((other) => other.seed === seed)
    .map((other) => Math.log(other.end.error * other.end.seconds / (end.error * end.seconds))))
    .filter(Number.isFinite);
  if (!logs.length) return null;
  const mean = logs.reduce((sum, v) => sum + v, 0) / logs.length;
  const ratio = Math.exp(mean);
  if (logs.length < 2) return { ratio, low: null, high: null };
  const variance = logs.reduce((sum, v) => sum + (v - mean) ** 2, 0) / (logs.length - 1);
  const wide = student(logs.length - 1) * Math.sqrt(variance / logs.length);
  return { ratio, low: Math.exp(mean - wide), high: Math.exp(mean + wide) };
}

// One row a method, in the order of `variants`; `floor`: the reference's own error, or null.
export function summary_of(runs, variants, floor) {
  const base = runs.filter(({ variant }) => variant === variants[0]);
  const of = (some, member) => {
    const known = some.map(({ end }) => end[member]).filter((v) => v !== null && v !== undefined);
    return known.length ? median(known) : null;
  };
  const is_low = (some) => floor !== null && of(some, 'error') < 2 * floor;
  return variants.map((variant) => {
    const own = runs.filter((run) => run.variant === variant);
    return { variant, seeds: own.length, error: of(own, 'error'), trimmed: of(own, 'trimmed'),
      flip: of(own, 'flip'), brightness: of(own, 'brightness'), samples: of(own, 'samples'),
      seconds: of(own, 'seconds'), at_floor: own.length > 0 && is_low(own),
      efficiency: is_low(own) || is_low(base) ? null : efficiency(own, base) };
  });
}

// Whether the runs took equal time: {holds, least, most, beside}; `beside`: how many ran while
// another job did. `others`: jobs of the server that may have.
export function equal_time(runs, others) {
  const times = runs.map(({ end }) => end.seconds);
  const [least, most] = [Math.min(...times), Math.max(...times)];
  const beside = runs.filter(({ job }) => others.some((other) => other.id !== job.id &&
    other.started && other.started < job.ended && (!other.ended || other.ended > job.started)))
    .length;
  return { holds: most <= kAlike * least && !beside, least, most, beside };
}
