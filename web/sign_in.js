// Asks for a token once the server wants one, and opens a session with it: a cookie that scripts do
// not see, and that event streams and pictures send too.
import { open_session } from './api.js';

const kDialog = `
<h2 id="sign-in-title">This server asks for a token</h2>
<form novalidate autocomplete="off">
  <p class="hint wide">Whoever runs it makes one: <code>qrayd token NAME submit</code></p>
  <div class="field wide">
    <label for="token">Token</label>
    <input id="token" type="password" autocomplete="current-password" spellcheck="false"
      aria-describedby="token-error">
    <p id="token-error" class="field-error" role="alert"></p>
  </div>
  <button type="submit" class="primary wide">Go on</button>
</form>`;

export class SignIn {
  #dialog;
  #waiting = null; // for all who ask while the dialog is open
  #go_on = null;

  constructor() {
    const dialog = document.createElement('dialog');
    Object.assign(dialog, { id: 'sign-in', className: 'card', innerHTML: kDialog });
    dialog.setAttribute('aria-labelledby', 'sign-in-title');
    document.body.append(dialog);
    this.#dialog = dialog;
    dialog.addEventListener('cancel', (event) => event.preventDefault());
    dialog.addEventListener('close', () => this.#waiting && dialog.showModal());
    dialog.querySelector('form').addEventListener('submit', (event) => {
      event.preventDefault();
      this.#try(dialog.querySelector('input'));
    });
  }

  // Resolves when there is a session.
  ask() {
    this.#waiting ??= new Promise((resolve) => {
      this.#go_on = resolve;
      this.#dialog.showModal();
    });
    return this.#waiting;
  }

  async #try(field) {
    const problem = this.#dialog.querySelector('.field-error');
    problem.textContent = '';
    try {
      await open_session(field.value.trim());
    } catch (error) {
      problem.textContent = error.status === 401 ? 'The server does not know this token.'
        : error.message;
      field.setAttribute('aria-invalid', 'true');
      field.focus();
      return;
    }
    field.value = '';
    field.removeAttribute('aria-invalid');
    this.#waiting = null;
    this.#dialog.close();
    this.#go_on();
  }
}
