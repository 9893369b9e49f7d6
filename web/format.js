// Plain words and numbers for what the server says.

const kStateWords = {
  queued: 'Waiting',
  preparing: 'Loading the scene',
  learning: 'Learning',
  rendering: 'Rendering',
  finalizing: 'Finishing',
  succeeded: 'Done',
  pausing: 'Pausing',
  paused: 'Paused',
  canceling: 'Canceling',
  canceled: 'Canceled',
  failed: 'Failed',
};
const kEnded = ['succeeded', 'canceled', 'failed'];
const kMethodWords = {
  none: 'no learning',
  'dahm-keller': 'Dahm-Keller',
  ppg: 'PPG',
  'huang-published': 'huang as published',
};

const kLoadWords = { reading: 'reading the scene', building: 'building its tree' };

// The server's states that a filter of the list means; none: any.
export const states_of = (state) => (state === 'running'
  ? Object.keys(kStateWords).filter((one) => !kEnded.includes(one)) : state ? [state] : []);
export const state_words = (state) => kStateWords[state] ?? state;
export const method_words = (method) => kMethodWords[method] ?? method;
export const has_ended = (job) => kEnded.includes(job.state);
// Its picture was made whole from the pixels that were sampled.
export const is_recovered = (job) =>
  job.state === 'succeeded' && (job.request.recover ?? 'none') !== 'none';
// Its method or its choice of pixels moves the mean.
export const is_biased = (job) => (job.stats ? !job.stats.unbiased : job.biased &&
  (job.request.recover ?? 'none') === 'none');
export const badge_word = (job) => (is_recovered(job) ? 'recovered' : job.biased ? 'biased' : '');
export const can_cancel = (job) => !has_ended(job) && job.state !== 'canceling';
// Which of the two a job's button does now; '' for neither.
export const pause_or_resume = (job) => {
  if (job.state === 'paused') return 'resume';
  return ['queued', 'preparing', 'learning', 'rendering'].includes(job.state) ? 'pause' : '';
};
export const is_forming = (job) => ['learning', 'rendering'].includes(job.state);

// Why a job is where it is, in a sentence; '' when its state says it all.
export function why_words(job) {
  const { request, progress, stats, state } = job;
  const done = samples_words(progress.samples);
  const kept = progress.samples > 0 ? ' Its picture so far is kept.' : '';
  switch (state) {
    case 'queued': return 'Others are rendered before it.';
    case 'paused': return `Paused after ${done}; it goes on from there when resumed.`;
    case 'canceled': return `Someone canceled it after ${done}.${kept}`;
    case 'failed': return kept.trim();
    case 'succeeded': break;
    default: return '';
  }
  const noise = stats?.noise;
  if (request.noise && noise && noise <= request.noise) {
    return `Stopped at ${done}: the noise is ${significant(noise)}, no more than the ` +
      `${significant(request.noise)} asked for.`;
  }
  const missed = request.noise && noise
    ? ` The noise is ${significant(noise)}, more than the ${significant(request.noise)} asked for.`
    : '';
  if (request.seconds) {
    return `Stopped when its ${seconds(request.seconds)} were over, at ${done}.${missed}`;
  }
  return `Stopped when all ${done} were there.${missed}`;
}

// Seconds that a running job will still take at its pace; null where that is unknown.
function seconds_left({ state, progress, request }) {
  if (!is_forming({ state }) || !(progress.fraction > 0.02) || !progress.seconds) return null;
  if (request.seconds && !request.samples) return Math.max(0, request.seconds - progress.seconds);
  return progress.seconds * (1 - progress.fraction) / progress.fraction;
}

export const significant = (v, digits = 3) => {
  if (v === 0) return '0';
  const size = Math.abs(v);
  return size >= 1e5 || size < 1e-4 ? v.toExponential(digits - 1) : String(+v.toPrecision(digits));
};

// "1.7 times as bright as j000002", "3.1 % darker than j000002"; `other` may be left out.
export function brightness_words(ratio, other = '') {
  if (ratio >= 1.995) return `${significant(ratio, 2)} times as bright${other && ` as ${other}`}`;
  const percent = Math.abs(100 * (ratio - 1));
  if (percent < 0.05) return `as bright${other && ` as ${other}`}`;
  return `${percent.toFixed(percent < 10 ? 1 : 0)} % ${ratio >= 1 ? 'brighter' : 'darker'}` +
    (other && ` than ${other}`);
}

export function count(n) {
  return n.toLocaleString('en', { maximumFractionDigits: n < 10 ? 1 : 0 });
}

// What a job's `frames` asks for.
export function frames_words({ turntable, degrees, cameras, animation, from, to }) {
  if (turntable) return `${turntable}, a turntable of ${degrees ?? 360}°`;
  if (!animation) return `${cameras.length}, cameras one by one`;
  return `${animation} a second of its animation, from ${from ?? 0} s to ${
    to === undefined ? 'its end' : `${to} s`}`;
}
export const samples_words = (n) => (n === 1 ? '1 sample' : `${count(n)} samples`);

export function big(n) {
  return n.toLocaleString('en', { notation: 'compact', maximumSignificantDigits: 3 });
}

export function bytes(n) {
  if (n < 1024) return `${n}\u00a0B`;
  const units = ['KiB', 'MiB', 'GiB'];
  const power = Math.min(units.length, Math.floor(Math.log2(n) / 10));
  return `${(n / 1024 ** power).toFixed(1)}\u00a0${units[power - 1]}`;
}

export function seconds(s) {
  if (s < 60) return `${s.toFixed(1)}\u00a0s`;
  const whole = Math.round(s);
  const pad = (v) => String(v).padStart(2, '0');
  const minutes = Math.floor(whole / 60);
  if (minutes < 60) return `${minutes}:${pad(whole % 60)}\u00a0min`;
  return `${Math.floor(minutes / 60)}:${pad(minutes % 60)}\u00a0h`;
}

export function ago(iso, now_ms = Date.now()) {
  const s = Math.max(0, (now_ms - Date.parse(iso)) / 1000);
  if (s < 60) return 'just now';
  if (s < 3600) return `${Math.floor(s / 60)} min ago`;
  if (s < 86400) return `${Math.floor(s / 3600)} h ago`;
  return new Date(iso).toLocaleDateString();
}

// Integers above 2^53 came through JSON with lost digits.
export const exact = (n) => (Number.isSafeInteger(n) ? String(n) : `about ${n.toPrecision(5)}`);

export const exposure = (ev) => `${ev > 0 ? '+' : ev < 0 ? '−' : ''}${Math.abs(ev).toFixed(1)} EV`;

// "16 of 64 samples · 1.5 s"; what is not known is left out.
export function progress_words(job) {
  if (job.state === 'preparing' && job.loading) {
    const { step, fraction } = job.loading;
    return `${kLoadWords[step] ?? step}, ${Math.round(100 * fraction)} %`;
  }
  const { samples, seconds: spent } = job.progress;
  const words = [];
  if (job.request.samples) {
    words.push(`${count(samples)} of ${samples_words(job.request.samples)}`);
  } else if (samples > 0) {
    words.push(samples_words(samples));
  }
  if (job.request.seconds && !has_ended(job)) {
    words.push(`${seconds(spent)} of ${seconds(job.request.seconds)}`);
  } else if (spent > 0) {
    words.push(seconds(spent));
  }
  const left = seconds_left(job);
  if (left !== null) words.push(`about ${seconds(left)} left`);
  return words.join(' · ');
}
