// An experiment as jobs: methods x seeds x scenes, in the order in which `qray chart` runs them,
// and a reference of two halves for each scene; and the command that repeats it. Pure functions.

export const kLabel = 'experiment'; // whose value all jobs of one share
const kReferenceSeeds = [1_000_001, 1_000_002]; // none that a run has
const kKeys = { depth: 'max_depth', learning: 'learning_samples' };
const kSwitches = { on: true, off: false };

// "none, huang:grid=12;nee=off" -> its variants, as `qray chart --methods` has them.
export const variants_of = (text) => text.split(',').map((one) => one.trim()).filter(Boolean);

// "huang:grid=12;nee=off" -> {method, guide: {grid: 12}, nee: false}. What is wrong with it, the
// server says.
export function request_of_variant(variant, fields) {
  const [method, settings = ''] = variant.split(/:(.*)/);
  const request = { method };
  for (const pair of settings.split(';').filter(Boolean)) {
    const [key, text = ''] = pair.split('=');
    const name = kKeys[key] ?? key.replaceAll('-', '_');
    const value = kSwitches[text] ?? (text !== '' && Number.isFinite(Number(text)) ? Number(text)
      : text);
    if (fields.some(({ path }) => path === `guide/${name}`)) {
      request.guide = { ...request.guide, [name]: value };
    } else request[name] = value;
  }
  return request;
}

// plan: {name, scenes, variants, seeds, budget: 'samples' | 'seconds', amount, width, height,
// camera, reference: {method, times} or null}; null: the scene's own.
export function jobs_of(plan, fields) {
  const { name, scenes, variants, seeds, budget, amount, reference } = plan;
  const jobs = [];
  for (const scene of scenes) {
    const common = { scene, table: 'none', alone: true };
    for (const member of ['width', 'height', 'camera']) {
      if (plan[member]) common[member] = plan[member];
    }
    if (reference) {
      const half = Math.max(1, reference.times * amount / 2);
      kReferenceSeeds.forEach((seed, i) => jobs.push({ ...common, method: reference.method, seed,
        [budget]: budget === 'samples' ? Math.round(half) : half,
        labels: { part: `reference ${'ab'[i]}` } }));
    }
    for (let seed = 1; seed <= seeds; ++seed) {
      // Each seed begins with the next method, so that a slow spell touches all alike.
      variants.forEach((_, i) => {
        const variant = variants[(i + seed - 1) % variants.length];
        jobs.push({ ...common, ...request_of_variant(variant, fields), seed, [budget]: amount,
          labels: { part: 'run', variant } });
      });
    }
  }
  for (const { labels } of jobs) Object.assign(labels, { [kLabel]: name, jobs: `${jobs.length}` });
  return jobs;
}

const quoted = (text) => (/^[\w.,:=-]+$/.test(text) ? text : `'${text.replaceAll("'", "'\\''")}'`);

// `seconds`: of a run; `reference_seconds`: of both halves, or null; `size`: "256x256", or null
// where each scene has its own.
export function chart_command({ scenes, variants, seconds, seeds, size, reference_method,
  reference_seconds, folder }) {
  const words = ['qray', 'chart', ...scenes, '--methods', variants.join(','), '--seconds',
    String(seconds), '--seeds', String(seeds)];
  if (size) words.push('--size', size);
  if (reference_seconds) words.push('--ref-seconds', String(reference_seconds));
  if (reference_method && reference_method !== 'none') words.push('--ref-method', reference_method);
  return [...words, '-o', folder].map(quoted).join(' ');
}
