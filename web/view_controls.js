// Native controls that are members of the address: `data-view="ev"` on a select or an input. They
// follow the address and set it.

export class ViewControls {
  #controls;
  #address;

  constructor(root, address) {
    this.#address = address;
    this.#controls = [...root.querySelectorAll('[data-view]')];
    for (const control of this.#controls) {
      control.addEventListener('input', () => {
        const { value } = control;
        const numeric = control.type === 'range' || control.type === 'number';
        address.set({ [control.dataset.view]: numeric ? Number(value) : value });
      });
    }
    this.update();
  }

  update() {
    for (const control of this.#controls) {
      const value = String(this.#address.view[control.dataset.view] ?? '');
      if (control.value !== value) control.value = value;
    }
  }
}
