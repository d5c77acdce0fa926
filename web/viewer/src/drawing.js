// Draws what the state says.
import { view } from './camera.js';
import { element } from './common.js';
import { comparison, showsDistances, updateDistances } from './comparison.js';
import { measureLater } from './measures.js';
import { bounds, center, facesAxes, longestLife, panes, sliderKey, state } from './page.js';
import { planeOf } from './pane.js';
import { direction } from './play.js';

/** Whether all that the state says is there. */
export let isWhole = false;
let isDirty = true;
let hasArrivals = false;
let drawnAt = 0;
/** What it takes to draw the picture, but for sketches in its place. */
let drawMilliseconds = 0;
/** Whether the camera moves, where the picture does not follow. */
let isMoving = false;
let restTimer = 0;

/** Of a picture that takes longer, sketches are drawn while the camera moves, and while another is waited for. */
const slowMilliseconds = 100;
const isSlow = () => drawMilliseconds > slowMilliseconds;

/** Without a move in as many milliseconds, the camera rests. */
const restMilliseconds = 250;

export function invalidate() {
  isDirty = true;
}

/** The camera has moved. */
export function onMove() {
  isDirty = true;
  isMoving = isSlow();
  clearTimeout(restTimer);
  if (!isMoving) return;
  restTimer = setTimeout(() => {
    isMoving = false;
    isDirty = true;
  }, restMilliseconds);
}

/** More of the same has come: drawn now and then, so that drawing does not hold up the rest, but a picture at once. */
export function onArrival({ isPicture = false } = {}) {
  hasArrivals = true;
  isDirty ||= isPicture;
}

function lookOf(pane) {
  const isAttribute = state.color.startsWith('attribute:');
  const name = state.color.slice('attribute:'.length);
  const range = isAttribute ? pane.rangeOf(name) ?? [0, 1] : [bounds.min[3] - center[3], bounds.max[3] - center[3]];
  // Of bodies, age is time from their begin on.
  const rangeOfBody = ({ begin }) => (state.color === 'age' ? [begin - center[3], begin - center[3] + longestLife()] : range);
  return { mode: isAttribute ? 'attribute' : state.color, name, rangeOfBody, wireframe: state.wire };
}

/** The planes that are shown: that of the state, then those of the onion skin. */
function planesOf() {
  const planes = [{ plane: planeOf(state), opacity: 1 }];
  if (state.cut === 'any') return planes;
  const key = sliderKey();
  for (let i = 1; i <= state.onion; ++i) {
    for (const side of [-1, 1]) {
      planes.push({
        plane: planeOf({ ...state, [key]: state[key] + side * i * state.onionStep }),
        opacity: 0.35 * (1 - (i - 1) / (state.onion + 1)),
      });
    }
  }
  return planes;
}

/** Asks the panes for what the state says. */
export function update() {
  hasArrivals = false;
  const hidden = new Set(state.hidden);
  if (showsDistances()) {
    isWhole = updateDistances(hidden, () => {
      measureLater();
      onArrival();
    });
    element('busy').hidden = isWhole;
    return;
  }
  comparison.shown = null;
  isWhole = true;
  for (const pane of panes) {
    const faces = state.cut === 'solid' ? facesAxes() : null;
    const what = { planes: faces ? [] : planesOf(), timeScale: state.timeScale, hidden, look: lookOf(pane), faces };
    const isThere = pane.show(what);
    isWhole = isThere && isWhole;
    if (isThere && state.cut === 't') pane.prefetch(planeOf(state), direction);
  }
  element('busy').hidden = isWhole;
}

export function draw() {
  isDirty = false;
  const isRough = isSlow() && (isMoving || !isWhole);
  for (const pane of panes) pane.setRough(isRough);
  view.render(panes);
  drawnAt = performance.now();
  const begin = drawnAt;
  if (!isRough) view.whenDrawn(() => { drawMilliseconds = performance.now() - begin; });
}

/** Draws what has changed; whether it has. */
export function drawChanges() {
  if (!isDirty && !hasArrivals) return false;
  const isNew = isDirty;
  update();
  // What arrives is drawn when it is whole, or after a while.
  if (!isNew && !isWhole && performance.now() - drawnAt <= 3 * drawMilliseconds + 100) return false;
  draw();
  return true;
}

/** Resolves when all that the state says is drawn. */
export async function whole() {
  do {
    await new Promise((resolve) => { requestAnimationFrame(resolve); });
  } while (isDirty || hasArrivals || !isWhole || isMoving);
}
