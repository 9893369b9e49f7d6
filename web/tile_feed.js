// Keeps one picture of a job up to date: fetches the tiles after its cursor, one request at a time,
// and hands each answer to on_tiles. Asked while busy, it asks again when done. Of an earlier
// moment it fetches the whole picture, once.
import { fetch_moment, fetch_tiles } from './api.js';
import { parse_tiles } from './tiles.js';

const kMaxFailures = 3; // in a row; the next hint from the server starts over

export class TileFeed {
  #job_id;
  #which;
  #moment;
  #frame;
  #handlers;
  #cursor = 0n;
  #abort = new AbortController();
  #busy = false;
  #again = false;

  // `moment`: the number of one of its past, or null; `frame`: of a job of frames.
  // handlers: on_tiles(answer), on_error(error)
  constructor(job_id, which, moment, frame, handlers) {
    this.#job_id = job_id;
    this.#which = which;
    this.#moment = moment;
    this.#frame = frame;
    this.#handlers = handlers;
  }

  get cursor() {
    return this.#cursor;
  }

  // `newest`: the film's newest version, where a hint told it; nothing is asked when it is here.
  async pull(newest = null) {
    if (newest !== null && BigInt(newest) <= this.#cursor) return;
    if (this.#moment !== null && this.#cursor > 0n) return;
    this.#again = true;
    if (this.#busy) return;
    this.#busy = true;
    let failures = 0;
    while (this.#again && !this.#abort.signal.aborted) {
      this.#again = false;
      try {
        await this.#fetch_once();
        failures = 0;
      } catch (error) {
        if (error.name === 'AbortError') break;
        this.#again = ++failures < kMaxFailures;
        if (!this.#again) this.#handlers.on_error(error);
      }
    }
    this.#busy = false;
  }

  // Everything again: after the stream was lost the server may have started anew.
  restart() {
    this.#cursor = 0n;
    return this.pull();
  }

  stop() {
    this.#abort.abort();
  }

  async #fetch_once() {
    const since = this.#cursor;
    const { signal } = this.#abort;
    const answer = parse_tiles(await (this.#moment === null
      ? fetch_tiles(this.#job_id, this.#which, this.#frame, since, signal)
      : fetch_moment(this.#job_id, this.#moment, signal)));
    // restart() during the request: this answer belongs to the cursor before.
    if (this.#cursor !== since || this.#abort.signal.aborted) return;
    // What a past moment was does not change, whatever its cursor is.
    this.#cursor = this.#moment !== null && answer.cursor === 0n ? 1n : answer.cursor;
    if (answer.left_out > 0 && this.#moment === null) this.#again = true;
    this.#handlers.on_tiles(answer);
  }
}
