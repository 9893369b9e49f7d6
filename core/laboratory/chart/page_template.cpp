#include "core/laboratory/chart/page_template.h"

namespace qray {

const char* const kPageStyle = R"css(
:root {
  color-scheme: light dark;
  --ground: #f4f3f0; --card: #fff; --text: #1d1e20; --muted: #5d6066; --line: #dfddd7;
  --accent: #a24a06; --bad: #b3261e; --bad-soft: #fbeae9; --calm-soft: #ecebe7; --stage: #1b1c1e;
  font: 15px/1.45 system-ui, "Segoe UI", Roboto, "Noto Sans", "DejaVu Sans", sans-serif;
  font-variant-numeric: tabular-nums;
}
@media screen and (prefers-color-scheme: dark) {
  :root {
    --ground: #131416; --card: #1c1d20; --text: #ecedef; --muted: #a2a5ac; --line: #313338;
    --accent: #f0b35a; --bad: #ff9a92; --bad-soft: #3a1f1d; --calm-soft: #2a2c30; --stage: #0b0b0c;
  }
}
*, *::before, *::after { box-sizing: border-box; }
body { margin: 0 auto; max-width: 1280px; padding: 0 16px 32px; background: var(--ground);
  color: var(--text); }
h1 { font-size: 1.5rem; margin: 20px 0 4px; }
h2 { font-size: 1.2rem; margin: 0; overflow-wrap: anywhere; }
p { margin: 4px 0; }
a { color: var(--accent); }
nav a { margin-right: 14px; }
img { display: block; max-width: 100%; }
code { font: 0.92em ui-monospace, "DejaVu Sans Mono", monospace; overflow-wrap: anywhere; }
:focus-visible { outline: 2px solid var(--accent); outline-offset: 2px; }
.muted { color: var(--muted); }
.card { background: var(--card); border: 1px solid var(--line); border-radius: 10px;
  padding: 14px 16px; margin: 16px 0; }
summary { font-weight: 650; cursor: pointer; }
dl { display: grid; grid-template-columns: max-content 1fr; gap: 6px 16px; margin: 10px 0 0; }
dt { font-weight: 650; }
dd { margin: 0; max-width: 80ch; overflow-wrap: anywhere; }
.two { display: grid; grid-template-columns: 1fr 1fr; gap: 20px; align-items: start;
  margin: 12px 0; }
.two > * { min-width: 0; }
.plot { overflow-x: auto; }
.plot img { width: 100%; min-width: 500px; background: #fff; border-radius: 6px; }
.badge { display: inline-block; padding: 0 8px; border-radius: 9px; font-size: 0.85em;
  background: var(--bad-soft); color: var(--bad); }
.badge.calm { background: var(--calm-soft); color: var(--text); }

.wide { overflow-x: auto; }
table { border-collapse: collapse; width: 100%; }
th, td { padding: 6px 10px; text-align: right; vertical-align: top;
  border-bottom: 1px solid var(--line); }
thead th { vertical-align: bottom; font-size: 0.87em; color: var(--muted); }
th:first-child { text-align: left; }
tbody th { font-weight: 600; min-width: 9em; overflow-wrap: anywhere; }
td small { display: block; color: var(--muted); white-space: nowrap; }

.compare { display: none; }
.js .compare { display: block; }
.js .shots { display: none; }
.choose { display: flex; flex-wrap: wrap; gap: 8px 14px; margin-bottom: 10px; }
.choose label { color: var(--muted); font-size: 0.87em; min-width: 0; }
.choose select { font: inherit; display: block; padding: 5px 6px; max-width: 100%;
  color: var(--text); background: var(--card); border: 1px solid #8d9097; border-radius: 6px; }
.frame { position: relative; overflow: hidden; background: var(--stage); border-radius: 6px;
  cursor: ew-resize; touch-action: pan-y; user-select: none; }
.stage { overflow: hidden; scrollbar-width: thin; }
.zoomed { cursor: grab; touch-action: auto; }
.zoomed .stage { overflow: auto; }
.sheet { position: relative; width: calc(100% * var(--zoom, 1)); }
.sheet img { position: absolute; width: 100%; height: 100%; max-width: none;
  pointer-events: none; }
.sheet.pixelated img { image-rendering: pixelated; }
.handle { position: absolute; top: 0; bottom: 0; width: 44px; margin-left: -22px;
  touch-action: none; cursor: ew-resize;
  background: linear-gradient(#fff, #fff) center / 2px 100% no-repeat; }
.handle::after { content: "\2194"; position: absolute; top: 50%; left: 6px; width: 32px;
  height: 32px; margin-top: -16px; border-radius: 50%; background: #fff; color: #1d1e20;
  font: 20px/32px "DejaVu Sans", sans-serif; text-align: center; }
.compare input[type=range] { display: block; width: 100%; height: 32px; margin: 4px 0;
  accent-color: var(--accent); }
.captions { display: grid; grid-template-columns: 1fr 1fr; gap: 16px; font-size: 0.92em; }
.captions > * { min-width: 0; overflow-wrap: anywhere; }
.captions > :last-child { text-align: right; }
.scale { display: flex; gap: 8px; align-items: center; font-size: 0.87em; color: var(--muted); }
.scale::before { content: "less"; }
.scale i { flex: 0 1 160px; height: 10px; border-radius: 5px; background: linear-gradient(
  to right, #440154, #3b528b, #21918c, #5ec962, #fde725); print-color-adjust: exact; }
.compare .scale { display: none; }
.compare .scale.shown { display: flex; }
.shots .scale { grid-column: 1 / -1; }

.shots { display: grid; grid-template-columns: repeat(auto-fill, minmax(200px, 1fr)); gap: 16px; }
figure { margin: 0; }
.shots img { width: 100%; margin-bottom: 4px; }
figcaption { font-size: 0.92em; overflow-wrap: anywhere; }

@media (max-width: 900px) {
  .two { grid-template-columns: minmax(0, 1fr); }
  .wide th:first-child { position: sticky; left: 0; background: var(--card); max-width: 42vw; }
}
@media (max-width: 600px) {
  body { padding: 0 8px 24px; }
  .card { padding: 12px; }
  .choose { display: grid; grid-template-columns: repeat(2, minmax(0, 1fr)); }
  .choose select { width: 100%; }
  dl { grid-template-columns: minmax(0, 1fr); gap: 0; }
  dd { margin-bottom: 8px; }
}
@media print {
  :root { color-scheme: light; font-size: 10px; --ground: #fff; }
  body { max-width: none; padding: 0; }
  nav, .js .compare { display: none; }
  .card { border: 0; padding: 0; }
  .scene { break-before: page; }
  .two { display: block; max-width: 130mm; }
  th, td { padding: 3px 5px; }
  .badge { border: 1px solid; }
  .js .shots { display: grid; }
  .shots { grid-template-columns: repeat(4, 1fr); gap: 3mm; margin-top: 4mm; }
  .shots figure { break-inside: avoid; }
}
)css";

const char* const kPageTerms = R"html(
<p>Each line is a way to render the same scene: the lower it is at a time, the less noise that time
buys. Both axes are logarithmic.</p>
<dl>
<dt>error</dt><dd>relMSE: the mean over pixels and colours of (x &minus; r)&sup2; / (r&sup2; +
0.01), where x is the picture and r the reference. Where only noise is left, twice the time halves
it.</dd>
<dt>floor</dt><dd>The reference is itself a rendered picture. Its own error, estimated from its two
halves, is the floor. Below twice the floor an error tells more of the reference than of the method:
lines end there, and figures are marked.</dd>
<dt>efficiency</dt><dd>1 / (error &times; seconds), over that of <code>none</code>: at 4,
<code>none</code> needs four times as long for the same error. Small: the interval that holds it
with 95 %, from runs with the same seeds. Trimmed: without the 0.1 % of pixels that are worst.</dd>
<dt>time to equal error</dt><dd>The time until the error is what <code>none</code> ends with, over
the time that <code>none</code> took: 0.25 is a quarter.</dd>
<dt>slope</dt><dd>Of the line's last half. &minus;1 where only noise is left; nearer to 0, more time
does not help as it should.</dd>
<dt>brightness</dt><dd>The picture's mean over the reference's; z, how many standard errors it is
from 1. With few seeds chance alone can make z large.</dd>
<dt>biased</dt><dd>The pictures tend to something else than the truth, however long they take. Said
of methods that do not claim otherwise, and of those whose brightness is off by more than chance
makes it in 1 chart of 100. Their lines are dashed.</dd>
<dt>warm</dt><dd>Started from the table that an earlier job on the scene left. The time of that job
is not counted.</dd>
<dt>FLIP</dt><dd>The difference that an eye sees when flipping between picture and reference, from 0
to 1.</dd>
</dl>
)html";

const char* const kPageScript = R"js(
'use strict';
for (const compare of document.querySelectorAll('.compare')) {
  const one = (selector) => compare.querySelector(selector);
  const frame = one('.frame'), stage = one('.stage'), sheet = one('.sheet');
  const handle = one('.handle'), range = one('input'), zoom = one('.zoom'), what = one('.what');
  const sides = ['left', 'right'].map((side) => ({ image: one(`.sheet .${side}`),
    choice: one(`select.${side}`), caption: one(`.captions .${side}`) }));
  const shots = compare.closest('section').querySelectorAll('.shots figure');

  function show() {
    for (const { image, choice, caption } of sides) {
      const shot = shots[choice.value];
      const source = shot.querySelector(`.${what.value}`) ?? shot.querySelector('.picture');
      image.src = source.src;
      image.alt = source.alt;
      caption.replaceChildren(...shot.querySelector('figcaption').cloneNode(true).childNodes);
    }
    one('.scale').classList.toggle('shown', what.value === 'error');
  }

  // The line stays where it is in the frame while the sheet moves below it.
  function split() {
    const x = stage.clientWidth * range.value / 100;
    handle.style.left = `${x}px`;
    sides[1].image.style.clipPath = `inset(0 0 0 ${stage.scrollLeft + x}px)`;
    sheet.classList.toggle('pixelated', sheet.clientWidth >= sides[0].image.naturalWidth);
  }

  function magnify() {
    const before = sheet.clientWidth;
    const center = [stage.scrollLeft + stage.clientWidth / 2, stage.scrollTop +
      stage.clientHeight / 2];
    frame.classList.toggle('zoomed', zoom.value > 1);
    sheet.style.setProperty('--zoom', zoom.value);
    const grown = sheet.clientWidth / before;
    stage.scrollTo(center[0] * grown - stage.clientWidth / 2,
      center[1] * grown - stage.clientHeight / 2);
    split();
  }

  // A drag moves the line; beside it, where the sheet is larger than the frame, it moves the sheet.
  let drag = null;
  function follow(event) {
    if (drag === 'line') {
      range.value = (event.clientX - stage.getBoundingClientRect().left) / stage.clientWidth * 100;
      split();
    } else if (drag === 'sheet') {
      stage.scrollBy(-event.movementX, -event.movementY);
    }
  }
  frame.addEventListener('pointerdown', (event) => {
    const zoomed = zoom.value > 1 && event.target !== handle;
    if (zoomed && event.pointerType !== 'mouse') return; // the browser scrolls by itself
    if (event.button !== 0 || event.offsetX > event.target.clientWidth) return; // a scrollbar
    drag = zoomed ? 'sheet' : 'line';
    frame.setPointerCapture(event.pointerId);
    if (drag === 'line') follow(event);
  });
  frame.addEventListener('pointermove', follow);
  for (const end of ['pointerup', 'pointercancel']) frame.addEventListener(end, () => drag = null);

  for (const select of [sides[0].choice, sides[1].choice, what]) {
    select.addEventListener('change', show);
  }
  zoom.addEventListener('change', magnify);
  range.addEventListener('input', split);
  stage.addEventListener('scroll', split);
  sides[0].image.addEventListener('load', split);
  new ResizeObserver(split).observe(stage);
  show();
}
)js";

}  // namespace qray
