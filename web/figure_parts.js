// The thesis' figures as jobs: what each shows, and the requests behind it. Settings are those of
// `qray thesis`, which makes the same pictures from the command line.

const kScene = 'thesis-room';
export const kPageLabel = { page: 'thesis-figures' };
const kLesson = { samples: 64, learning_samples: 16 }; // a pixel
// Figures 11 and 13: from lower down and off to the side, at the same target.
const kSecondView = { position: [0.7627, 1.404, 1.6525], target: [0, 1.22, -1] };

// A part is "none-8", "lesson", "huang-80" and so on, with "-b" from the second view.
export const lesson_of = (part) => {
  if (!part.startsWith('huang')) return null;
  return part.endsWith('-b') ? 'lesson-b' : 'lesson';
};

// `table`: what its lesson learned, for parts that have one. `labels`: more of them.
export function part_request(part, size, table, labels) {
  const [name, view] = part.endsWith('-b') ? [part.slice(0, -2), kSecondView] : [part, null];
  const request = { scene: kScene, nee: false, width: size, height: size, seed: 1,
    labels: { ...kPageLabel, part, size: String(size), ...labels } };
  if (view) request.camera = view;
  // From what is known of the room: with `table: none` it would leave nothing for others to read.
  if (name === 'lesson') return { ...request, ...kLesson, method: 'huang', seed: 1001 };
  const at = name.lastIndexOf('-');
  const method = name.slice(0, at);
  Object.assign(request, { method, samples: Number(name.slice(at + 1)) });
  return method === 'none' ? request : { ...request, table, learning_samples: 0 };
}

// Pictures of a figure from the left. `parts`: two are the left and the right half of one picture,
// as in the thesis; `view` and `lobe` are made of what the part learned.
const halves = (samples, view) => [
  { title: 'as published', parts: [`none-${samples}${view}`, `huang-published-${samples}${view}`] },
  { title: 'corrected', parts: [`none-${samples}${view}`, `huang-${samples}${view}`] },
];
const plain = (samples) => [{ title: 'without learning', parts: [`none-${samples}`] },
  { title: 'corrected', parts: [`huang-${samples}`] }];
const kLeftRight = 'Left half without learning, right half with. ';

export const kFigures = [
  { number: 5, title: '8 samples per pixel', pictures: plain(8),
    text: 'Path tracing without learning at 8 samples: rays that never hit the light leave dark ' +
      'pixels. Beside it the corrected method at the same samples.' },
  { number: 6, title: '64 samples per pixel', pictures: plain(64),
    text: 'The same at 64 samples: more rays, less noise.' },
  { number: 8, title: 'Segments of the scene', pictures: [{ title: 'states', view: 'lesson' }],
    text: 'A colour for each state: a cell of the scene with the facing of its surface.' },
  { number: 9, title: '26 standard directions', pictures: [{ title: 'directions', lobe: 'lesson' }],
    text: 'The directions from the centre of a cube to its 26 neighbours, and what was learned ' +
      'of them in the middle of the picture.' },
  { number: 10, title: '8 rays per pixel', pictures: halves(8, ''),
    text: `${kLeftRight}As published, learning is brighter than the truth.` },
  { number: 11, title: '8 rays per pixel, second view', pictures: halves(8, '-b'),
    text: kLeftRight },
  { number: 12, title: '80 rays per pixel', pictures: halves(80, ''),
    text: `${kLeftRight}Compare the noise of the floor.` },
  { number: 13, title: '80 rays per pixel, second view', pictures: halves(80, '-b'),
    text: kLeftRight },
];

export function parts_of(figure) {
  const parts = figure.pictures.flatMap((picture) =>
    picture.parts ?? [picture.view ?? picture.lobe]);
  return [...new Set(parts.flatMap((part) => [lesson_of(part), part]).filter(Boolean))];
}
