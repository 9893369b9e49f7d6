// A .glb or .zip that is dropped on the page, or chosen: its bytes go to the server, which makes a
// scene of them. What happens, and what the server says is wrong, is shown in words.
import { ApiError, has_asset, post_scene, put_asset } from './api.js';

const hex = (bytes) =>
  Array.from(new Uint8Array(bytes), (byte) => byte.toString(16).padStart(2, '0')).join('');

export class SceneDrop {
  #status;
  #on_scene;
  #busy = false;

  // on_scene(scene): it is there to be rendered; may take its time.
  constructor(input, status, on_scene) {
    this.#status = status;
    this.#on_scene = on_scene;
    input.addEventListener('change', async () => {
      await this.#take(input.files);
      input.value = ''; // so that the same file may be chosen again
    });
    const carries_files = (event) => event.dataTransfer?.types.includes('Files');
    document.addEventListener('dragover', (event) => {
      if (carries_files(event)) event.preventDefault();
    });
    document.addEventListener('drop', (event) => {
      if (!carries_files(event)) return;
      event.preventDefault(); // the browser would leave the page for the file
      this.#take(event.dataTransfer.files);
    });
  }

  #say(text, wrong = false) {
    this.#status.textContent = text;
    this.#status.classList.toggle('error', wrong);
  }

  async #take(files) {
    if (this.#busy || files.length === 0) return;
    this.#busy = true;
    try {
      await this.#upload(files);
    } catch (error) {
      if (!(error instanceof ApiError)) throw error;
      this.#say(`${files[0].name}: ${error.message}`, true);
    } finally {
      this.#busy = false;
    }
  }

  async #upload(files) {
    const file = files[0];
    const type = file.name.toLowerCase().match(/\.(glb|zip)$/)?.[1];
    if (!type || files.length > 1) {
      return this.#say('Expected one .glb, or one .zip of a scene and its files.', true);
    }
    // Browsers keep this from pages that came without encryption, but for the machine's own.
    if (!globalThis.crypto?.subtle) {
      return this.#say('This browser uploads only to https or localhost.', true);
    }
    this.#say(`Sending ${file.name} …`);
    const bytes = await file.arrayBuffer();
    const asset = hex(await crypto.subtle.digest('SHA-256', bytes));
    if (!await has_asset(asset)) await put_asset(asset, bytes);
    this.#say(`Reading ${file.name} …`);
    const scene = await post_scene({ asset, type });
    this.#say([`${file.name} is ${scene.name}.`, ...scene.warnings].join(' '));
    return this.#on_scene(scene);
  }
}
