// The frames of a live session (docs/api.md, "Live"): one long answer, taken apart as it comes. Of
// frames that came at once only the newest is shown. Frames come as RGB9E5, whose exposure can be
// changed without loss; over a line that is too slow for that, as JPEG.

const kMagic = 0x314c5251; // "QRL1"
const kStages = ['moving', 'settling', 'still'];

function header_of(view, at) {
  const f32 = (offset) => view.getFloat32(at + offset, true);
  const u32 = (offset) => view.getUint32(at + offset, true);
  const u64 = (offset) => Number(view.getBigUint64(at + offset, true));
  if (u32(0) !== kMagic) throw new Error('this is no frame');
  return {
    header_bytes: u32(4), picture_bytes: u32(8),
    encoding: kEncodings[view.getUint8(at + 12)], stage: kStages[view.getUint8(at + 13)],
    guided: view.getUint8(at + 14) === 1, percent: view.getUint8(at + 15), number: u64(16),
    camera: u64(24), width: u32(32), height: u32(36),
    ms: { features: f32(40), reprojection: f32(44), samples: f32(48), learning: f32(52),
      recovery: f32(56), whole: f32(60) },
    samples_per_pixel: f32(64), noise: f32(68), paths: u64(72), rays: u64(80),
  };
}

const kHeaderBytes = 88;
const kEncodings = ['rgb9e5', 'jpeg', 'webp'];
const kLeastRate = 8; // frames a second that the line must carry
const kJudged = 3; // frames in a row that it did not

export class LiveStream {
  #abort = new AbortController();
  #answer = null; // aborts the one that is being read
  #bytes = new Uint8Array(1 << 22);
  #size = 0;
  #began_ms = 0; // when the first bytes of the frame that is coming were there
  #slow = 0; // frames in a row that were too slow
  #encoding = 'rgb9e5';
  missed = 0; // frames that came, but late
  received = 0; // bytes

  // on_frame(frame, picture): the newest one, as a Uint32Array or an ImageBitmap. on_end(error):
  // null when the session ended.
  constructor(id, on_frame, on_end) {
    this.#run(id, on_frame).then(() => on_end(null), (error) => {
      if (!this.#abort.signal.aborted) on_end(error);
    });
  }

  get encoding() {
    return this.#encoding;
  }

  stop() {
    this.#abort.abort();
  }

  async #run(id, on_frame) {
    for (;;) {
      const encoding = this.#encoding;
      this.#answer = new AbortController();
      const signal = AbortSignal.any([this.#abort.signal, this.#answer.signal]);
      try {
        await this.#read(id, on_frame, signal);
        return;
      } catch (error) {
        if (this.#abort.signal.aborted || encoding === this.#encoding) throw error;
        this.#size = 0; // the same frames, in the other encoding
      }
    }
  }

  async #read(id, on_frame, signal) {
    const answer = await fetch(
      `/v1/live/${encodeURIComponent(id)}/frames?enc=${this.#encoding}`,
      { signal, cache: 'no-store' });
    if (!answer.ok) throw new Error(`HTTP ${answer.status}`);
    const reader = answer.body.getReader();
    for (;;) {
      const { done, value } = await reader.read();
      if (done) return;
      if (this.#size === 0) this.#began_ms = performance.now();
      this.received += value.length;
      this.#append(value);
      await this.#take(on_frame);
    }
  }

  #append(bytes) {
    if (this.#size + bytes.length > this.#bytes.length) {
      const larger = new Uint8Array(2 * (this.#size + bytes.length));
      larger.set(this.#bytes.subarray(0, this.#size));
      this.#bytes = larger;
    }
    this.#bytes.set(bytes, this.#size);
    this.#size += bytes.length;
  }

  async #take(on_frame) {
    const view = new DataView(this.#bytes.buffer);
    let [at, newest] = [0, null];
    while (this.#size - at >= kHeaderBytes) {
      const frame = header_of(view, at);
      const end = at + frame.header_bytes + frame.picture_bytes;
      if (end > this.#size) break;
      if (newest) ++this.missed;
      newest = { frame, begin: at + frame.header_bytes, end };
      at = end;
    }
    if (!newest) return;
    const { frame, begin, end } = newest;
    const bytes = this.#bytes.slice(begin, end);
    this.#judge_line(frame.picture_bytes);
    this.#bytes.copyWithin(0, at, this.#size);
    this.#size -= at;
    this.#began_ms = performance.now();
    on_frame(frame, frame.encoding === 'rgb9e5' ? new Uint32Array(bytes.buffer) :
      await createImageBitmap(new Blob([bytes], { type: `image/${frame.encoding}` }),
        { colorSpaceConversion: 'none' }));
  }

  // How long a frame took from its first byte to its last is how fast the line is.
  #judge_line(picture_bytes) {
    if (this.#encoding !== 'rgb9e5') return;
    const slow = performance.now() - this.#began_ms > 1000 / kLeastRate;
    this.#slow = slow && picture_bytes > 0 ? this.#slow + 1 : 0;
    if (this.#slow < kJudged) return;
    this.#encoding = 'jpeg';
    this.#answer.abort();
  }
}
