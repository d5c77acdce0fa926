// Measures of the slice and of the files, as tables.
import { shown, shownBytes } from './common.js';
import { element, model, viewer } from './page.js';

/** Milliseconds in which the slider moves on. */
const shortWait = 120;

/** The turn counts what was to be measured: answers about anything but the last are too late. */
const waiting = { timer: 0, turn: 0 };

export function measureLater() {
  ++waiting.turn;
  // They are of what was shown before.
  element('measures').ariaBusy = 'true';
  clearTimeout(waiting.timer);
  waiting.timer = setTimeout(measureNow, viewer.player.isPlaying ? 400 : shortWait);
}

/** Measures of the slice, of the bodies that are shown, for each pane. */
async function measureNow() {
  const { turn } = waiting;
  const { panes, state } = model;
  if (state.cut === 'solid' || panes.length === 0) {
    fillTable('measures', []);
    return;
  }
  let answers;
  try {
    answers = await Promise.all(panes.map((pane) => pane.measuresOf(model.plane())));
  } catch {
    // The error was shown when the damaged part was to be shown.
    if (turn === waiting.turn) fillTable('measures', [['', 'not whole']]);
    return;
  }
  if (turn !== waiting.turn) return;
  if (answers.includes(null)) {
    waiting.timer = setTimeout(measureNow, shortWait);
    return;
  }
  element('save').disabled = answers.every((sections) =>
    sections.every(({ name, numTriangles }) => numTriangles === 0 || state.hidden.includes(name)));
  const totals = answers.map((sections) => totalOf(sections.filter(({ name }) => !state.hidden.includes(name))));
  const unit = model.unitOf('length_unit');
  const [squared, cubed] = unitsOf(state.cut, unit, model.unitOf('time_unit'));
  const row = (title, pick) => [title, ...totals.map(pick)];
  fillTable('measures', [
    row('triangles', ({ numTriangles }) => shown(numTriangles)), row('vertices', ({ numPoints }) => shown(numPoints)),
    row(`volume${cubed}`, ({ volume }) => shown(volume)), row(`area${squared}`, ({ area }) => shown(area)),
    ...(model.showsDistances() && viewer.comparison.shown !== null
      ? [['largest distance', shown(viewer.comparison.largest) + (unit ? ` ${unit}` : '')]] : []),
  ]);
}

/** The units of area and volume of a section. One along x has two lengths and a time; its area mixes them. */
function unitsOf(cut, length, time) {
  if (cut === 't' && length) return [`, ${length}²`, `, ${length}³`];
  return ['', cut !== 'any' && length && time ? `, ${length}²·${time}` : ''];
}

const totalOf = (sections) => sections.reduce((sum, each) => ({
  numTriangles: sum.numTriangles + each.numTriangles, numPoints: sum.numPoints + each.numPoints,
  volume: sum.volume + each.volume, area: sum.area + each.area,
}), { numTriangles: 0, numPoints: 0, volume: 0, area: 0 });

function fillTable(id, rows) {
  element(id).ariaBusy = 'false';
  element(id).replaceChildren(...rows.map((cells) => {
    const row = document.createElement('tr');
    row.append(...cells.map((text) => Object.assign(document.createElement('td'), { textContent: text })));
    return row;
  }));
}

export function fillFacts() {
  const { panes } = model;
  const facts = (title, pick) => [title, ...panes.map(pick)];
  if (panes.length === 0) return;
  fillTable('facts', [
    facts('size', ({ info }) => shownBytes(info.size)),
    facts('read', ({ file: { read, requests } }) => `${shownBytes(read)}${requests ? ` in ${requests}` : ''}`),
    facts('cells', ({ info }) => shown(info.bodies.reduce((sum, body) => sum + body.numCells, 0))),
    facts('slabs', ({ info }) => shown(info.bodies.reduce((sum, body) => sum + body.slabs.length, 0))),
    // Numbers stand without a unit where the files have different ones.
    ...(model.haveOneUnit() ? [] : [facts('units',
      ({ info: { head } }) => `${head.length_unit ?? '?'}, ${head.time_unit ?? '?'}`)]),
  ]);
}
