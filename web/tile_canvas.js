// The picture in WebGL2: tiles go as they come (RGB9E5) into one texture; exposure and curve are
// applied when it is drawn, so changing them asks the server for nothing.
import { kChannels, kCurves, kShownGlsl, kViridis, rgb_of } from './look.js';

const kTilePx = 64;
const kMostGroups = 64;
const kUnits = { picture: 0, here: 1, groups: 3, others: 4 }; // 2 is where tiles are filled in

const kVertexShader = `#version 300 es
void main() {  // one triangle over the whole canvas
  gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0);
}`;

const kFragmentShader = `#version 300 es
precision highp float;
precision highp int;
uniform highp sampler2D picture;
uniform highp sampler2D here;  // one texel a tile: 1 when it came
uniform bool clipped;  // stripes where the picture is brighter than white, or black
uniform bool mixing;  // the picture is what others has and one group of lights more
uniform highp sampler2D others;
uniform highp sampler2DArray groups;
uniform int moving;
uniform vec3 factor;  // of the group moving
out vec4 color;
${kShownGlsl}
void main() {
  ivec2 size = textureSize(picture, 0);
  ivec2 p = ivec2(int(gl_FragCoord.x), size.y - 1 - int(gl_FragCoord.y));
  if (texelFetch(here, p / ${kTilePx}, 0).r < 0.5) {
    color = vec4(0.0);
    return;
  }
  vec3 radiance = texelFetch(picture, p, 0).rgb;
  if (mixing) radiance = texelFetch(others, p, 0).rgb
    + factor * texelFetch(groups, ivec3(p, moving), 0).rgb;
  vec3 v = scaled(radiance);
  color = vec4(shown(v), 1.0);
  if (clipped && (p.x + p.y) % 4 < 2) {
    if (max(v.r, max(v.g, v.b)) > 1.0) color.rgb = vec3(1.0, 0.1, 0.1);
    else if (max(v.r, max(v.g, v.b)) <= 0.0) color.rgb = vec3(0.1, 0.3, 1.0);
  }
}`;

// All groups but the one that moves: while a slider is drawn, a frame costs two texels a pixel.
const kOthersShader = `#version 300 es
precision highp float;
precision highp int;
uniform highp sampler2DArray groups;
uniform vec3 factors[${kMostGroups}];
uniform int count;
out vec4 sum;
void main() {
  ivec2 p = ivec2(gl_FragCoord.xy);
  sum = vec4(0.0);
  for (int g = 0; g < count; ++g) sum.rgb += factors[g] * texelFetch(groups, ivec3(p, g), 0).rgb;
}`;

export class TileCanvas {
  #canvas;
  #gl;
  #program = null;
  #others_program = null;
  #textures = [];
  #mix = null; // factors of the groups
  #drawn = null; // of them, in `others`; that of #moving is not in it
  #moving = 0;
  #frame_buffer = null;
  #width = 0;
  #height = 0;
  #look = { ev: 0, offset: 0, channel: '', curve: 'srgb', gamma: 2.2, clipped: '' };
  #here = new Uint8Array(0); // a byte a tile: 1 when it came
  #frame = 0;
  #tile_updates = 0;

  // on_restored: the graphics context came back empty, so the tiles must be fetched again.
  constructor(canvas, on_restored) {
    this.#canvas = canvas;
    this.#gl = canvas.getContext('webgl2', { antialias: false, depth: false });
    if (!this.#gl) return;
    this.#start();
    canvas.addEventListener('webglcontextlost', (event) => event.preventDefault());
    canvas.addEventListener('webglcontextrestored', () => {
      this.#start();
      this.clear();
      on_restored();
    });
  }

  get supported() {
    return this.#gl !== null;
  }
  get width() {
    return this.#width;
  }
  get height() {
    return this.#height;
  }
  get max_px() {
    return this.#gl.getParameter(this.#gl.MAX_TEXTURE_SIZE);
  }
  // Tiles put since clear(), counting each version of a tile.
  get tile_updates() {
    return this.#tile_updates;
  }

  has_tile(x, y) {
    return x < this.#width && y < this.#height && this.#here[this.#tile_at(x, y)] === 1;
  }
  #tile_at(x, y) {
    return Math.floor(y / kTilePx) * Math.ceil(this.#width / kTilePx) + Math.floor(x / kTilePx);
  }

  clear() {
    this.#width = this.#height = 0;
    this.#here = new Uint8Array(0);
    this.#tile_updates = 0;
    this.#canvas.width = this.#canvas.height = 1;
  }

  put({ width, height, tiles }) {
    if (!this.supported || width === 0 || height === 0) return;
    if (width !== this.#width || height !== this.#height) this.#resize(width, height);
    const gl = this.#gl;
    const [picture, here] = this.#textures;
    const came = new Uint8Array([255]);
    for (const { x, y, w, h, pixels } of tiles) {
      this.#here[this.#tile_at(x, y)] = 1;
      gl.bindTexture(gl.TEXTURE_2D, picture);
      gl.texSubImage2D(gl.TEXTURE_2D, 0, x, y, w, h, gl.RGB, gl.UNSIGNED_INT_5_9_9_9_REV, pixels);
      gl.bindTexture(gl.TEXTURE_2D, here);
      gl.texSubImage2D(gl.TEXTURE_2D, 0, Math.floor(x / kTilePx), Math.floor(y / kTilePx), 1, 1,
        gl.RED, gl.UNSIGNED_BYTE, came);
    }
    this.#tile_updates += tiles.length;
    this.#draw_soon();
  }

  // Of `count` groups of lights, tiles of one; they are shown while there is a mix.
  put_group(group, count, { width, height, tiles }) {
    if (!this.supported || width !== this.#width || height !== this.#height) return;
    const gl = this.#gl;
    if (this.#textures.length === 2) {
      gl.activeTexture(gl.TEXTURE0 + kUnits.groups);
      const groups = gl.createTexture();
      gl.bindTexture(gl.TEXTURE_2D_ARRAY, groups);
      gl.texStorage3D(gl.TEXTURE_2D_ARRAY, 1, gl.RGB9_E5, width, height, count);
      for (const filter of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) {
        gl.texParameteri(gl.TEXTURE_2D_ARRAY, filter, gl.NEAREST);
      }
      const others = this.#new_texture(kUnits.others, gl.RGBA32F, width, height);
      this.#textures.push(groups, others);
      this.#frame_buffer = gl.createFramebuffer();
      gl.bindFramebuffer(gl.FRAMEBUFFER, this.#frame_buffer);
      gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, others, 0);
      gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    }
    gl.activeTexture(gl.TEXTURE0 + kUnits.groups);
    for (const { x, y, w, h, pixels } of tiles) {
      gl.texSubImage3D(gl.TEXTURE_2D_ARRAY, 0, x, y, group, w, h, 1, gl.RGB,
        gl.UNSIGNED_INT_5_9_9_9_REV, pixels);
    }
    gl.activeTexture(gl.TEXTURE2);
    this.#drawn = null;
    this.#draw_soon();
  }

  get can_mix() {
    return this.supported && this.#gl.getExtension('EXT_color_buffer_float') !== null;
  }

  // Factors of the groups ([r, g, b] each), or null: the picture as it was rendered.
  set mix(factors) {
    this.#mix = factors;
    this.#draw_soon();
  }

  // What a mix makes of a pixel.
  mixed_at(x, y) {
    const gl = this.#gl;
    gl.enable(gl.SCISSOR_TEST);
    gl.scissor(x, y, 1, 1);
    this.#draw_others(-1);
    gl.disable(gl.SCISSOR_TEST);
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.#frame_buffer);
    const sum = new Float32Array(4);
    gl.readPixels(x, y, 1, 1, gl.RGBA, gl.FLOAT, sum);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    this.#drawn = null;
    return [...sum.subarray(0, 3)];
  }

  // {ev, offset, channel, curve, gamma, clipped} as in the address
  set look(value) {
    this.#look = value;
    this.#draw_soon();
  }

  // What the canvas shows: RGBA bytes in rows from the top.
  read_pixels() {
    const gl = this.#gl;
    const [width, height, row] = [this.#width, this.#height, this.#width * 4];
    this.#draw();
    const from_bottom = new Uint8Array(row * height);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, from_bottom);
    const from_top = new Uint8Array(row * height);
    for (let y = 0; y < height; ++y) {
      from_top.set(from_bottom.subarray(y * row, (y + 1) * row), (height - 1 - y) * row);
    }
    return from_top;
  }

  #start() {
    const gl = this.#gl;
    const program = this.#new_program(kFragmentShader);
    for (const [name, unit] of Object.entries(kUnits)) {
      gl.uniform1i(gl.getUniformLocation(program, name), unit);
    }
    gl.uniform3fv(gl.getUniformLocation(program, 'map'), kViridis.flatMap(rgb_of));
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    this.#program = program;
    this.#others_program = this.#new_program(kOthersShader);
    gl.uniform1i(gl.getUniformLocation(this.#others_program, 'groups'), kUnits.groups);
    this.#textures = [];
  }

  #new_program(fragment_shader) {
    const gl = this.#gl;
    const program = gl.createProgram();
    for (const [type, text] of [[gl.VERTEX_SHADER, kVertexShader],
      [gl.FRAGMENT_SHADER, fragment_shader]]) {
      const shader = gl.createShader(type);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS) && !gl.isContextLost()) {
      throw new Error(`shaders: ${gl.getProgramInfoLog(program)}`);
    }
    gl.useProgram(program);
    return program;
  }

  #resize(width, height) {
    const gl = this.#gl;
    this.#textures.forEach((texture) => gl.deleteTexture(texture));
    this.#drawn = null;
    const tiles_x = Math.ceil(width / kTilePx);
    const tiles_y = Math.ceil(height / kTilePx);
    this.#here = new Uint8Array(tiles_x * tiles_y);
    this.#textures = [this.#new_texture(0, gl.RGB9_E5, width, height),
      this.#new_texture(1, gl.R8, tiles_x, tiles_y)];
    gl.activeTexture(gl.TEXTURE2);  // unit 2 is where textures are filled
    this.#canvas.width = this.#width = width;
    this.#canvas.height = this.#height = height;
    gl.viewport(0, 0, width, height);
  }

  #new_texture(unit, format, width, height) {
    const gl = this.#gl;
    const texture = gl.createTexture();
    gl.activeTexture(gl.TEXTURE0 + unit);
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.texStorage2D(gl.TEXTURE_2D, 1, format, width, height);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
    return texture;
  }

  #draw_soon() {
    if (this.#frame || !this.#width) return;
    this.#frame = requestAnimationFrame(() => {
      this.#frame = 0;
      this.#draw();
    });
  }

  // Into `others`, all but one of them.
  #draw_others(moving) {
    const gl = this.#gl;
    gl.useProgram(this.#others_program);
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.#frame_buffer);
    const place = (name) => gl.getUniformLocation(this.#others_program, name);
    gl.uniform1i(place('count'), this.#mix.length);
    gl.uniform3fv(place('factors'), this.#mix.flatMap((v, g) => (g === moving ? [0, 0, 0] : v)));
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    this.#drawn = this.#mix;
    this.#moving = moving;
  }

  // Whether a mix is shown; what is drawn needs nothing but one group more.
  #prepare_mix() {
    if (!this.#mix || this.#textures.length === 2) return false;
    const differ = this.#mix.flatMap((v, g) => (String(v) === String(this.#drawn?.[g]) ? [] : [g]));
    if (!this.#drawn || differ.some((g) => g !== this.#moving)) this.#draw_others(differ[0]);
    return true;
  }

  #draw() {
    if (!this.#width) return;
    const gl = this.#gl;
    const mixing = this.#prepare_mix();
    gl.useProgram(this.#program);
    const place = (name) => gl.getUniformLocation(this.#program, name);
    gl.uniform1i(place('mixing'), mixing ? 1 : 0);
    if (mixing) {
      gl.uniform1i(place('moving'), this.#moving);
      gl.uniform3fv(place('factor'), this.#mix[this.#moving]);
    }
    gl.uniform1f(place('gain'), 2 ** this.#look.ev);
    gl.uniform1f(place('offset'), this.#look.offset);
    gl.uniform1i(place('channel'), kChannels.indexOf(this.#look.channel));
    gl.uniform1i(place('clipped'), this.#look.clipped ? 1 : 0);
    gl.uniform1i(place('curve'), kCurves.indexOf(this.#look.curve));
    gl.uniform1f(place('gamma'), this.#look.gamma);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }
}
