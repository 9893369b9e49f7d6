// Scenes that are dropped on the page, or chosen: a .glb, a .zip, a folder, or a scene's files
// together. Their bytes go to the server, which makes a scene of them. What happens, and what the
// server says is wrong, is shown in words.
import { ApiError, has_asset, post_scene, put_asset } from './api.js';
import { chosen_files, dropped_files } from './scene_files.js';

const kScene = /\.(gltf|glb|xml|obj|ply)$|(^|\/)scene\.json$/i;
const kMostTitle = 100;

const hex = (bytes) =>
  Array.from(new Uint8Array(bytes), (byte) => byte.toString(16).padStart(2, '0')).join('');
const ending = (name) => name.toLowerCase().match(/\.([^./]+)$/)?.[1] ?? '';
const without_ending = (name) => name.replace(/^.*\//, '').replace(/\.[^.]+$/, '');
// The server's errors name what it was sent; people know the file.
const in_their_words = (message) => message.replace(/^(\/files\/scene\.glb|\/asset): /, '')
  .replace(/^scene\.glb(:\d+)?: /, '');

export class SceneDrop {
  #status;
  #on_scene;
  #busy = false;

  // on_scene(scene): it is there to be rendered; may take its time. `overlay` shows while files
  // are held over the page.
  constructor(inputs, status, overlay, on_scene) {
    this.#status = status;
    this.#on_scene = on_scene;
    for (const input of inputs) {
      input.addEventListener('change', async () => {
        await this.#take(chosen_files(input.files));
        input.value = ''; // so that the same file may be chosen again
      });
    }
    const carries_files = (event) => event.dataTransfer?.types.includes('Files');
    const shows = (shown) => { overlay.hidden = !shown; };
    document.addEventListener('dragover', (event) => {
      if (!carries_files(event)) return;
      event.preventDefault();
      shows(true);
    });
    document.addEventListener('dragleave', (event) => event.relatedTarget || shows(false));
    document.addEventListener('drop', async (event) => {
      if (!carries_files(event)) return;
      event.preventDefault(); // the browser would leave the page for the file
      shows(false);
      this.#take(await dropped_files(event.dataTransfer));
    });
  }

  #say(text, wrong = false) {
    this.#status.textContent = text;
    this.#status.classList.toggle('error', wrong);
  }

  async #take({ title, files }) {
    if (this.#busy || files.length === 0) return;
    this.#busy = true;
    const name = files.length === 1 ? files[0].name : title || 'the files';
    try {
      await this.#upload(files, name, title);
    } catch (error) {
      if (!(error instanceof ApiError)) throw error;
      this.#say(`${name}: ${in_their_words(error.message)}`, true);
    } finally {
      this.#busy = false;
    }
  }

  async #upload(files, name, title) {
    const archive = files.length === 1 && ['glb', 'zip'].includes(ending(name));
    const scenes = files.filter((one) => kScene.test(one.name)).map((one) => one.name);
    const empty = files.find(({ file }) => file.size === 0);
    if (!archive && !scenes.length) {
      return this.#say('Expected a .glb, a .zip, or a scene (.gltf, .xml, .obj, .ply, ' +
        'scene.json) together with its files.', true);
    }
    if (empty && (archive || scenes.includes(empty.name))) {
      return this.#say(`${empty.name} is empty.`, true);
    }
    // Browsers keep this from pages that came without encryption, but for the machine's own.
    if (!globalThis.crypto?.subtle) {
      return this.#say('This browser uploads only to https or localhost.', true);
    }
    const hashes = {};
    for (const [index, one] of files.entries()) {
      const which = files.length > 1 ? ` (${index + 1} of ${files.length})` : '';
      this.#say(`Sending ${one.name}${which} …`);
      hashes[one.name] = await this.#send(one.file);
    }
    const entry = archive ? undefined : await this.#which(scenes);
    this.#say(`Reading ${name} …`);
    const called = title || without_ending(entry ?? name);
    const scene = await post_scene({ title: called.slice(0, kMostTitle),
      ...(archive ? { asset: hashes[files[0].name], type: ending(name) } :
        { files: hashes, entry }) });
    const { warnings } = scene;
    this.#say([`${name} is there as “${scene.title}”.`, ...warnings].join(' '));
    return this.#on_scene(scene);
  }

  // Several files may be the scene: its maker says which. One .obj beside its .ply parts is clear.
  #which(scenes) {
    const best = ['scene.json', 'gltf', 'glb', 'xml', 'obj', 'ply']
      .map((kind) => scenes.filter((name) => name.toLowerCase().endsWith(kind)))
      .find((some) => some.length);
    if (best.length === 1) return best[0];
    this.#say('There are several scenes. Which one? ');
    return new Promise((done) => {
      for (const name of best) {
        const button = document.createElement('button');
        Object.assign(button, { type: 'button', textContent: name });
        button.addEventListener('click', () => done(name));
        this.#status.append(button, ' ');
      }
    });
  }

  async #send(file) {
    const bytes = await file.arrayBuffer();
    const asset = hex(await crypto.subtle.digest('SHA-256', bytes));
    if (!await has_asset(asset)) await put_asset(asset, bytes);
    return asset;
  }
}
