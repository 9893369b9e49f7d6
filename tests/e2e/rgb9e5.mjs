// The tests' own reading of a tile answer, written from docs/api.md and the OpenGL specification
// and apart from web/tiles.js, so that a mistake there is seen.
import assert from 'node:assert/strict';

const srgb_byte = (v) => {
  const x = Math.min(1, Math.max(0, v));
  return 255 * (x <= 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055);
};

// Per channel of each pixel: its radiance, the display value it must have after rounding to RGB9E5,
// and the interval that the value before that rounding can have had.
export function display_values(buffer, exposure_ev = 0) {
  const bytes = Buffer.from(buffer);
  assert.equal(bytes.toString('latin1', 0, 4), 'QRT1');
  const width = bytes.readUInt32LE(4);
  const height = bytes.readUInt32LE(8);
  assert.equal(bytes.readUInt32LE(24), 0, 'tiles left out');
  const [value, least, most, linear] = Array.from({ length: 4 },
    () => new Float64Array(width * height * 3));
  const gain = 2 ** exposure_ev;
  let at = 28;
  for (let tile = bytes.readUInt32LE(20); tile > 0; --tile) {
    const [x, y, w, h] = [0, 4, 8, 12].map((o) => bytes.readUInt32LE(at + o));
    at += 24;
    for (let i = 0; i < w * h; ++i, at += 4) {
      const word = bytes.readUInt32LE(at);
      const step = 2 ** ((word >>> 27) - 24);
      const out = ((y + Math.floor(i / w)) * width + x + (i % w)) * 3;
      for (let c = 0; c < 3; ++c) {
        const v = ((word >>> (9 * c)) & 511) * step;
        linear[out + c] = v;
        value[out + c] = srgb_byte(v * gain);
        least[out + c] = srgb_byte((v - step / 2) * gain);
        most[out + c] = srgb_byte((v + step / 2) * gain);
      }
    }
  }
  return { width, height, value, least, most, linear };
}

// RGBA bytes against what the tiles say: every channel inside its interval, one level for rounding
// to 8 bits.
export function expect_inside(rgba, { width, height, value, least, most }, exact) {
  assert.equal(rgba.length, width * height * 4);
  let lit = 0;
  for (let i = 0; i < width * height; ++i) {
    assert.equal(rgba[i * 4 + 3], 255, `pixel ${i}: alpha`);
    for (let c = 0; c < 3; ++c) {
      const got = rgba[i * 4 + c];
      const k = i * 3 + c;
      const [low, high] = exact ? [value[k], value[k]] : [least[k], most[k]];
      assert.ok(got >= low - 1 && got <= high + 1,
        `pixel (${i % width}, ${Math.floor(i / width)}) channel ${c}: ` +
        `${got}, expected ${low.toFixed(2)}..${high.toFixed(2)}`);
      if (got > 8) ++lit;
    }
  }
  // A black or an empty picture would pass everything above.
  assert.ok(lit > width * height * 0.1, `only ${lit} channels are lit`);
}
