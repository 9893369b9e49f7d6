// How radiance becomes colour: the exposure and the curves, the same in the shader, in the legend
// and in words. False colour is viridis over stops of luminance: its lightness rises evenly, so it
// can be read without seeing hues.

// Every sixteenth of matplotlib's viridis (CC0), sRGB.
export const kViridis = ['#440154', '#481a6c', '#472f7d', '#414487', '#39568c', '#31688e',
  '#2a788e', '#23888e', '#1f988b', '#22a884', '#35b779', '#54c568', '#7ad151', '#a5db36',
  '#d2e21b', '#fde725'];
export const kFalseStops = [-8, 4]; // below and above white, at exposure 0
export const kCurves = ['srgb', 'gamma', 'filmic', 'false'];
export const kChannels = ['', 'r', 'g', 'b', 'luminance']; // '': colour

const channel = (hex, at) => parseInt(hex.slice(at, at + 2), 16) / 255;
export const rgb_of = (hex) => [1, 3, 5].map((at) => channel(hex, at));

// 0..1 -> css colour
export function viridis(share) {
  const at = Math.min(Math.max(share, 0), 1) * (kViridis.length - 1);
  const [low, high] = [Math.floor(at), Math.ceil(at)].map((i) => rgb_of(kViridis[i]));
  const mixed = low.map((v, i) => Math.round(255 * (v + (high[i] - v) * (at - Math.floor(at)))));
  return `rgb(${mixed.join(' ')})`;
}

export const luminance = ([r, g, b]) => 0.2126 * r + 0.7152 * g + 0.0722 * b;

// Sets the uniforms of these functions; `view`: {ev, offset, channel, curve, gamma}.
export function set_look(gl, program, view) {
  const place = (name) => gl.getUniformLocation(program, name);
  gl.uniform1f(place('gain'), 2 ** view.ev);
  gl.uniform1f(place('offset'), view.offset);
  gl.uniform1i(place('channel'), kChannels.indexOf(view.channel));
  gl.uniform1i(place('curve'), kCurves.indexOf(view.curve));
  gl.uniform1f(place('gamma'), view.gamma);
  gl.uniform3fv(place('map'), kViridis.flatMap(rgb_of));
}
// As a picture is shown at first.
export const kFirstLook = { ev: 0, offset: 0, channel: '', curve: 'srgb', gamma: 2.2, clipped: '' };

// The shader's functions: scaled(radiance), which is white at 1, and shown(scaled). Uniforms: gain,
// offset, channel, curve and gamma.
// Filmic: Narkowicz, "ACES filmic tone mapping curve" (2015).
export const kShownGlsl = `
uniform float gain;
uniform float offset;
uniform int channel;
uniform int curve;
uniform float gamma;
uniform vec3 map[${kViridis.length}];
vec3 srgb(vec3 v) {
  vec3 c = 1.055 * pow(max(v, vec3(1e-6)), vec3(1.0 / 2.4)) - 0.055;
  return mix(c, 12.92 * v, vec3(lessThanEqual(v, vec3(0.0031308))));
}
vec3 scaled(vec3 radiance) {
  vec3 v = radiance;
  if (channel == ${kChannels.indexOf('luminance')}) v = vec3(dot(v, vec3(0.2126, 0.7152, 0.0722)));
  else if (channel > 0) v = vec3(v[channel - 1]);
  return v * gain + offset;
}
vec3 shown(vec3 v) {
  if (curve == ${kCurves.indexOf('gamma')}) return pow(clamp(v, 0.0, 1.0), vec3(1.0 / gamma));
  if (curve == ${kCurves.indexOf('filmic')}) {
    return srgb(clamp(v * (2.51 * v + 0.03) / (v * (2.43 * v + 0.59) + 0.14), 0.0, 1.0));
  }
  if (curve == ${kCurves.indexOf('false')}) {
    float stops = log2(max(dot(v, vec3(0.2126, 0.7152, 0.0722)), 1e-12));
    float at = (stops - float(${kFalseStops[0]})) / float(${kFalseStops[1] - kFalseStops[0]});
    at = clamp(at, 0.0, 1.0) * ${(kViridis.length - 1).toFixed(1)};
    int low = min(int(at), ${kViridis.length - 2});
    return mix(map[low], map[low + 1], at - float(low));
  }
  return srgb(clamp(v, 0.0, 1.0));
}`;
