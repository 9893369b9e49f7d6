// The three panes of the workspace. From 801 px on they stand side by side; on a phone they are
// swiped between, and tabs show and choose the one in view.

export class Panes {
  #panes;
  #tabs;

  // A tab's data-pane is the id of its pane.
  constructor(tabs) {
    this.#tabs = [...tabs.querySelectorAll('button')];
    this.#panes = this.#tabs.map(({ dataset }) => document.getElementById(dataset.pane));
    for (const tab of this.#tabs) tab.addEventListener('click', () => this.show(tab.dataset.pane));
    const observer = new IntersectionObserver((entries) => {
      for (const { target, isIntersecting } of entries) if (isIntersecting) this.#mark(target.id);
    }, { root: this.#panes[0].parentElement, threshold: 0.6 });
    this.#panes.forEach((pane) => observer.observe(pane));
  }

  show(id) {
    document.getElementById(id).scrollIntoView({ inline: 'start', block: 'nearest' });
  }

  #mark(id) {
    for (const tab of this.#tabs) {
      if (tab.dataset.pane === id) tab.setAttribute('aria-current', 'true');
      else tab.removeAttribute('aria-current');
    }
  }
}
