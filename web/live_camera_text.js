// Cameras as the address and kept ones have them: six numbers, and f (field of view) or h (height
// of parallel rays).
export function camera_text({ position, target, projection, vertical_fov_deg: fov, height }) {
  const short = (v) => String(Number(v.toPrecision(5)));
  const more = projection === 'orthographic' ? height && `h${short(height)}`
    : fov && `f${short(fov)}`;
  return [...position, ...target].map(short).concat(more || []).join();
}

// `base` as the text changes it; null where it is no camera.
export function with_text(base, text) {
  const parts = text.split(',');
  const numbers = parts.slice(0, 6).map(Number);
  if (numbers.length < 6 || !numbers.every(Number.isFinite)) return null;
  const camera = { ...base, position: numbers.slice(0, 3), target: numbers.slice(3) };
  const more = Number(parts[6]?.slice(1));
  if (more > 0) camera[parts[6][0] === 'h' ? 'height' : 'vertical_fov_deg'] = more;
  return camera;
}
