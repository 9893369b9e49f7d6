// The picture in WebGL2: tiles go as they come (RGB9E5) into one texture; exposure and curve are
// applied when it is drawn, so changing them asks the server for nothing.
import { kFirstLook, kShownGlsl, set_look } from './look.js';

const kTilePx = 64;
const kMostGroups = 64;
const kUnits = { picture: 0, here: 1, groups: 3, others: 4, moved: 5 }; // in 2 tiles are filled in
const kRestFrames = 12; // after a mix has changed, until it is drawn at full size

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
uniform highp sampler2D moved;
uniform vec3 factor;  // of the group moved
uniform int coarse;  // texels of the picture along a side of a pixel that is drawn
out vec4 color;
${kShownGlsl}
void main() {
  ivec2 size = (textureSize(picture, 0) + coarse - 1) / coarse;
  ivec2 p = ivec2(int(gl_FragCoord.x), size.y - 1 - int(gl_FragCoord.y));
  if (texelFetch(here, p * coarse / ${kTilePx}, 0).r < 0.5) {
    color = vec4(0.0);
    return;
  }
  vec3 v = scaled(mixing ? texelFetch(others, p, 0).rgb + factor * texelFetch(moved, p, 0).rgb
    : texelFetch(picture, p, 0).rgb);
  color = vec4(shown(v), 1.0);
  if (clipped && (p.x + p.y) % 4 < 2) {
    if (max(v.r, max(v.g, v.b)) > 1.0) color.rgb = vec3(1.0, 0.1, 0.1);
    else if (max(v.r, max(v.g, v.b)) <= 0.0) color.rgb = vec3(0.1, 0.3, 1.0);
  }
}`;

// The groups' light, apart from the one that moves: while a slider is drawn, a frame costs two
// texels a pixel. A pixel stands for coarse x coarse texels, of which four are read.
const kSumShader = `#version 300 es
precision highp float;
precision highp int;
uniform highp sampler2DArray groups;
uniform vec3 factors[${kMostGroups}];  // that of the group moving is not read
uniform int count;
uniform int moving;  // -1: none
uniform int coarse;
uniform ivec2 corner;
layout(location = 0) out vec4 others;
layout(location = 1) out vec4 moved;
void main() {
  ivec2 first = corner + coarse * ivec2(gl_FragCoord.xy);
  ivec2 last = textureSize(groups, 0).xy - 1;
  vec3 sum = vec3(0.0);
  vec3 one = vec3(0.0);
  int n = min(coarse, 2);
  for (int i = 0; i < n * n; ++i) {
    ivec2 p = min(first + (2 * ivec2(i % n, i / n) + 1) * coarse / (2 * n), last);
    for (int g = 0; g < count; ++g) {
      vec3 light = texelFetch(groups, ivec3(p, g), 0).rgb;
      if (g == moving) one += light;
      else sum += factors[g] * light;
    }
  }
  float share = 1.0 / float(n * n);
  others = vec4(sum * share, 1.0);
  moved = vec4(one * share, 1.0);
}`;

export class TileCanvas {
  #canvas;
  #gl;
  #program = null;
  #sum_program = null;
  #textures = []; // the picture, which tiles came, and the groups of lights once they are mixed
  #mix = null; // factors of the groups
  #sums = null; // {factors, moving, coarse, frame_buffer, textures}: what was added up for a mix
  #probe = null; // the same of one pixel
  #restless = 0; // frames until the mix is at rest
  zoom = 1; // of the canvas on the screen, over its size in the layout
  #width = 0;
  #height = 0;
  #look = kFirstLook;
  #here = new Uint8Array(0); // a byte a tile: 1 when it came
  #frame = 0; // the animation's request
  #dirty = false; // what is to be seen is not drawn yet
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
      this.#textures.push(this.#new_texture(kUnits.groups, gl.RGB9_E5, width, height, count));
    }
    gl.activeTexture(gl.TEXTURE0 + kUnits.groups);
    for (const { x, y, w, h, pixels } of tiles) {
      gl.texSubImage3D(gl.TEXTURE_2D_ARRAY, 0, x, y, group, w, h, 1, gl.RGB,
        gl.UNSIGNED_INT_5_9_9_9_REV, pixels);
    }
    gl.activeTexture(gl.TEXTURE2);
    this.#forget_sums();
    this.#draw_soon();
  }

  get can_mix() {
    return this.supported && this.#gl.getExtension('EXT_color_buffer_float') !== null;
  }

  // Factors of the groups ([r, g, b] each), or null: the picture as it was rendered. While they
  // change it is drawn about as large as it is shown, then at full size.
  set mix(factors) {
    if (String(factors) === String(this.#mix)) return;
    this.#mix = factors;
    this.#restless = kRestFrames;
    this.#draw_soon();
  }

  // The picture's width on the screen, as it is laid out now: a frame may be drawn before an
  // observer of sizes is told.
  shown_px() {
    return this.#canvas.clientWidth * this.zoom * devicePixelRatio;
  }

  // What a mix makes of a pixel.
  mixed_at(x, y) {
    const gl = this.#gl;
    this.#probe ??= this.#new_sums(1, 1);
    this.#add_up(this.#probe, { moving: -1, coarse: 1, corner: [x, y], width: 1, height: 1 });
    const sum = new Float32Array(4);
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.#probe.frame_buffer);
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.FLOAT, sum);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
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
    this.#restless = 0;
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
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    this.#program = program;
    this.#sum_program = this.#new_program(kSumShader);
    gl.uniform1i(gl.getUniformLocation(this.#sum_program, 'groups'), kUnits.groups);
    this.#textures = [];
    this.#sums = this.#probe = null; // they went with the context
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
    this.#forget_sums();
    const tiles_x = Math.ceil(width / kTilePx);
    const tiles_y = Math.ceil(height / kTilePx);
    this.#here = new Uint8Array(tiles_x * tiles_y);
    this.#textures = [this.#new_texture(0, gl.RGB9_E5, width, height),
      this.#new_texture(1, gl.R8, tiles_x, tiles_y)];
    gl.activeTexture(gl.TEXTURE2);  // unit 2 is where textures are filled
    this.#width = width;
    this.#height = height;
  }

  // `layers`: of an array of textures.
  #new_texture(unit, format, width, height, layers = 0) {
    const gl = this.#gl;
    const kind = layers ? gl.TEXTURE_2D_ARRAY : gl.TEXTURE_2D;
    const texture = gl.createTexture();
    gl.activeTexture(gl.TEXTURE0 + unit);
    gl.bindTexture(kind, texture);
    if (layers) gl.texStorage3D(kind, 1, format, width, height, layers);
    else gl.texStorage2D(kind, 1, format, width, height);
    gl.texParameteri(kind, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
    gl.texParameteri(kind, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
    return texture;
  }

  #draw_soon() {
    this.#dirty = true;
    if (!this.#frame && this.#width) this.#frame = requestAnimationFrame(() => this.#next_frame());
  }

  // Rest is counted in frames and not in time, as frames wait for a machine that is slow.
  #next_frame() {
    const coming_to_rest = this.#restless > 0 && --this.#restless === 0;
    if (this.#dirty || coming_to_rest) this.#draw();
    this.#dirty = false;
    this.#frame = this.#restless ? requestAnimationFrame(() => this.#next_frame()) : 0;
  }

  // Where sums go: the other groups, and the one that moves.
  #new_sums(width, height) {
    const gl = this.#gl;
    const frame_buffer = gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, frame_buffer);
    const places = [gl.COLOR_ATTACHMENT0, gl.COLOR_ATTACHMENT1];
    const textures = places.map((place) => {
      const texture = this.#new_texture(2, gl.RGBA32F, width, height);
      gl.framebufferTexture2D(gl.FRAMEBUFFER, place, gl.TEXTURE_2D, texture, 0);
      return texture;
    });
    gl.drawBuffers(places);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    return { frame_buffer, textures };
  }

  #forget_sums() {
    if (!this.#sums) return;
    this.#sums.textures.forEach((texture) => this.#gl.deleteTexture(texture));
    this.#gl.deleteFramebuffer(this.#sums.frame_buffer);
    this.#sums = null;
  }

  #add_up({ frame_buffer }, { moving, coarse, corner, width, height }) {
    const gl = this.#gl;
    gl.useProgram(this.#sum_program);
    gl.bindFramebuffer(gl.FRAMEBUFFER, frame_buffer);
    const place = (name) => gl.getUniformLocation(this.#sum_program, name);
    gl.uniform1i(place('count'), this.#mix.length);
    gl.uniform3fv(place('factors'), this.#mix.flat());
    gl.uniform1i(place('moving'), moving);
    gl.uniform1i(place('coarse'), coarse);
    gl.uniform2iv(place('corner'), corner);
    gl.viewport(0, 0, width, height);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  }

  // What a mix is drawn from. It serves until another group moves than the one that is apart.
  #prepare_mix(coarse, width, height) {
    const old = this.#sums;
    const differ = this.#mix.flatMap((v, g) =>
      (String(v) === String(old?.factors[g]) ? [] : [g]));
    if (old?.coarse === coarse && differ.every((g) => g === old.moving)) return;
    const moving = differ.length === 1 ? differ[0] : old?.moving ?? 0;
    if (old?.coarse !== coarse) {
      this.#forget_sums();
      this.#sums = this.#new_sums(width, height);
    }
    this.#add_up(this.#sums, { moving, coarse, corner: [0, 0], width, height });
    Object.assign(this.#sums, { moving, coarse, factors: this.#mix });
  }

  #draw() {
    if (!this.#width) return;
    const gl = this.#gl;
    const mixing = this.#mix !== null && this.#textures.length > 2;
    const coarse = mixing && this.#restless
      ? Math.max(1, Math.round(this.#width / (this.shown_px() || this.#width))) : 1;
    const [width, height] = [this.#width, this.#height].map((side) => Math.ceil(side / coarse));
    if (mixing) this.#prepare_mix(coarse, width, height);
    // Setting a canvas' size empties it.
    if (this.#canvas.width !== width) this.#canvas.width = width;
    if (this.#canvas.height !== height) this.#canvas.height = height;
    gl.viewport(0, 0, width, height);
    gl.useProgram(this.#program);
    const place = (name) => gl.getUniformLocation(this.#program, name);
    gl.uniform1i(place('mixing'), mixing ? 1 : 0);
    gl.uniform1i(place('coarse'), coarse);
    if (mixing) {
      const { moving, textures } = this.#sums;
      [kUnits.others, kUnits.moved].forEach((unit, i) => {
        gl.activeTexture(gl.TEXTURE0 + unit);
        gl.bindTexture(gl.TEXTURE_2D, textures[i]);
      });
      gl.activeTexture(gl.TEXTURE2);
      gl.uniform3fv(place('factor'), this.#mix[moving]);
    }
    gl.uniform1i(place('clipped'), this.#look.clipped ? 1 : 0);
    set_look(gl, this.#program, this.#look);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }
}
