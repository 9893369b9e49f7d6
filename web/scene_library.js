// The scenes as pictures to choose from. The server makes each picture when it is first asked for,
// so they are fetched one at a time, and only for scenes that are seen. Scenes that were uploaded
// can be renamed and deleted.
import { ApiError, delete_scene, get_thumbnail, rename_scene } from './api.js';
import { draw_over } from './thumbnails.js';

const kMostTries = 5;
const titles = new Map(); // name -> title

// What people call a scene.
export const title_of = (name) => titles.get(name) ?? name;

export class SceneLibrary {
  #root;
  #on_choose;
  #on_change;
  #live_link;
  #scenes = [];
  #cards = new Map(); // name -> button
  #chosen = '';
  #waiting = []; // names whose picture is to be fetched
  #busy = false;
  #observer = new IntersectionObserver((entries) => {
    for (const { target, isIntersecting } of entries) {
      if (!isIntersecting) continue;
      this.#observer.unobserve(target);
      this.#waiting.push(target.dataset.scene);
    }
    this.#fetch();
  });

  // on_choose(name): a card was chosen. on_change(): the server's list is another now.
  // live_link(name): where the scene is looked at live.
  constructor(root, on_choose, on_change, live_link) {
    this.#live_link = live_link;
    this.#root = root;
    this.#on_choose = on_choose;
    this.#on_change = on_change;
    this.#part('rename').addEventListener('click', () => this.#rename());
    this.#part('delete').addEventListener('click', () => this.#delete());
  }

  // `scenes`: the server's. Cards are kept, so focus and pictures stay.
  show(scenes) {
    this.#scenes = scenes;
    titles.clear();
    for (const { name, title } of scenes) titles.set(name, title);
    const names = new Set(scenes.map(({ name }) => name));
    for (const [name, card] of this.#cards) {
      if (names.has(name)) continue;
      card.remove();
      this.#cards.delete(name);
    }
    for (const { name } of scenes) {
      if (!this.#cards.has(name)) this.#cards.set(name, this.#new_card(name));
      const card = this.#cards.get(name);
      card.querySelector('.scene-title').textContent = title_of(name);
      card.title = title_of(name);
      this.#part('cards').append(card);
    }
    this.choose(this.#chosen);
  }

  // Marks the scene's card.
  choose(name) {
    this.#chosen = name;
    for (const [of, card] of this.#cards) card.setAttribute('aria-pressed', String(of === name));
    const { uploaded = false } = this.#scenes.find((scene) => scene.name === name) ?? {};
    for (const part of ['rename', 'delete']) this.#part(part).hidden = !uploaded;
    this.#part('live').hidden = !names_live(this.#scenes, name);
    this.#part('live').href = this.#live_link(name);
  }

  #new_card(name) {
    const card = document.createElement('button');
    Object.assign(card, { type: 'button', className: 'scene-card' });
    card.dataset.scene = name;
    const picture = document.createElement('canvas');
    Object.assign(picture, { className: 'scene-picture', width: 160, height: 120 });
    const title = document.createElement('span');
    title.className = 'scene-title';
    card.append(picture, title);
    card.addEventListener('click', () => this.#on_choose(name));
    this.#observer.observe(card);
    return card;
  }

  async #fetch() {
    if (this.#busy) return;
    this.#busy = true;
    while (this.#waiting.length) {
      const name = this.#waiting.shift();
      const blob = await this.#picture_of(name);
      const place = this.#cards.get(name)?.querySelector('.scene-picture');
      if (blob && place) await draw_over(place, blob);
    }
    this.#busy = false;
  }

  // Null where there is none: a scene that cannot be loaded says why when a job renders it.
  async #picture_of(name) {
    for (let tries = 0; tries < kMostTries; ++tries) {
      try {
        return await get_thumbnail(name);
      } catch (error) {
        if (!(error instanceof ApiError)) throw error;
        if (!error.retry_after_s) return null;
        await new Promise((done) => { setTimeout(done, 1000 * error.retry_after_s); });
      }
    }
    return null;
  }

  async #rename() {
    const title = prompt('What is this scene called?', title_of(this.#chosen))?.trim();
    if (title) await this.#change(() => rename_scene(this.#chosen, title));
  }

  async #delete() {
    const name = title_of(this.#chosen);
    const question = `Delete the scene ${name} and its files? Pictures made of it stay.`;
    if (!confirm(question)) return;
    await this.#change(() => delete_scene(this.#chosen));
  }

  async #change(act) {
    const status = this.#part('status');
    status.textContent = '';
    try {
      await act();
      await this.#on_change();
    } catch (error) {
      if (!(error instanceof ApiError)) throw error;
      status.textContent = error.message;
    }
  }

  #part(name) {
    return this.#root.querySelector(`.library-${name}`);
  }
}

// A scene that cannot be loaded has no size, and nothing to walk through.
const names_live = (scenes, name) => scenes.some((scene) => scene.name === name && scene.width);
