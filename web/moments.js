// Which moments of two jobs belong together. Pure functions over the moments of JobHistory.

export const with_picture = (moments) => moments.filter(({ picture }) => picture);

// The last moment with a picture that took no more than `budget` of `axis` ('samples', 'seconds'),
// else the first with one; null where none has.
function last_within(moments, axis, budget) {
  const shown = with_picture(moments);
  const within = shown.filter((moment) => moment[axis] <= budget * (1 + 1e-9));
  return within.at(-1) ?? shown[0] ?? null;
}

// [moment of a, moment of b] at equal samples or time: as far as both have come, or as far as the
// moment of a that is asked for. Null where a job has none: its newest picture is shown.
export function matching(a, b, axis, number_of_a = null) {
  const newest = [a, b].map((moments) => with_picture(moments).at(-1) ?? null);
  if (!newest[0] || !newest[1]) return [null, null];
  const asked = number_of_a === null ? null : a.find(({ number }) => number === number_of_a);
  const budget = asked?.[axis] ?? Math.min(newest[0][axis], newest[1][axis]);
  return [asked ?? last_within(a, axis, budget), last_within(b, axis, budget)];
}

// Nearest on a logarithmic axis.
export function nearest(moments, axis, value) {
  const far = (moment) => Math.abs(Math.log(Math.max(moment[axis], 1e-6) / Math.max(value, 1e-6)));
  return moments.reduce((best, moment) => (!best || far(moment) < far(best) ? moment : best), null);
}
