// A job's equirectangular picture from inside: the address has the job and its exposure
// (#j000001,0.5). Drag, the arrow keys, the wheel, plus and minus move the view.
import { get_picture, on_unauthorized, png_url } from './api.js';
import { SignIn } from './sign_in.js';

const by_id = (id) => document.getElementById(id);
const sign_in = new SignIn();
on_unauthorized(() => sign_in.ask());
const kLeastFov = 0.2, kMostFov = 2.4; // radians, from the lower edge to the upper one
const kKeyTurn = 0.1; // radians

const kVertexShader = `#version 300 es
out vec2 at;
void main() {  // one triangle over the whole canvas
  at = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
  gl_Position = vec4(at, 0.0, 1.0);
}`;
const kFragmentShader = `#version 300 es
precision highp float;
uniform sampler2D picture;
uniform vec2 turn;  // to the right and up, radians
uniform vec2 half_size;  // of the view, at distance 1
in vec2 at;
out vec4 color;
void main() {
  vec3 d = normalize(vec3(at * half_size, 1.0));  // right, up, ahead
  d.yz = vec2(d.y * cos(turn.y) + d.z * sin(turn.y), d.z * cos(turn.y) - d.y * sin(turn.y));
  float longitude = atan(d.x, d.z) + turn.x;
  float polar = acos(clamp(d.y, -1.0, 1.0));
  color = texture(picture, vec2(longitude / 6.28318531 + 0.5, polar / 3.14159265));
}`;

export const view = { right: 0, up: 0, fov: 1.2 };
const canvas = by_id('picture');
const gl = canvas.getContext('webgl2', { antialias: false, preserveDrawingBuffer: true });

function say(problem) {
  by_id('notice').textContent = problem;
  by_id('notice').hidden = !problem;
}

let program = null;
function draw() {
  if (!program) return;
  [canvas.width, canvas.height] = [canvas.clientWidth, canvas.clientHeight]
    .map((side) => Math.max(1, Math.round(side * devicePixelRatio)));
  gl.viewport(0, 0, canvas.width, canvas.height);
  const half = Math.tan(view.fov / 2);
  gl.uniform2f(gl.getUniformLocation(program, 'turn'), view.right, view.up);
  gl.uniform2f(gl.getUniformLocation(program, 'half_size'), half * canvas.width / canvas.height,
    half);
  gl.drawArrays(gl.TRIANGLES, 0, 3);
}

function look(right, up, zoom = 1) {
  view.right = (view.right + right) % (2 * Math.PI);
  view.up = Math.min(Math.max(view.up + up, -Math.PI / 2), Math.PI / 2);
  view.fov = Math.min(Math.max(view.fov * zoom, kLeastFov), kMostFov);
  draw();
}

function start(bitmap) {
  program = gl.createProgram();
  for (const [type, text] of [[gl.VERTEX_SHADER, kVertexShader],
    [gl.FRAGMENT_SHADER, kFragmentShader]]) {
    const shader = gl.createShader(type);
    gl.shaderSource(shader, text);
    gl.compileShader(shader);
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  gl.useProgram(program);
  gl.bindTexture(gl.TEXTURE_2D, gl.createTexture());
  gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, gl.RGBA, gl.UNSIGNED_BYTE, bitmap);
  for (const [name, value] of [[gl.TEXTURE_MIN_FILTER, gl.LINEAR],
    [gl.TEXTURE_WRAP_S, gl.REPEAT], [gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE]])
    gl.texParameteri(gl.TEXTURE_2D, name, value);
  draw();
}

const stage = by_id('stage');
stage.style.setProperty('--w', 16);
stage.style.setProperty('--h', 9);
stage.addEventListener('pointerdown', (event) => stage.setPointerCapture(event.pointerId));
stage.addEventListener('pointermove', (event) => {
  if (!stage.hasPointerCapture(event.pointerId)) return;
  const turn = view.fov / stage.clientHeight; // what is under the pointer stays there
  look(-event.movementX * turn, event.movementY * turn);
});
stage.addEventListener('wheel', (event) => {
  event.preventDefault();
  look(0, 0, Math.exp(event.deltaY * 0.001));
}, { passive: false });
const kKeys = { ArrowLeft: [-kKeyTurn, 0], ArrowRight: [kKeyTurn, 0], ArrowUp: [0, kKeyTurn],
  ArrowDown: [0, -kKeyTurn], '+': [0, 0, 0.9], '-': [0, 0, 1.1] };
stage.addEventListener('keydown', (event) => {
  if (!(event.key in kKeys)) return;
  event.preventDefault();
  look(...kKeys[event.key]);
});
new ResizeObserver(draw).observe(stage);

const [job, exposure] = location.hash.slice(1).split(',');
by_id('job').href = `/#job=${job}`;
if (!gl) {
  say('This browser has no WebGL2, which the picture needs.');
} else {
  get_picture(png_url(job, 'sampled', exposure || 0)).then(createImageBitmap).then(start)
    .catch((error) => say(error.message));
}
