// Which moments of two jobs belong together. Pure functions over the moments of JobMoments.

const kAlike = Math.log(1.1); // amounts that count as equal; passes do not end together

export const with_picture = (moments) => moments.filter(({ picture }) => picture);

const apart = (a, b) => Math.abs(Math.log(Math.max(a, 1e-6) / Math.max(b, 1e-6)));

// On a logarithmic axis; null of none.
export function nearest(moments, axis, value) {
  return moments.reduce((best, moment) => (!best || apart(moment[axis], value) <
    apart(best[axis], value) ? moment : best), null);
}

// [moment of a, moment of b] with equal `axis` (samples or seconds): the latest two that are alike,
// else the two nearest to each other; or what is nearest to the moment of a that is asked for. Null
// where a job has none with a picture: its newest is shown.
export function matching(a, b, axis, number_of_a = null) {
  const [ours, theirs] = [a, b].map(with_picture);
  const asked = ours.find(({ number }) => number === number_of_a);
  const pairs = (asked ? [asked] : ours).map((one) => [one, nearest(theirs, axis, one[axis])])
    .filter(([, other]) => other);
  const far = ([one, other]) => apart(one[axis], other[axis]);
  return pairs.findLast((pair) => far(pair) <= kAlike) ??
    pairs.reduce((best, pair) => (far(pair) < far(best) ? pair : best), pairs[0] ?? [null, null]);
}
