// Keys of one letter, and the dialog that lists them. They rest while something is typed, while
// another dialog is open, and for good when they are switched off there.

const kStored = 'qray-keys';

export class Keys {
  #keys;

  // keys: [[key as in KeyboardEvent.key, words, act]]
  constructor(dialog, open_button, keys) {
    this.#keys = [['?', 'This list', () => dialog.showModal()], ...keys];
    dialog.querySelector('dl').append(...this.#keys.flatMap(([key, words]) => {
      const term = document.createElement('dt');
      term.append(Object.assign(document.createElement('kbd'), { textContent: key }));
      return [term, Object.assign(document.createElement('dd'), { textContent: words })];
    }));
    const on = dialog.querySelector('input[type=checkbox]');
    on.checked = localStorage.getItem(kStored) !== 'off';
    on.addEventListener('change', () => localStorage.setItem(kStored, on.checked ? 'on' : 'off'));
    open_button.addEventListener('click', () => dialog.showModal());
    document.addEventListener('keydown', (event) => {
      if (on.checked) this.#press(event);
    });
  }

  #press(event) {
    const { key, target } = event;
    if (event.ctrlKey || event.metaKey || event.altKey || event.defaultPrevented) return;
    if (document.querySelector('dialog[open]')) return;
    const typing = target.matches('textarea, select, input:not([type=range], [type=checkbox])');
    if (typing || target.isContentEditable) return;
    const found = this.#keys.find(([one]) => one === key);
    if (!found) return;
    event.preventDefault();
    found[2]();
  }
}
