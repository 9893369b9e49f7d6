// Cameras that people keep, by scene: in this browser, as the address writes them.

const kStored = 'qray-cameras';

function all() {
  try {
    return JSON.parse(localStorage.getItem(kStored)) ?? {};
  } catch {
    return {}; // not what this page wrote
  }
}

// [[name, text]] in the order in which they were kept.
export const kept_cameras = (scene) => Object.entries(all()[scene] ?? {});

// `text`: null forgets it.
export function keep_camera(scene, name, text) {
  const { [scene]: { [name]: old, ...others } = {}, ...rest } = all();
  const own = text === null ? others : { ...others, [name]: text };
  localStorage.setItem(kStored, JSON.stringify({ ...rest, [scene]: own }));
}
