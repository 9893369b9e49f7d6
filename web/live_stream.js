// The frames of a live session (docs/api.md, "Live"): one long answer, taken apart as it comes. Of
// frames that came at once only the newest is shown.

const kMagic = 0x314c5251; // "QRL1"
const kStages = ['moving', 'settling', 'still'];

function header_of(view, at) {
  const f32 = (offset) => view.getFloat32(at + offset, true);
  const u32 = (offset) => view.getUint32(at + offset, true);
  const u64 = (offset) => Number(view.getBigUint64(at + offset, true));
  if (u32(0) !== kMagic) throw new Error('this is no frame');
  return {
    header_bytes: u32(4), picture_bytes: u32(8), stage: kStages[view.getUint8(at + 13)],
    guided: view.getUint8(at + 14) === 1, percent: view.getUint8(at + 15), number: u64(16),
    camera: u64(24), width: u32(32), height: u32(36),
    ms: { features: f32(40), reprojection: f32(44), samples: f32(48), learning: f32(52),
      recovery: f32(56), whole: f32(60) },
    samples_per_pixel: f32(64), noise: f32(68), paths: u64(72), rays: u64(80),
  };
}

const kHeaderBytes = 88;

export class LiveStream {
  #abort = new AbortController();
  #bytes = new Uint8Array(1 << 22);
  #size = 0;
  missed = 0; // frames that came, but late

  // on_frame(frame, pixels): the newest one. on_end(error): null when the session ended.
  constructor(id, on_frame, on_end) {
    this.#run(id, on_frame).then(() => on_end(null), (error) => {
      if (!this.#abort.signal.aborted) on_end(error);
    });
  }

  stop() {
    this.#abort.abort();
  }

  async #run(id, on_frame) {
    const answer = await fetch(`/v1/live/${encodeURIComponent(id)}/frames?enc=rgb9e5`,
      { signal: this.#abort.signal, cache: 'no-store' });
    if (!answer.ok) throw new Error(`HTTP ${answer.status}`);
    const reader = answer.body.getReader();
    for (;;) {
      const { done, value } = await reader.read();
      if (done) return;
      this.#append(value);
      this.#take(on_frame);
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

  #take(on_frame) {
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
    if (newest) on_frame(newest.frame, new Uint32Array(
      this.#bytes.slice(newest.begin, newest.end).buffer));
    this.#bytes.copyWithin(0, at, this.#size);
    this.#size -= at;
  }
}
