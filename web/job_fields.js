// The form's fields and the request they mean, both ways. Left-out fields are the server's
// defaults.

const kPlain = ['scene', 'method', 'pixels', 'recover'];
const kNumbers = ['noise', 'width', 'height', 'seed', 'max_depth', 'learning_samples', 'alpha',
  'gamma', 'grid', 'priority'];
const kCameraVectors = ['position', 'target', 'up'];
const kCameraNumbers = ['vertical_fov_deg', 'aperture_radius', 'focus_distance'];

const kOwn = "the scene's";
// Under "More options": [name, label, what it is when left out]; texts take the whole width.
const kMore = [['noise', 'Stop at noise', 'never'], ['priority', 'Priority', '0'],
  ['labels', 'Labels', 'project: lobby, owner: me'], ['max_depth', 'Longest path', kOwn],
  ['learning_samples', 'Learning samples', 'all'], ['alpha', 'Alpha (huang)', '0.02'],
  ['gamma', 'Gamma (huang)', '0.2'], ['grid', 'Grid (huang)', '24'],
  ['camera.vertical_fov_deg', 'Field of view (°)', kOwn],
  ['camera.position', 'Camera at (x, y, z)', kOwn], ['camera.target', 'Looking at (x, y, z)', kOwn],
  ['camera.up', 'Up (x, y, z)', kOwn], ['camera.aperture_radius', 'Aperture radius (m)', kOwn],
  ['camera.focus_distance', 'Focus distance (m)', kOwn]];
const kTexts = ['labels', ...kCameraVectors.map((name) => `camera.${name}`)];

export function add_more_fields(parent) {
  const make = (tag, values) => Object.assign(document.createElement(tag), values);
  parent.append(...kMore.map(([name, label, placeholder]) => {
    const is_text = kTexts.includes(name);
    const id = `field-${name}`;
    const input = make('input', { id, name, placeholder, type: is_text ? 'text' : 'number' });
    if (!is_text) input.step = 'any';
    input.setAttribute('aria-describedby', `${name}-error`);
    const field = make('div', { className: is_text ? 'field wide' : 'field' });
    field.append(make('label', { htmlFor: id, textContent: label }), input,
      make('p', { id: `${name}-error`, className: 'field-error' }));
    return field;
  }));
}

// What is no number stays text, so that the server says what it expects.
const to_number = (text) => (Number.isFinite(Number(text)) ? Number(text) : text.trim());
const to_vector = (text) => text.split(/[\s,;]+/).filter((part) => part).map(to_number);
// "project: lobby, owner: me"
const to_labels = (text) => Object.fromEntries(text.split(',').filter((part) => part.trim())
  .map((part) => {
    const at = part.indexOf(':');
    return at < 0 ? [part.trim(), ''] : [part.slice(0, at).trim(), part.slice(at + 1).trim()];
  }));

export function read_request(fields) {
  const request = { nee: fields.nee.checked };
  for (const name of kPlain) request[name] = fields[name].value;
  if (!fields.table.disabled) request.table = fields.table.value;
  const put = (to, name, input, read = Number) => {
    if (input.value.trim() !== '') to[name] = read(input.value);
  };
  put(request, fields.budget.value, fields.amount);
  for (const name of kNumbers) put(request, name, fields[name]);
  put(request, 'labels', fields.labels, to_labels);
  const camera = {};
  for (const name of kCameraVectors) put(camera, name, fields[`camera.${name}`], to_vector);
  for (const name of kCameraNumbers) put(camera, name, fields[`camera.${name}`]);
  if (Object.keys(camera).length) request.camera = camera;
  return request;
}

// `request` as a job has it. A value that a select does not offer (a table that is gone) leaves it
// at its first.
export function fill_fields(fields, request) {
  const set = (name, value) => {
    const field = fields[name];
    const known = field.tagName !== 'SELECT' ||
      [...field.options].some((option) => option.value === value);
    field.value = known ? value ?? '' : field.options[0].value;
  };
  for (const name of kPlain) set(name, request[name]);
  set('table', request.table ?? 'auto');
  fields.nee.checked = request.nee;
  const budget = request.seconds ? 'seconds' : 'samples';
  set('budget', budget);
  set('amount', request[budget]);
  for (const name of kNumbers) set(name, request[name]);
  set('labels', Object.entries(request.labels ?? {}).map((label) => label.join(': ')).join(', '));
  for (const name of kCameraVectors) {
    set(`camera.${name}`, request.camera?.[name]?.join(', '));
  }
  for (const name of kCameraNumbers) set(`camera.${name}`, request.camera?.[name]);
}

// The field that a pointer of the server's message is about.
export function field_of(pointer) {
  const [name, member] = pointer.split('/').slice(1);
  if (name === 'samples' || name === 'seconds') return 'amount';
  return name === 'camera' && member ? `camera.${member}` : name ?? '';
}
