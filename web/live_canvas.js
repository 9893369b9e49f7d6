// A live frame in WebGL2: a texture of linear light (RGB9E5, or sRGB of a decoded JPEG) that fills
// the canvas, smoothed where the frame is smaller; exposure and curve in the shader.
import { kFirstLook, kShownGlsl, set_look } from './look.js';

const kVertexShader = `#version 300 es
out vec2 at;
void main() {  // one triangle over the whole canvas
  vec2 p = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
  at = vec2(p.x, -p.y) * 0.5 + 0.5;
  gl_Position = vec4(p, 0.0, 1.0);
}`;

const kFragmentShader = `#version 300 es
precision highp float;
precision highp int;
uniform highp sampler2D picture;
in vec2 at;
out vec4 color;
${kShownGlsl}
void main() {
  color = vec4(shown(scaled(texture(picture, at).rgb)), 1.0);
}`;

export class LiveCanvas {
  #canvas;
  #gl;
  #program;
  #texture = null;
  #width = 0;
  #height = 0;
  #is_bitmap = false;
  #look = kFirstLook;

  // `width`, `height`: of the picture at its largest.
  constructor(canvas, width, height) {
    this.#canvas = canvas;
    canvas.width = width;
    canvas.height = height;
    this.#gl = canvas.getContext('webgl2',
      { antialias: false, depth: false, preserveDrawingBuffer: true });
    if (!this.#gl) return;
    this.#start();
    canvas.addEventListener('webglcontextlost', (event) => event.preventDefault());
    canvas.addEventListener('webglcontextrestored', () => this.#start());
  }

  get supported() {
    return this.#gl !== null;
  }
  // {ev, offset, channel, curve, gamma} as in the address
  set look(value) {
    this.#look = value;
    this.#draw();
  }
  resize(width, height) {
    this.#canvas.width = width;
    this.#canvas.height = height;
  }

  // `picture`: a Uint32Array of RGB9E5 in rows from the top, or an ImageBitmap.
  show(width, height, picture) {
    const gl = this.#gl;
    const is_bitmap = picture instanceof ImageBitmap;
    if (width !== this.#width || height !== this.#height || is_bitmap !== this.#is_bitmap) {
      this.#make_texture(width, height, is_bitmap);
    }
    if (is_bitmap) {
      gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, gl.RGBA, gl.UNSIGNED_BYTE, picture);
      picture.close();
    } else {
      gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, width, height, gl.RGB,
        gl.UNSIGNED_INT_5_9_9_9_REV, picture);
    }
    this.#draw();
  }

  #make_texture(width, height, is_bitmap) {
    const gl = this.#gl;
    gl.deleteTexture(this.#texture);
    this.#texture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, this.#texture);
    gl.texStorage2D(gl.TEXTURE_2D, 1, is_bitmap ? gl.SRGB8_ALPHA8 : gl.RGB9_E5, width, height);
    for (const [name, value] of [[gl.TEXTURE_MIN_FILTER, gl.LINEAR],
      [gl.TEXTURE_MAG_FILTER, gl.LINEAR], [gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE],
      [gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE]]) gl.texParameteri(gl.TEXTURE_2D, name, value);
    [this.#width, this.#height, this.#is_bitmap] = [width, height, is_bitmap];
  }

  #start() {
    const gl = this.#gl;
    this.#program = gl.createProgram();
    for (const [type, text] of [[gl.VERTEX_SHADER, kVertexShader],
      [gl.FRAGMENT_SHADER, kFragmentShader]]) {
      const shader = gl.createShader(type);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      gl.attachShader(this.#program, shader);
    }
    gl.linkProgram(this.#program);
    gl.useProgram(this.#program);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    this.#texture = null;
    this.#width = this.#height = 0;
  }

  #draw() {
    if (!this.#gl || !this.#texture) return;
    const gl = this.#gl;
    gl.viewport(0, 0, this.#canvas.width, this.#canvas.height);
    set_look(gl, this.#program, this.#look);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }
}
