// The page of tables: what was learned, version by version; which jobs used it; merging, deleting.
import { ApiError, delete_table, jobs_of_table, merge_tables } from './api.js';
import { ago, big, bytes, count, method_words, state_words } from './format.js';
import { title_of } from './scene_library.js';

// How many generations a table has behind it, itself counted. Parents that are gone count as none.
function version_of(table, by_id) {
  const parents = table.parents.map((id) => by_id(id)).filter(Boolean);
  return 1 + Math.max(0, ...parents.map((parent) => version_of(parent, by_id)));
}

export class TablesPage {
  #root;
  #store;
  #link_to;
  #rows = new Map(); // id -> row
  #chosen = new Set();

  constructor(root, store, link_to) {
    this.#root = root;
    this.#store = store;
    this.#link_to = link_to;
    this.#part('merge').addEventListener('click', () => this.#merge());
    store.addEventListener('change', () => root.hidden || this.update());
  }

  update() {
    const tables = this.#store.tables();
    const known = new Set(tables.map(({ id }) => id));
    for (const [id, row] of this.#rows) {
      if (known.has(id)) continue;
      row.remove();
      this.#rows.delete(id);
      this.#chosen.delete(id);
    }
    this.#part('none').hidden = tables.length > 0;
    this.#part('list').hidden = tables.length === 0;
    const body = this.#part('rows');
    tables.forEach((table, index) => {
      if (!this.#rows.has(table.id)) this.#rows.set(table.id, this.#row(table));
      const row = this.#rows.get(table.id);
      if (body.children[index] !== row) body.insertBefore(row, body.children[index] ?? null);
    });
    this.#show_choice();
  }

  #show_choice() {
    const button = this.#part('merge');
    button.disabled = this.#chosen.size < 2;
    button.textContent = this.#chosen.size < 2 ? 'Merge' : `Merge ${this.#chosen.size} tables`;
  }

  #row(table) {
    const row = this.#root.querySelector('template').content.firstElementChild.cloneNode(true);
    const part = (name) => row.querySelector(`.table-${name}`);
    const short = table.id.slice(0, 8);
    row.id = `table-${table.id}`;
    part('choose').setAttribute('aria-label', `Choose table ${short}`);
    part('choose').addEventListener('change', ({ target }) => {
      this.#chosen[target.checked ? 'add' : 'delete'](table.id);
      this.#show_choice();
    });
    part('id').textContent = short;
    part('id').title = table.id;
    part('scene').textContent = title_of(table.scene);
    part('method').textContent = method_words(table.method);
    part('version').textContent = `v${version_of(table, (id) => this.#store.table(id))}`;
    part('parents').append(...table.parents.flatMap((id, i) => [i ? ', ' : '', this.#parent(id)]));
    if (!table.parents.length) part('parents').textContent = '–';
    const merged = table.parents.length > 1;
    part('job').append(table.job ? this.#job_link(table.job)
      : merged ? 'a merge' : 'a live view, or a file');
    part('samples').textContent = big(table.samples_seen);
    part('states').textContent = count(table.states);
    part('bytes').textContent = bytes(table.bytes);
    part('time').textContent = ago(table.created);
    part('time').dateTime = table.created;
    part('users').addEventListener('toggle', ({ target }) => {
      if (target.open) this.#list_users(table.id, part('user-list'));
    });
    part('users').querySelector('summary').setAttribute('aria-label', `Jobs of table ${short}`);
    part('delete').setAttribute('aria-label', `Delete table ${short}`);
    part('delete').addEventListener('click', () => this.#delete(table));
    return row;
  }

  #parent(id) {
    const words = document.createElement('code');
    words.textContent = id.slice(0, 8);
    words.title = this.#store.table(id) ? id : `${id}, not kept any more`;
    return words;
  }

  #job_link(id) {
    const link = document.createElement('a');
    link.href = this.#link_to(id);
    link.textContent = id;
    return link;
  }

  async #list_users(id, list) {
    try {
      const jobs = await jobs_of_table(id);
      list.replaceChildren(...jobs.map((job) => {
        const line = document.createElement('li');
        const did = [job.table_in === id && 'started from it', job.table_out === id && 'made it'];
        line.append(this.#job_link(job.id), ` ${did.filter(Boolean).join(', ') ||
          state_words(job.state).toLowerCase()}`);
        return line;
      }));
      if (!jobs.length) list.replaceChildren('No job that is still kept.');
    } catch (error) {
      if (!(error instanceof ApiError)) throw error;
      list.replaceChildren(error.message);
    }
  }

  async #merge() {
    await this.#change(async () => {
      const merged = await merge_tables([...this.#chosen]);
      this.#chosen.clear();
      this.#root.querySelectorAll('.table-choose').forEach((box) => {
        box.checked = false;
      });
      return `Merged into ${merged.id.slice(0, 8)}; the next job there starts from it.`;
    });
  }

  async #delete({ id, scene }) {
    const short = id.slice(0, 8);
    const of = title_of(scene);
    if (!confirm(`Delete table ${short} of ${of}? What it learned is gone then.`)) return;
    await this.#change(async () => {
      await delete_table(id);
      return `Table ${short} is deleted.`;
    });
  }

  async #change(act) {
    const say = this.#part('status');
    try {
      say.textContent = await act();
      say.classList.remove('error');
    } catch (error) {
      if (!(error instanceof ApiError)) throw error;
      say.textContent = [error.message, ...error.errors.map(({ detail }) => detail)].join(' ');
      say.classList.add('error');
    }
    await this.#store.load_tables().catch(() => {});
  }

  #part(name) {
    return this.#root.querySelector(`.tables-${name}`);
  }
}
