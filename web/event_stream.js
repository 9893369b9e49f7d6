// The server's events (SSE). They are hints only: whoever listens asks the server for the truth.
// Calls on_event(name, data) for each, on_sync() when everything must be fetched anew (each time
// the stream opens, and on `reset`), and on_connection(true|false) when the stream comes or goes.

import { check_access } from './api.js';

const kNames = ['state', 'loading', 'progress', 'frame', 'table', 'done', 'deleted'];
const kNoticeDelayMs = 1500; // a stream that comes back at once is not worth a notice
const kRetryMs = 2000;

export class EventStream {
  #handlers;
  #source = null;
  #notice_timer = 0;

  constructor(handlers) {
    this.#handlers = handlers;
  }

  open() {
    const source = new EventSource('/v1/events');
    this.#source = source;
    source.addEventListener('open', () => {
      clearTimeout(this.#notice_timer);
      this.#notice_timer = 0;
      this.#handlers.on_connection(true);
      this.#handlers.on_sync();
    });
    source.addEventListener('error', () => this.#lost());
    source.addEventListener('reset', () => this.#handlers.on_sync());
    for (const name of kNames) {
      source.addEventListener(name, (event) => {
        this.#handlers.on_event(name, JSON.parse(event.data));
      });
    }
  }

  #lost() {
    if (!this.#notice_timer) {
      this.#notice_timer = setTimeout(() => this.#handlers.on_connection(false), kNoticeDelayMs);
    }
    // The browser reconnects by itself, except after another kind of answer.
    if (this.#source.readyState === EventSource.CLOSED) this.#open_again();
  }

  // Its session may be over: then the page asks for a token first.
  async #open_again() {
    await check_access().catch(() => {});
    setTimeout(() => this.open(), kRetryMs);
  }
}
