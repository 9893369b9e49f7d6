// The form's fields and the request they mean, both ways. The server says which fields there are,
// with their words, ranges and defaults (GET /v1/fields); those of kOwn stand in index.html, the
// others are made here. A field's name in the form is its path with a dot: "guide.alpha".

const kOwn = ['scene', 'width', 'height', 'method', 'nee', 'samples', 'seconds', 'seed', 'table',
  'pixels', 'recover'];
const kTexts = ['vector', 'labels', 'name', 'names', 'cameras'];
const kUnits = { vector: ' (x, y, z)' };
const kExamples = { labels: 'project: lobby, owner: me', names: 'none; all, or normal, depth',
  cameras: 'one; * is all that the scene names' };
// What a field that is left empty means, where that is not the scene's.
const kEmpty = { noise: 'never', 'frames.turntable': 'one picture', 'frames.degrees': '360',
  'frames.center': 'what the camera looks at', 'frames.axis': "the camera's up",
  'frames.animation': 'at rest', 'frames.from': '0', 'frames.to': 'its end',
  workers: '1; or auto' };

const make = (tag, values) => Object.assign(document.createElement(tag), values);
const name_of = ({ path }) => path.replace('/', '.');
// Those that show_fields() made an input for.
const made = ({ path, label }) => label && !kOwn.includes(path);

const range_words = (field) => {
  if (field.maximum === undefined) return '';
  const least = field.exclusive_minimum === undefined ? `${field.minimum} to` :
    `over ${field.exclusive_minimum} up to`;
  return ` ${least} ${field.maximum}${field.unit && ` ${field.unit}`}.`;
};

function make_field(field) {
  const name = name_of(field);
  const id = `field-${name}`;
  const error = make('p', { id: `${name}-error`, className: 'field-error' });
  const help = make('p', { id: `${name}-help`, className: 'visually-hidden',
    textContent: field.help + range_words(field) });
  const unit = kUnits[field.type] ?? (field.unit && ` (${field.unit})`);
  const label = make('label', { htmlFor: id, title: help.textContent,
    textContent: field.label + unit });
  const of = make('div', { className: 'field' });
  of.dataset.methods = (field.methods ?? []).join(' ');
  let input;
  if (field.type === 'boolean') {
    of.className = 'field wide check';
    input = make('input', { type: 'checkbox', checked: field.default });
  } else if (kTexts.includes(field.type)) {
    of.className = 'field wide';
    input = make('input', { type: 'text',
      placeholder: kEmpty[name] ?? kExamples[field.type] ?? "the scene's" });
  } else if (field.type === 'choice') {
    input = make('select', {});
    const choices = field.choices.map(({ value, label }) => new Option(label, value));
    if (field.default === undefined) choices.unshift(new Option('', ''));
    input.append(...choices);
  } else {
    input = make('input', { type: field.word ? 'text' : 'number', step: 'any',
      placeholder: field.default ?? kEmpty[name] ?? "the scene's" });
  }
  Object.assign(input, { id, name });
  input.setAttribute('aria-describedby', `${help.id} ${error.id}`);
  of.append(...(field.type === 'boolean' ? [input, label] : [label, input]), help, error);
  return of;
}

// What index.html has already gets the server's choices and words.
function complete_own(form, field) {
  const own = form.elements[field.path];
  if (!own) return;
  own.title = field.help;
  if (own.tagName !== 'SELECT' || !field.choices) return;
  const chosen = own.value || field.default;
  const others = [...own.querySelectorAll('option[data-own]')];
  const choices = field.choices.map(({ value, label }) => new Option(label, value));
  own.replaceChildren(...choices, ...others);
  own.value = chosen;
}

// Once: the server's fields do not change while it runs.
export function add_fields(form, fields) {
  for (const field of fields) complete_own(form, field);
  form.querySelector('.made-fields').replaceChildren(...fields.filter(made).map(make_field));
}

// A setting of a guide shows for its own methods alone.
export function show_for_method(form, method) {
  for (const of of form.querySelectorAll('.made-fields > .field')) {
    const { methods } = of.dataset;
    of.hidden = methods !== '' && !methods.split(' ').includes(method);
  }
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

const to_names = (text) => text.split(',').map((name) => name.trim()).filter((name) => name);
// Such names, or the JSON of a list.
function to_cameras(text) {
  if (text.trim().startsWith('[')) {
    try {
      return JSON.parse(text);
    } catch {
      return text; // the server says what it expects
    }
  }
  return to_names(text);
}

const kRead = { vector: to_vector, labels: to_labels, cameras: to_cameras, names: to_names,
  choice: (text) => text };
const kShow = {
  cameras: (value) => (value.every((camera) => typeof camera === 'string') ? value.join(', ')
    : JSON.stringify(value)),
  vector: (value) => value.join(', '),
  names: (value) => value.join(', '),
  labels: (value) => Object.entries(value).map((label) => label.join(': ')).join(', '),
};

// The object that holds the path's member, made where it is not there yet.
const holder_of = (request, path) => {
  const [group, member] = path.split('/');
  return member ? [request[group] ??= {}, member] : [request, group];
};
const value_at = (request, path) => path.split('/').reduce((at, name) => at?.[name], request);

function put(request, { path, type }, input) {
  if (input.closest('[hidden]')) return;
  if (type === 'boolean') {
    const [to, name] = holder_of(request, path);
    to[name] = input.checked;
  } else if (input.value.trim() !== '') {
    const [to, name] = holder_of(request, path);
    to[name] = kRead[type]?.(input.value) ?? to_number(input.value);
  }
}

// `form`: its elements; `fields`: the server's.
export function read_request(form, fields) {
  const request = { nee: form.nee.checked };
  for (const name of ['scene', 'method', 'pixels', 'recover']) request[name] = form[name].value;
  if (!form.table.disabled) request.table = form.table.value;
  const number = (path, input) => put(request, { path, type: 'number' }, input);
  number(form.budget.value, form.amount);
  for (const path of ['width', 'height', 'seed']) number(path, form[path]);
  for (const field of fields.filter(made)) put(request, field, form[name_of(field)]);
  return request;
}

// `request` as a job has it. A value that a select does not offer (a table that is gone) leaves it
// at its first.
export function fill_fields(form, fields, request) {
  const set = (name, value) => {
    const field = form[name];
    const known = field.tagName !== 'SELECT' ||
      [...field.options].some((option) => option.value === value);
    field.value = known ? value ?? '' : field.options[0]?.value ?? '';
  };
  for (const name of ['scene', 'method', 'pixels', 'recover', 'width', 'height', 'seed']) {
    set(name, request[name]);
  }
  set('table', request.table ?? 'auto');
  form.nee.checked = request.nee;
  const budget = request.seconds ? 'seconds' : 'samples';
  set('budget', budget);
  set('amount', request[budget]);
  for (const field of fields.filter(made)) {
    const value = value_at(request, field.path);
    const input = form[name_of(field)];
    if (field.type === 'boolean') input.checked = value ?? field.default;
    else input.value = value === undefined ? '' : kShow[field.type]?.(value) ?? value;
  }
}

// The field that a pointer of the server's message is about.
export function field_of(pointer) {
  const [name, member] = pointer.split('/').slice(1);
  if (name === 'samples' || name === 'seconds') return 'amount';
  return ['camera', 'frames', 'guide'].includes(name) && member ? `${name}.${member}` : name ?? '';
}
