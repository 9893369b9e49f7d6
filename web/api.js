// The HTTP calls of docs/api.md, each as one function. Failures are ApiError: what the server said
// (problem+json), or status 0 when it could not be reached.

export class ApiError extends Error {
  constructor(status, detail, { errors = [], retry_after_s = null } = {}) {
    super(detail);
    this.status = status;
    this.errors = errors; // [{pointer, detail}], one for each field the server refused
    this.retry_after_s = retry_after_s;
  }
}

let sign_in = null;
let sessions = 0; // that were opened
// `ask`: called when a call was answered 401, which goes on once it resolves.
export function on_unauthorized(ask) {
  sign_in = ask;
}

async function call(path, { asks = true, ...options } = {}) {
  let response;
  const before = sessions;
  try {
    response = await fetch(path, { cache: 'no-store', ...options });
  } catch (error) {
    if (error.name === 'AbortError') throw error;
    throw new ApiError(0, 'The server cannot be reached.');
  }
  if (response.ok) return response;
  if (response.status === 401 && asks && sign_in) {
    // Else a session was opened while this call was on its way.
    if (before === sessions) await sign_in();
    return call(path, options);
  }
  // A proxy may answer something else than problem+json.
  const problem = await response.json().catch(() => ({}));
  const message = problem.detail || problem.title || `HTTP ${response.status}`;
  throw new ApiError(response.status, message, {
    errors: Array.isArray(problem.errors) ? problem.errors : [],
    retry_after_s: Number(response.headers.get('retry-after')) || null,
  });
}

// Whether this page may look; it is asked for a token if not.
export const check_access = () => call('/v1/');

export const open_session = (token) => call('/v1/session', {
  asks: false,
  method: 'POST',
  headers: { 'content-type': 'application/json' },
  body: JSON.stringify({ token }),
}).then(() => ++sessions);

const query = (values) => {
  const known = Object.entries(values).filter(([, value]) => value !== null && value !== undefined);
  return new URLSearchParams(known).toString();
};

const job_path = (id) => `/v1/jobs/${encodeURIComponent(id)}`;
const get_json = async (path) => (await call(path)).json();

export const kPage = 50; // jobs that are asked for at once
// `find`: words; `states`: one of these; none of either: all jobs.
export const list_jobs = (before, { find, states }) => get_json('/v1/jobs?' + new URLSearchParams([
  ['limit', kPage], ...(before ? [['before', before]] : []), ...(find ? [['q', find]] : []),
  ...states.map((state) => ['state', state])]));
export const get_job = (id) => get_json(job_path(id));
// What a job may be told.
export const list_fields = async () => (await get_json('/v1/fields')).fields;
export const list_scenes = async () => (await get_json('/v1/scenes')).scenes;
const scene_path = (name) => `/v1/scenes/${encodeURIComponent(name)}`;
export const get_thumbnail = (scene) =>
  get_picture(`${scene_path(scene)}/thumbnail.jpg`);
export const list_tables = async () => (await get_json('/v1/tables')).tables;

const post_json = async (path, request, headers = {}) => (await call(path, {
  method: 'POST',
  headers: { 'content-type': 'application/json', ...headers },
  body: JSON.stringify(request),
})).json();

// A live session, its camera, switches and lights.
const live_path = (id) => `/v1/live/${encodeURIComponent(id)}`;
export const open_live = (request) => post_json('/v1/live', request);
export const put_live = async (id, what, body) => (await call(`${live_path(id)}/${what}`, {
  method: 'PUT',
  headers: { 'content-type': 'application/json' },
  body: JSON.stringify(body),
})).json();
export const delete_live = (id) => call(live_path(id), { method: 'DELETE', keepalive: true });

// The same request with the same `key` is one job.
export const post_job = (request, key = null) =>
  post_json('/v1/jobs', request, key ? { 'idempotency-key': key } : {});
export const post_scene = (request) => post_json('/v1/scenes', request);
export const rename_scene = (name, title) => call(scene_path(name), {
  method: 'PATCH',
  headers: { 'content-type': 'application/json' },
  body: JSON.stringify({ title }),
});
export const delete_scene = (name) => call(scene_path(name), { method: 'DELETE' });

export async function has_asset(sha256) {
  try {
    await call(`/v1/assets/${sha256}`, { method: 'HEAD' });
    return true;
  } catch (error) {
    if (error.status === 404) return false;
    throw error;
  }
}
export const put_asset = (sha256, bytes) =>
  call(`/v1/assets/${sha256}`, { method: 'PUT', body: bytes });

// `action`: cancel, pause, resume.
export const act_on_job = async (id, action) =>
  (await call(`${job_path(id)}/${action}`, { method: 'POST' })).json();

export const delete_job = (id) => call(job_path(id), { method: 'DELETE' });
export const extend_job = (id, samples) => post_json(`${job_path(id)}/extend`, { samples });

// `action`: cancel, retry.
export const act_on_frame = async (id, action, frame) =>
  (await call(`${job_path(id)}/frames/${action}?frame=${frame}`, { method: 'POST' })).json();

export const list_weights = async () => (await get_json('/v1/weights')).weights;

// `which`: of the job's pictures, 'sampled' or 'recovered', or the number of a group of lights.
export const fetch_tiles = async (id, which, frame, since, signal) =>
  (await call(`${job_path(id)}/tiles?since=${since}&frame=${frame}&` +
    (typeof which === 'number' ? `group=${which}` : `picture=${which}`), { signal })).arrayBuffer();
export const get_light_groups = (id) => get_json(`${job_path(id)}/light-groups`);

// How far each frame of a job is; their pictures, small.
export const get_frames = (id) => get_json(`${job_path(id)}/frames`);
export const get_frame_preview = (id, frame, side) =>
  get_picture(`${job_path(id)}/image.png?frame=${frame}&side=${side}`);

// The whole picture as it was then.
export const fetch_moment = async (id, moment, signal) =>
  (await call(`${job_path(id)}/tiles?moment=${moment}`, { signal })).arrayBuffer();

export const jobs_of_table = async (table) =>
  (await get_json(`/v1/jobs?limit=50&table=${encodeURIComponent(table)}`)).jobs;
// All of them, the newest first.
export async function jobs_labelled(label) {
  const jobs = [];
  for (let next = ''; next !== undefined;) {
    const answer = await get_json(`/v1/jobs?${query({ limit: 200, label, before: next || null })}`);
    jobs.push(...answer.jobs);
    next = answer.next;
  }
  return jobs;
}
// The newest 200 that `filters` find.
export const jobs_found = async (filters) =>
  (await get_json(`/v1/jobs?${query({ limit: 200, ...filters })}`)).jobs;
export async function delete_labelled(label) {
  const delete_some = async () =>
    (await call(`/v1/jobs?${query({ label })}`, { method: 'DELETE' })).json();
  while ((await delete_some()).more);
}
export const get_metrics = (id, ref = null) =>
  get_json(`${job_path(id)}/metrics${ref ? `?ref=${encodeURIComponent(ref)}` : ''}`);

export const get_pixel = (id, x, y, { moment, frame }, signal) =>
  call(`${job_path(id)}/pixel?${query({ x, y, moment, frame })}`, { signal })
    .then((r) => r.json());
// Pictures that the server makes, as blobs.
export const get_picture = async (path, signal) => (await call(path, { signal })).blob();
export const get_view = (id, view, { moment, frame }, signal) =>
  get_picture(`${job_path(id)}/view.png?${query({ view, moment, frame })}`, signal);
export const get_lobe = (id, x, y, { moment, frame }, signal) =>
  get_picture(`${job_path(id)}/lobe.png?${query({ x, y, moment, frame })}`, signal);
// `values`: {a, b, a_moment, b_moment}
export const get_compare = (values) => get_json(`/v1/compare?${query(values)}`);
export const get_map = (values, signal) =>
  get_picture(`/v1/compare.png?${query(values)}`, signal);
export const get_png = (id, signal) =>
  get_picture(`${job_path(id)}/image.png`, signal);

export const list_workers = () => get_json('/v1/workers');
export const drain_worker = (id) => post_json(`/v1/workers/${encodeURIComponent(id)}/drain`, {});
export const merge_tables = (tables) => post_json('/v1/tables/merge', { tables });
export const delete_table = (id) =>
  call(`/v1/tables/${encodeURIComponent(id)}`, { method: 'DELETE' });

// A mix of groups of lights is of samples, and so is a past moment's picture.
const which_of = (which, frame, mix) =>
  (mix ? `mix=${encodeURIComponent(mix)}` : `picture=${which}`) + (frame ? `&frame=${frame}` : '');
export const exr_url = (id, which, frame = 0, mix = '') =>
  `${job_path(id)}/image.exr?${which_of(which, frame, mix)}`;
export const png_url = (id, which, exposure_ev, moment = null, frame = 0, mix = '') =>
  `${job_path(id)}/image.png?` +
  `${moment === null ? which_of(which, frame, mix) : `moment=${moment}`}&exposure=${exposure_ev}`;
