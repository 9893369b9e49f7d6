// Runs one question to the server at a time; what is asked meanwhile replaces what waits. So a
// pointer may move as fast as it likes.
import { ApiError } from './api.js';

export class Latest {
  #waiting = null;
  #busy = false;
  #turn = 0;

  // ask: () -> promise; then on_answer(value) or on_refused(ApiError), unless stop() came between.
  async run(ask, on_answer, on_refused = () => {}) {
    this.#waiting = { ask, on_answer, on_refused };
    if (this.#busy) return;
    this.#busy = true;
    while (this.#waiting) {
      const { ask: now, on_answer: tell, on_refused: refuse } = this.#waiting;
      const turn = this.#turn;
      this.#waiting = null;
      try {
        const value = await now();
        if (turn === this.#turn) tell(value);
      } catch (error) {
        if (!(error instanceof ApiError)) throw error;
        if (turn === this.#turn) refuse(error);
      }
    }
    this.#busy = false;
  }

  stop() {
    this.#waiting = null;
    ++this.#turn;
  }
}
