// The binary answer of GET /v1/jobs/<id>/tiles: parsing, with every length checked before use, and
// the CRC-32C of each tile. Pure functions; no DOM.

const kMagic = 0x31545251; // "QRT1", little-endian
const kHeaderBytes = 28;
const kTileHeaderBytes = 24;
const kMaxTilePx = 64;

// Castagnoli's polynomial, reflected.
const kCrcTable = Uint32Array.from({ length: 256 }, (_, byte) => {
  let crc = byte;
  for (let bit = 0; bit < 8; ++bit) crc = crc & 1 ? (crc >>> 1) ^ 0x82f63b78 : crc >>> 1;
  return crc;
});

export function crc32c(bytes) {
  let crc = 0xffffffff;
  for (let i = 0; i < bytes.length; ++i) crc = kCrcTable[(crc ^ bytes[i]) & 255] ^ (crc >>> 8);
  return (crc ^ 0xffffffff) >>> 0;
}

// {width, height, cursor (BigInt), left_out, tiles: [{x, y, w, h, samples, pixels: Uint32Array}]}.
// Throws when the bytes are not what docs/api.md says or a tile's CRC does not match.
export function parse_tiles(buffer) {
  const view = new DataView(buffer);
  const expect = (ok, what) => {
    if (!ok) throw new Error(`tiles: ${what}`);
  };
  expect(view.byteLength >= kHeaderBytes, `expected ${kHeaderBytes} bytes of header`);
  expect(view.getUint32(0, true) === kMagic, 'expected the magic QRT1');
  const answer = {
    width: view.getUint32(4, true),
    height: view.getUint32(8, true),
    cursor: view.getBigUint64(12, true),
    left_out: view.getUint32(24, true),
    tiles: [],
  };
  const count = view.getUint32(20, true);
  let at = kHeaderBytes;
  for (let i = 0; i < count; ++i) {
    expect(at + kTileHeaderBytes <= view.byteLength, `tile ${i}: header cut short`);
    const field = (offset) => view.getUint32(at + offset, true);
    const [x, y, w, h, samples, crc] = [0, 4, 8, 12, 16, 20].map(field);
    at += kTileHeaderBytes;
    expect(w >= 1 && h >= 1 && w <= kMaxTilePx && h <= kMaxTilePx, `tile ${i}: size ${w} x ${h}`);
    expect(x + w <= answer.width && y + h <= answer.height, `tile ${i}: outside the picture`);
    const bytes = w * h * 4;
    expect(at + bytes <= view.byteLength, `tile ${i}: pixels cut short`);
    const got = crc32c(new Uint8Array(buffer, at, bytes));
    expect(got === crc, `tile ${i}: CRC-32C ${got.toString(16)}, expected ${crc.toString(16)}`);
    // Both headers are multiples of 4 bytes, so the view is aligned; every WebGL2 platform is
    // little-endian, as the wire is.
    answer.tiles.push({ x, y, w, h, samples, pixels: new Uint32Array(buffer, at, w * h) });
    at += bytes;
  }
  expect(at === view.byteLength, `${view.byteLength - at} bytes after the last tile`);
  return answer;
}
