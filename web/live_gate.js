// When the viewer is live: opens the live view when the address says so (`live`, with a job or a
// `scene`) or when the picture is pulled, loads what that takes (live.js) the first time, and says
// why it cannot be. The job's picture stays below.

export class LiveGate {
  live = null; // once it is loaded
  scenes = []; // the server's
  #root;
  #viewer;
  #store;
  #address;
  #post;
  #open = ''; // what is open, or was refused
  #about = ''; // what the words are about
  #pulling = false;
  #refused = false; // during this drag
  #early = []; // of a drag, before there is a live view

  // post(request): posts a job and shows it.
  constructor(root, viewer, store, address, post) {
    this.#root = root;
    this.#viewer = viewer;
    this.#store = store;
    this.#address = address;
    this.#post = post;
    this.#part('toggle').addEventListener('click', () => this.#toggle());
    this.#part('leave').addEventListener('click', () => this.leave());
    this.#part('render').addEventListener('click', () => this.#render());
    this.#part('layer').addEventListener('keydown', (event) => {
      if (event.key !== 'Escape') return;
      this.leave();
      this.#part('toggle').focus();
    });
    viewer.addEventListener('pull', ({ detail }) => this.#pull(detail));
  }

  update() {
    const source = this.#source();
    const { view } = this.#address;
    const on = Boolean(view.live && source);
    this.#part('toggle').disabled = !on && !this.#source(true);
    this.#part('toggle').setAttribute('aria-pressed', String(on));
    for (const name of ['tools', 'side']) this.#part(name).hidden = !on;
    const about = view.job ?? view.scene;
    if (about !== this.#about) this.#say('');
    this.#about = about;
    const key = on ? source.key : '';
    if (key === this.#open) {
      this.live?.follow();
      return;
    }
    this.#open = key;
    this.live?.close();
    if (on) this.#start(source);
  }

  // A scene that cannot be loaded has no size.
  can_show(scene) {
    return this.scenes.some(({ name, width }) => name === scene && width);
  }

  leave() {
    this.#address.set({ live: '', scene: null, off: '', dark: '', beside: '' });
  }

  // What is looked at, or would be; null where that is not known.
  #source(would = false) {
    const { view } = this.#address;
    if (!view.live && !would) return null;
    if (view.job) {
      const job = this.#store.get(view.job);
      if (!job) return null;
      const { scene, camera, width, height } = job.request;
      return { key: view.job, scene, camera, width, height };
    }
    const scene = this.scenes.find(({ name }) => name === view.scene);
    if (!scene?.width) {
      if (view.scene && this.scenes.length) this.#say(`There is no scene ${view.scene}.`);
      return null;
    }
    return { key: `scene ${scene.name}`, scene: scene.name, width: scene.width,
      height: scene.height };
  }

  async #start(source) {
    const { key } = source;
    this.#say('Opening a live view …');
    const frame = this.#part('frame');
    frame.style.setProperty('--w', source.width);
    frame.style.setProperty('--h', source.height);
    try {
      const { Live } = await import('./live.js');
      this.live ??= new Live(this.#root, this.#address, (problem, ended) => {
        this.#say(problem, Boolean(problem));
        if (ended) this.#give_up();
      });
      if (this.#open !== key) return;
      this.#early.splice(0).forEach((delta) => this.live.drag(...delta));
      await this.live.open(source);
    } catch (error) {
      if (this.#open !== key) return;
      const why = error.message.replace(/[.]$/, '');
      this.#say(error.status === 503 ? `The server has no room for a live view now: ${why}.`
        : `There is no live view: ${why}.`, true);
      this.#give_up();
    }
  }

  // The job's picture again; a scene that was asked for stays asked for.
  #give_up() {
    this.#pulling = false;
    if (this.#address.view.job) this.leave();
    this.live?.close();
  }

  #toggle() {
    this.#say('');
    if (this.#address.view.live && this.#address.view.job) this.leave();
    else if (this.#address.view.live) {
      this.#open = ''; // a scene's is tried again
      this.update();
    } else this.#address.set({ live: 'on' });
  }

  // The whole picture was dragged by [dx, dy]: it turns. null: it was let go.
  #pull(delta) {
    if (!delta) {
      this.#pulling = false;
      this.#refused = false;
      return;
    }
    if (!this.#pulling) {
      if (this.#refused || this.#address.view.live || !this.#source(true)) return;
      this.#pulling = true;
      this.#refused = true; // one try for each drag
      this.#address.set({ live: 'on' });
    }
    if (this.live) this.live.drag(...delta);
    else this.#early.push(delta);
  }

  async #render() {
    const { view } = this.#address;
    const scene = this.scenes.find(({ name }) => name === view.scene);
    const { frames, mix: was, light_groups, camera, ...request } = view.job
      ? this.#store.get(view.job).request
      : { scene: view.scene, width: scene.width, height: scene.height, samples: 32,
        recover: 'auto' };
    const { mix } = this.live;
    try {
      await this.#post({ ...request, camera: this.live.camera.camera,
        ...(mix && { light_groups: 'material', mix }) });
    } catch (error) {
      this.#say(error.message, true);
    }
  }

  #say(text, is_problem = false) {
    const line = this.#part('status');
    line.textContent = text;
    line.hidden = !text;
    line.classList.toggle('error', is_problem);
  }

  #part(name) {
    return this.#root.querySelector(`.live-${name}`);
  }
}
