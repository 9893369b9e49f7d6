// Controls that show and set members of the address: `data-view="ev"` on a select or an input.

export class ViewControls {
  #controls;
  #address;

  constructor(root, address) {
    this.#address = address;
    this.#controls = [...root.querySelectorAll('[data-view]')];
    for (const control of this.#controls) {
      control.addEventListener('input', () => {
        const { value } = control;
        if (control.type === 'checkbox') {
          address.set({ [control.dataset.view]: control.checked ? 'on' : '' });
          return;
        }
        const numeric = control.type === 'range' || control.type === 'number';
        address.set({ [control.dataset.view]: numeric ? Number(value) : value });
      });
    }
    this.update();
  }

  update() {
    for (const control of this.#controls) {
      const value = String(this.#address.view[control.dataset.view] ?? '');
      if (control.type === 'checkbox') control.checked = value === 'on';
      else if (control.value !== value) control.value = value;
    }
  }
}

// Options as [value, text]; what is chosen stays.
export function show_options(select, options, chosen) {
  const key = JSON.stringify(options);
  if (select.dataset.key !== key) {
    select.dataset.key = key;
    select.replaceChildren(...options.map(([value, text]) => new Option(text, value)));
  }
  select.value = chosen;
}
