// The picture exactly as it is shown, pixel by pixel and whatever the zoom: exposure, curve and
// channel, the divider of two, and what is laid over. As a file, or to the clipboard.

// What one pane of the stage shows.
function pane(picture) {
  const { width, height } = picture;
  const canvas = Object.assign(document.createElement('canvas'), { width, height });
  const context = canvas.getContext('2d');
  const bytes = new Uint8ClampedArray(picture.read_pixels().buffer);
  context.putImageData(new ImageData(bytes, width, height), 0, 0);
  const over = picture.root.querySelector('img.overlay');
  if (over && !over.hidden && over.naturalWidth) {
    context.globalAlpha = Number(getComputedStyle(over).opacity);
    context.imageSmoothingEnabled = false;
    context.drawImage(over, 0, 0, width, height);
  }
  return canvas;
}

// A canvas; null before there is a picture.
export function as_shown({ pictures, arrangement, split }) {
  const panes = pictures.filter((picture) => picture.has_picture && picture.width &&
    !picture.root.classList.contains('behind')).map(pane);
  if (panes.length === 0) return null;
  const [first] = panes;
  const in_row = arrangement === 'row';
  const all = Object.assign(document.createElement('canvas'), {
    width: in_row ? panes.reduce((sum, { width }) => sum + width, 0) : first.width,
    height: Math.max(...panes.map(({ height }) => height)),
  });
  const context = all.getContext('2d');
  if (in_row) {
    let x = 0;
    for (const one of panes) {
      context.drawImage(one, x, 0);
      x += one.width;
    }
  } else {
    context.drawImage(first, 0, 0);
    if (panes.length === 2) {
      const cut = Math.round((all.width * split) / 100);
      context.beginPath();
      context.rect(cut, 0, all.width - cut, all.height);
      context.clip();
      context.drawImage(panes[1], 0, 0, all.width, all.height);
    }
  }
  return all;
}

export class Snapshot {
  #status;
  #viewer;

  constructor(save, copy, status, viewer) {
    this.#status = status;
    this.#viewer = viewer;
    save.addEventListener('click', () => this.#save());
    copy.hidden = !globalThis.ClipboardItem || !navigator.clipboard;
    copy.addEventListener('click', () => this.#copy());
  }

  #png() {
    const canvas = as_shown(this.#viewer);
    if (!canvas) return Promise.reject(new Error('there is no picture yet'));
    return new Promise((done) => {
      canvas.toBlob(done, 'image/png');
    });
  }

  async #save() {
    try {
      const url = URL.createObjectURL(await this.#png());
      const name = this.#viewer.shown_jobs.join('-');
      Object.assign(document.createElement('a'), { href: url, download: `${name}.png` }).click();
      setTimeout(() => URL.revokeObjectURL(url), 60_000);
      this.#say('saved');
    } catch (error) {
      this.#say(error.message);
    }
  }

  async #copy() {
    try {
      await navigator.clipboard.write([new ClipboardItem({ 'image/png': this.#png() })]);
      this.#say('picture copied');
    } catch (error) {
      this.#say(`not copied: ${error.message}`);
    }
  }

  #say(words) {
    this.#status.textContent = words;
  }
}
