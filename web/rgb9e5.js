// RGB9E5: three mantissas of 9 bits and an exponent that they share. Pure functions.

export function decode_rgb9e5(texel) {
  const scale = 2 ** ((texel >>> 27) - 24);
  return [(texel & 511) * scale, ((texel >>> 9) & 511) * scale, ((texel >>> 18) & 511) * scale];
}
