// A picture that the server makes, laid over one on the stage: what was learned, samples, noise, or
// how two jobs differ. Fetched one at a time; the old one stays until the new one is there.
import { ApiError } from './api.js';

// The text of a PNG's tEXt chunk of that name, '' when it has none.
function png_text(buffer, name) {
  const view = new DataView(buffer);
  const latin = new TextDecoder('latin1');
  for (let at = 8; at + 8 <= buffer.byteLength;) {
    const size = view.getUint32(at);
    if (latin.decode(new Uint8Array(buffer, at + 4, 4)) === 'tEXt') {
      const [found, text] = latin.decode(new Uint8Array(buffer, at + 8, size)).split('\0');
      if (found === name) return text;
    }
    at += size + 12;
  }
  return '';
}

export class OverlayImage {
  #image;
  #on_change;
  #key = '';
  #scale = '';
  #problem = '';
  #wanted = null; // {key, fetch, alt}
  #busy = false;
  #abort = new AbortController();

  constructor(image, on_change) {
    this.#image = image;
    this.#on_change = on_change;
  }

  // What its colours mean, as the server says it in the picture's text.
  get scale() {
    return this.#scale;
  }
  // Why there is none.
  get problem() {
    return this.#problem;
  }

  // `key`: what is shown, '' for nothing. `fetch`: signal -> blob. `alt`: what is seen, in words.
  show(key, fetch = null, alt = '') {
    if (key === (this.#wanted?.key ?? this.#key)) return;
    if (!key) {
      this.#abort.abort();
      this.#wanted = null;
      this.#put('', null, '', '');
      return;
    }
    this.#wanted = { key, fetch, alt };
    if (!this.#busy) this.#go_on();
  }

  async #go_on() {
    this.#busy = true;
    while (this.#wanted) {
      const { key, fetch, alt } = this.#wanted;
      this.#abort = new AbortController();
      try {
        const blob = await fetch(this.#abort.signal);
        const scale = png_text(await blob.arrayBuffer(), 'qray:scale');
        if (this.#wanted?.key !== key) continue;
        this.#put(key, blob, alt, scale);
      } catch (error) {
        if (!(error instanceof ApiError) && error.name !== 'AbortError') throw error;
        if (this.#wanted?.key === key) {
          this.#put(key, null, '', '', error.message);
        }
      }
      if (this.#wanted?.key === key) this.#wanted = null;
    }
    this.#busy = false;
  }

  #put(key, blob, alt, scale, problem = '') {
    this.#scale = scale;
    this.#problem = problem;
    const old = this.#image.src;
    this.#key = key;
    this.#image.hidden = !blob;
    this.#image.alt = alt;
    if (blob) this.#image.src = URL.createObjectURL(blob);
    else this.#image.removeAttribute('src');
    if (old.startsWith('blob:')) URL.revokeObjectURL(old);
    if (key) this.#on_change();
  }
}
