// The live page: a session that follows the mouse, the fingers and the keys, perhaps a second one
// without what is being compared, and what both take. The scene stands in the address
// (#scene=thesis-room).
import { check_access, list_scenes, on_unauthorized, post_job } from './api.js';
import { LiveCamera } from './live_camera.js';
import { LiveSession } from './live_session.js';
import { SignIn } from './sign_in.js';

const by_id = (id) => document.getElementById(id);
const kSwitches = ['learning', 'recovery', 'reprojection'];
const kStageWords = { moving: 'moving: history and recovery',
  settling: 'at rest: new samples displace the history',
  still: 'at rest: samples, recovered where they are few' };
const kMostSide = 640; // pixels of a picture on the page
const kFrameMs = 75; // a camera waits for up to two frames, the one under way and its own

const sign_in = new SignIn(by_id('sign-in'));
on_unauthorized(() => sign_in.ask());

export const live = { main: null, other: null };
let scenes = [];
let job_settings = {};
let mix = ''; // how a job is lit as the lights are switched

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

export const camera = new LiveCamera(by_id('stage'), () => {
  live.main?.look(camera.camera);
  live.other?.look(camera.camera);
});

function show_measures() {
  const rows = kMeasures.map(([name, text]) => {
    const row = document.createElement('tr');
    const head = document.createElement('th');
    head.scope = 'row';
    head.textContent = name;
    row.append(head);
    for (const session of [live.main, live.other]) {
      if (!session?.frame) continue;
      row.insertCell().textContent = text(session);
    }
    return row;
  });
  by_id('measures').replaceChildren(...rows);
}
setInterval(() => live.main?.frame && show_measures(), 250);

function say(problem) {
  by_id('notice').textContent = problem;
  by_id('notice').hidden = !problem;
}

function on_end(error) {
  by_id('connection').dataset.live = 'false';
  by_id('connection').textContent = 'Ended';
  say(error ? `The session is lost: ${error.message}. Choose the scene again for a new one.`
    : 'The session has ended. Choose the scene again for a new one.');
}

function size_of({ width, height }) {
  const scale = Math.min(1, kMostSide / Math.max(width, height));
  const even = (side) => Math.max(2, 2 * Math.round((side * scale) / 2));
  return { width: even(width), height: even(height) };
}

const switches = () => Object.fromEntries(kSwitches.map((name) => [name, by_id(name).checked]));
function switches_without() {
  const without = by_id('compare').value;
  return Object.fromEntries(kSwitches.map((name) =>
    [name, by_id(name).checked && without !== 'all' && without !== name]));
}
const factors = () => [...by_id('lights').querySelectorAll('input')]
  .map((light) => (light.checked ? 1 : 0));

function label() {
  const off = kSwitches.filter((name) => !by_id(name).checked);
  const stage = live.main?.frame ? kStageWords[live.main.frame.stage] : '';
  by_id('stage-label').textContent = stage + (off.length ? `, without ${off.join(', ')}` : '');
}

function make_session(canvas_id, on_frame) {
  return new LiveSession(by_id(canvas_id), on_frame, on_end);
}

async function open(name) {
  close();
  say('');
  const scene = scenes.find((s) => s.name === name);
  job_settings = { scene: name };
  by_id('waiting').hidden = false;
  const size = size_of(scene);
  by_id('stage').style.setProperty('--w', size.width);
  by_id('stage').style.setProperty('--h', size.height);
  live.main = make_session('left', () => {
    by_id('waiting').hidden = true;
    label();
  });
  if (!live.main.supported) return say('This browser has no WebGL2, which the picture needs.');
  try {
    const info = await live.main.open({ scene: name, ...size, ...switches(), frame_ms: kFrameMs });
    camera.forget();
    // In a picture of all directions one looks around.
    const around = info.camera.projection === 'equirectangular';
    camera.camera = around
      ? { ...info.camera, projection: 'perspective', vertical_fov_deg: 75 } : info.camera;
    if (around) {
      camera.mode = by_id('move').value = 'fly';
      live.main.look(camera.camera);
    }
    live.main.on_stop = (position) => camera.stop_at(position);
    mix = '';
    show_walls();
    show_cameras(info.cameras);
    show_lights(info.lights);
    by_id('connection').dataset.live = 'true';
    by_id('connection').textContent = 'Live';
  } catch (error) {
    live.main = null;
    say(error.message);
    return undefined;
  }
  return compare();
}

// A second session beside the first, without what is compared.
async function compare() {
  live.other?.close();
  live.other = null;
  const without = by_id('compare').value;
  for (const id of ['right', 'other-label', 'split-tool']) by_id(id).hidden = !without;
  document.querySelector('.measures .second').hidden = !without;
  by_id('stage').classList.toggle('split', Boolean(without));
  if (!without || !live.main) return;
  by_id('other-label').textContent = `without ${without === 'all' ? 'any of them' : without}`;
  const { scene, width, height } = live.main.info;
  live.other = make_session('right', () => {});
  live.other.exposure_ev = Number(by_id('exposure').value);
  try {
    await live.other.open({ scene, width, height, ...switches_without(), frame_ms: kFrameMs });
    live.other.look(camera.camera);
    await live.other.put('lights', { factors: factors() });
  } catch (error) {
    live.other = null;
    by_id('compare').value = '';
    say(`There is no second view: ${error.message}`);
    await compare();
  }
}

function close() {
  for (const name of ['main', 'other']) {
    live[name]?.close();
    live[name] = null;
  }
}

function show_walls() {
  if (live.main) live.main.walls = by_id('walls').checked;
}

// Those that the scene names.
function show_cameras(cameras) {
  by_id('camera-tool').hidden = cameras.length === 0;
  by_id('camera').replaceChildren(new Option('choose one', ''),
    ...cameras.map(({ name }, index) => new Option(name, index)));
}

async function switch_lights() {
  try {
    live.other?.put('lights', { factors: factors() });
    const info = await live.main.put('lights', { factors: factors() });
    mix = info.factors.some((factor) => factor !== 1) ? info.mix : '';
    if (!info.mix) say('This scene has more lights than a job can keep apart: a job of this view ' +
      'has them all.');
  } catch (error) {
    say(error.message);
  }
}

function show_lights(names) {
  const labels = names.map((name) => {
    const label_of_light = document.createElement('label');
    const box = document.createElement('input');
    box.type = 'checkbox';
    box.checked = true;
    box.addEventListener('change', switch_lights);
    label_of_light.append(box, ` ${name}`);
    return label_of_light;
  });
  by_id('lights').replaceChildren(by_id('lights').querySelector('legend'), ...labels);
}

async function render_view() {
  const { camera: view } = camera;
  const { width, height } = scenes.find(({ name }) => name === job_settings.scene);
  try {
    const job = await post_job({ ...job_settings, width, height, samples: 64, camera: view,
      ...(mix && { light_groups: 'material', mix }) });
    const link = document.createElement('a');
    link.href = `/#job=${job.id}`;
    link.textContent = job.id;
    by_id('rendered').replaceChildren('This view is job ', link, '.');
  } catch (error) {
    say(error.message);
  }
}

for (const name of kSwitches)
  by_id(name).addEventListener('change', () => {
    live.main?.put('switches', switches()).catch((error) => say(error.message));
    live.other?.put('switches', switches_without()).catch((error) => say(error.message));
  });
by_id('compare').addEventListener('change', compare);
by_id('scene').addEventListener('change', () => {
  history.replaceState(null, '', `#scene=${encodeURIComponent(by_id('scene').value)}`);
  open(by_id('scene').value);
});
by_id('move').addEventListener('change', () => {
  camera.mode = by_id('move').value;
});
by_id('exposure').addEventListener('input', () => {
  for (const session of [live.main, live.other])
    if (session) session.exposure_ev = Number(by_id('exposure').value);
});
by_id('split').addEventListener('input', () => {
  by_id('stage').style.setProperty('--split', `${by_id('split').value}%`);
});
by_id('walls').addEventListener('change', show_walls);
by_id('stage').addEventListener('keydown', ({ code }) => code === 'KeyG' && by_id('walls').click());
by_id('camera').addEventListener('change', ({ target }) => {
  if (target.value && live.main) camera.go_to(live.main.info.cameras[target.value].camera);
});
by_id('home').addEventListener('click', () => camera.go_home());
by_id('render').addEventListener('click', render_view);
addEventListener('pagehide', close);

async function start() {
  await check_access();
  scenes = (await list_scenes()).filter(({ width }) => width);
  by_id('scene').replaceChildren(...scenes.map(({ name, title }) => new Option(title, name)));
  const asked = new URLSearchParams(location.hash.slice(1)).get('scene');
  const names = scenes.map(({ name }) => name);
  const first = [asked, 'thesis-room', names[0]].find((name) => names.includes(name));
  if (!first) return say('The server has no scene.');
  by_id('scene').value = first;
  return open(first);
}
start().catch((error) => say(error.message));
