// What the server measured of an experiment's runs, asked for once each, one after the other.
// Errors are against the mean of the reference's halves a and b: of a picture x,
// (x-(a+b)/2)^2 = ((x-a)^2 + (x-b)^2)/2 - (a-b)^2/4, and (a-b)^2/4 is the mean's own error. That
// each term is divided by its own half's brightness changes little where the halves agree.
import { ApiError, get_compare, get_metrics } from './api.js';

// The error against the mean of two halves that are `apart`; none below the mean's own.
const against_mean = (of_a, of_b, apart) => Math.max((of_a + of_b) / 2 - apart / 4, apart / 4);

// Again where the server has too much to do.
async function patiently(ask) {
  for (let tries = 0; ; ++tries) {
    try {
      return await ask();
    } catch (error) {
      if (!(error instanceof ApiError) || !error.retry_after_s || tries > 20) throw error;
      await new Promise((done) => { setTimeout(done, 1000 * error.retry_after_s); });
    }
  }
}

// Of a run that has ended. `halves`: two jobs, or none: then errors are the estimated noise.
export async function measure(job, halves) {
  const end = { samples: job.progress.samples, seconds: job.stats.seconds, noise: job.stats.noise };
  const at = ({ samples, seconds, noise }, error) => ({ samples, seconds, noise, error });
  if (!halves) {
    const { moments } = await patiently(() => get_metrics(job.id));
    const curve = moments.filter(({ noise }) => noise > 0)
      .map((moment) => at(moment, moment.noise));
    return { curve, end: { ...end, error: curve.at(-1)?.error ?? null } };
  }
  const [a, b] = halves.map(({ id }) => id);
  const own = (await patiently(() => get_compare({ a, b }))).difference;
  const { difference: of_b, a_error: of_a } =
    await patiently(() => get_compare({ a: job.id, b, ref: a }));
  const [from_a, from_b] = [(await patiently(() => get_metrics(job.id, a))).moments,
    (await patiently(() => get_metrics(job.id, b))).moments];
  const curve = from_a.filter(({ relmse }) => relmse > 0).flatMap((moment) => {
    const other = from_b.find(({ number }) => number === moment.number);
    return other?.relmse > 0
      ? [at(moment, against_mean(moment.relmse, other.relmse, own.relmse))] : [];
  });
  end.error = against_mean(of_a.relmse, of_b.relmse, own.relmse);
  end.trimmed = against_mean(of_a.relmse_trimmed, of_b.relmse_trimmed, own.relmse_trimmed);
  end.flip = (of_a.flip + of_b.flip) / 2;
  end.brightness = (of_a.mean_ratio + of_b.mean_ratio) / 2;
  if (curve.at(-1)?.samples === end.samples) curve.pop();
  curve.push(at(end, end.error));
  return { curve, end, floor: own.relmse / 4 };
}
