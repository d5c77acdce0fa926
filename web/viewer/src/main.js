import { Client } from './client.js';
import { colorsOf } from './colors.js';
import { shown, shownBytes } from './common.js';
import { glbOf } from './glb.js';
import { filesOfLink } from './link.js';
import { Pane, planeOf, shownAxes } from './pane.js';
import { defaults, hashOf, stateOf } from './state.js';
import { View } from './view.js';

/* global WORKER_CODE */
const client = new Client(WORKER_CODE);
const element = (id) => document.getElementById(id);
const panes = [];
let state = { ...defaults };
let base = { ...defaults }; // the state in which the file was opened, which a link leaves out
let center = [0, 0, 0, 0];
let bounds = { min: [0, 0, 0, 0], max: [1, 1, 1, 1] };
let isDirty = true;
let hasArrivals = false;
let drawnAt = 0;
let drawMilliseconds = 0;
let isPlaying = false;
let direction = 1;
let opened = performance.now();
const speeds = { firstPicture: null, gpu: null, cpu: null };

const view = new View(element('canvas'), element('gizmo'), () => {
  state.camera = [...view.camera.position.toArray(), ...view.controls.target.toArray()];
  invalidate();
  linkLater();
});

function invalidate() {
  isDirty = true;
}

/** More of the same has come: drawn now and then, so that drawing does not hold up the rest. */
function onArrival() {
  hasArrivals = true;
}

// Messages ---------------------------------------------------------------------------------------

let messageOf = ''; // what was shown when the message came

/** What is shown, but for the camera and the looks that no message is about. */
const shownKey = () => JSON.stringify([state.cut, state[sliderKey()], state.normal, state.hidden, state.color, state.drop]);

function say(...lines) {
  const box = element('message');
  box.replaceChildren(...lines.map((line) => Object.assign(document.createElement('p'), { textContent: line })));
  const close = Object.assign(document.createElement('button'), { textContent: 'Close' });
  close.onclick = () => { box.hidden = true; };
  box.append(close);
  box.hidden = false;
  messageOf = shownKey();
}

function showError(error, detail = '') {
  say(...[error.message, detail].filter(Boolean));
  if (error.isKnown === false || error.workerStack) console.error(error.workerStack ?? error);
}

// Files ------------------------------------------------------------------------------------------

/**
 * Opens a file beside those that are there, or instead of them.
 * @param {string|Blob|Uint8Array} from its address, or the file
 * @param {{beside: boolean, name: string, isOwn: boolean}} options `isOwn` of a file that the page comes with
 */
async function openFile(from, { beside = false, name, isOwn = false } = {}) {
  opened = performance.now();
  element('welcome').hidden = true;
  element('message').hidden = true;
  element('busy').hidden = false;
  let info;
  try {
    info = await client.call('open', { from, name });
  } catch (error) {
    element('busy').hidden = true;
    const isRule = error.rule !== undefined;
    showError(new Error(`${name ?? (from.name ?? from)}: ${error.message}`), isRule
      ? 'The file is damaged or is no .t4d file; `t4d recover` saves what is whole of a damaged one.' : '');
    return null;
  }
  if (!beside) {
    for (const pane of panes.splice(0)) pane.dispose();
    speeds.firstPicture = null;
  }
  const bodyColors = colorsOf(info.bodies, panes.flatMap((each) => each.namedColors()));
  const pane = new Pane(view.renderer, client, info, bodyColors, center, onArrival, (error, body, slab) => {
    // Said once of what is shown, also if the box was closed.
    if (body && messageOf === shownKey()) return;
    showError(new Error(`${info.name}: ${error.message}`),
      body && `Of '${body.name}' the time from ${shown(slab.begin)} to ${shown(slab.end)} cannot be shown; the rest can.`);
  });
  pane.link = { name: info.name, address: typeof from === 'string' ? from : null, isOwn };
  panes.push(pane);
  bounds = joinedBounds(panes.map((each) => each.bounds()));
  if (!beside) {
    // All slabs on the GPU are relative to this.
    center = bounds.min.map((low, i) => (low + bounds.max[i]) / 2);
    pane.center = center;
    base = startState(info);
    state = { ...base, ...stateOf(location.hash) };
  }
  document.title = `${panes.map((each) => each.info.name).join(' and ')} - t4d viewer`;
  element('title').textContent = panes.map((each) => each.info.name).join(' and ');
  fillPanel();
  const { camera } = state;
  fitCamera();
  if (!beside && camera) placeCamera(camera);
  onState();
  return pane;
}

function joinedBounds(all) {
  return {
    min: all[0].min.map((_, i) => Math.min(...all.map(({ min }) => min[i]))),
    max: all[0].max.map((_, i) => Math.max(...all.map(({ max }) => max[i]))),
  };
}

function startState({ head }) {
  const middle = bounds.min.map((low, i) => (low + bounds.max[i]) / 2);
  const [width, depth, height, time] = bounds.max.map((high, i) => high - bounds.min[i]);
  const size = Math.max(width, depth, height);
  const timeScale = size > 0 && time > 0 ? Number((size / time).toPrecision(2)) : 1;
  return {
    ...defaults, t: bounds.min[3], x: middle[0], y: middle[1], z: middle[2], timeScale,
    onionStep: Number(((time || 1) / 20).toPrecision(2)), drop: head.up === 'z' ? 'y' : 'z',
    offset: middle[0],
  };
}

// State ------------------------------------------------------------------------------------------

let measureTimer = 0;
let linkTimer = 0;

/** Changes the state; the page follows. */
function set(changes) {
  const before = state;
  state = { ...state, ...changes };
  const isOtherSpace = ['cut', 'drop', 'timeScale'].some((key) => state[key] !== before[key]);
  if (isOtherSpace) fitCamera();
  onState();
}

function onState() {
  isDirty = true;
  if (messageOf !== shownKey()) element('message').hidden = true;
  fillControls();
  measureLater();
  linkLater();
}

function linkLater() {
  clearTimeout(linkTimer);
  linkTimer = setTimeout(() => {
    // While files are on their way, the address says what to show of them.
    if (panes.length === 0 || !areAllOpen) return;
    const { href } = linkNow();
    if (href !== location.href) history.replaceState(null, '', href);
  }, 250);
}

const startSearch = location.search;

/** The address that shows the same again, and the names of the files that it does not open. */
function linkNow() {
  const { search, missing } = filesOfLink(panes.map(({ link }) => link), startSearch, location.href);
  const hash = hashOf(state, base);
  return { href: `${location.href.split(/[?#]/)[0]}${search}${hash && `#${hash}`}`, missing };
}

const cutNames = {
  t: ['x', 'y', 'z'], x: ['y', 'z', 't'], y: ['x', 'z', 't'], z: ['x', 'y', 't'], any: ['u', 'v', 'w'],
};

/** The member of the state that the slider moves. */
const sliderKey = () => (state.cut === 'any' ? 'offset' : state.cut === 'solid' ? 't' : state.cut);

/** The values between which the slider moves. */
function sliderRange() {
  if (state.cut === 'any') {
    const terms = state.normal.map((n, i) => [n * bounds.min[i], n * bounds.max[i]].sort((a, b) => a - b));
    return [0, 1].map((k) => terms.reduce((sum, term) => sum + term[k], 0));
  }
  const axis = ['x', 'y', 'z', 't'].indexOf(sliderKey());
  return [bounds.min[axis], bounds.max[axis]];
}

/** The axes of the solid in space-time, time in the place of one, the others in order. */
function facesAxes() {
  const dropped = ['x', 'y', 'z'].indexOf(state.drop);
  const kept = [0, 1, 2].filter((i) => i !== dropped);
  const unit = (i, length = 1) => [0, 1, 2, 3].map((k) => (k === i ? length : 0));
  return { axes: [unit(kept[0]), unit(kept[1]), unit(3, state.timeScale)], names: [...kept.map((i) => 'xyz'[i]), 't'] };
}

const isSpace = () => state.cut === 't';

function fitCamera() {
  if (panes.length === 0) return;
  const { up } = panes[0].info.head;
  view.setUp(isSpace() ? up ?? 'y' : 'z');
  const axes = state.cut === 'solid' ? facesAxes().axes : shownAxes(planeOf(state), state.timeScale).axes;
  view.labels = state.cut === 'solid' ? facesAxes().names : cutNames[state.cut];
  const half = bounds.max.map((high, i) => (high - bounds.min[i]) / 2);
  const lengths = axes.map((axis) => axis.reduce((sum, part, i) => sum + Math.abs(part) * half[i], 0));
  view.fit(Math.hypot(...lengths));
}

function placeCamera(camera) {
  view.camera.position.set(...camera.slice(0, 3));
  view.controls.target.set(...camera.slice(3));
  view.controls.update();
}

// Drawing ----------------------------------------------------------------------------------------

let isWhole = false;

function lookOf(pane) {
  const isAttribute = state.color.startsWith('attribute:');
  const name = state.color.slice('attribute:'.length);
  const range = isAttribute ? pane.rangeOf(name) : [bounds.min[3] - center[3], bounds.max[3] - center[3]];
  // Of bodies, age is time from their begin on.
  const rangeOfBody = ({ begin }) => (state.color === 'age' ? [begin - center[3], begin - center[3] + longestLife()] : range);
  return { mode: isAttribute ? 'attribute' : state.color, name, rangeOfBody, wireframe: state.wire };
}

const longestLife = () => Math.max(...panes.flatMap(({ info }) => info.bodies.map(({ begin, end }) => end - begin)));

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

/** The distances of the two solids at a time that are shown, or asked for. */
const comparison = { asked: null, shown: null, largest: 0 };

const showsDistances = () => state.color === 'distance' && state.cut === 't' && panes.length === 2;

/** Colours two solids by their distance from each other; whether that is there. The one before stays meanwhile. */
function updateDistances(hidden) {
  const plane = planeOf(state);
  const files = panes.map(({ info }) => info.file);
  const key = JSON.stringify([plane.offset, state.hidden, files]);
  if (comparison.shown === key) return true;
  if (comparison.asked !== null) return false;
  comparison.asked = key;
  const { normal, offset } = plane;
  client.call('distances', { files, normal, offset, hidden: state.hidden }).then((sections) => {
    if (!showsDistances()) return;
    const all = sections.flat().map(({ distances }) => distances ?? []);
    comparison.largest = all.reduce((most, each) => each.reduce((a, b) => Math.max(a, b || 0), most), 0);
    panes.forEach((pane, i) => pane.showSections(sections[i], plane, state.timeScale, hidden, comparison.largest));
    comparison.shown = key;
  }).catch((error) => {
    showError(error);
    comparison.shown = key;
  }).finally(() => {
    comparison.asked = null;
    measureLater();
    onArrival();
  });
  return false;
}

/** Asks the panes for what the state says. */
function update() {
  hasArrivals = false;
  const hidden = new Set(state.hidden);
  if (showsDistances()) {
    isWhole = updateDistances(hidden);
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

function draw() {
  isDirty = false;
  const begin = performance.now();
  view.render(panes);
  if (isWhole && panes.length > 0 && speeds.firstPicture === null) {
    view.finish();
    speeds.firstPicture = performance.now() - opened;
    fillSpeeds();
  }
  if (isWhole) fillColors();
  fillFacts();
  drawnAt = performance.now();
  drawMilliseconds = drawnAt - begin;
}

let lastFrame = 0;

function frame(now) {
  requestAnimationFrame(frame);
  if (isPlaying && panes.length > 0) advance(Math.min(0.1, (now - lastFrame) / 1000));
  lastFrame = now;
  if (!isDirty && !hasArrivals) return;
  const isNew = isDirty;
  update();
  // What arrives is drawn when it is whole, or after a while.
  if (isNew || isWhole || performance.now() - drawnAt > 3 * drawMilliseconds + 100) draw();
}

/** Moves the slider by so many seconds of play. */
function advance(seconds) {
  // A slice is waited for.
  if (!isWhole) return;
  const key = sliderKey();
  const [low, high] = sliderRange();
  const isRealTime = state.cut === 't' && panes[0].info.head.time_unit === 's';
  const rate = (isRealTime ? 1 : (high - low) / 10) * state.speed;
  let value = state[key] + direction * rate * seconds;
  if (value > high || value < low) {
    if (state.loop) {
      value = low + (((value - low) % (high - low)) + (high - low)) % (high - low);
    } else {
      value = Math.min(high, Math.max(low, value));
      play(false);
    }
  }
  set({ [key]: value });
}

function play(on) {
  const [low, high] = sliderRange();
  isPlaying = on && high > low;
  if (isPlaying && state[sliderKey()] >= high) set({ [sliderKey()]: low });
  element('play').textContent = isPlaying ? '❚❚' : '▶';
  element('play').setAttribute('aria-pressed', isPlaying);
}

// Measures ---------------------------------------------------------------------------------------

let measured = 0;

function measureLater() {
  clearTimeout(measureTimer);
  measureTimer = setTimeout(measureNow, isPlaying ? 400 : 120);
}

/** Measures of the slice, of the bodies that are shown, for each pane. */
async function measureNow() {
  const turn = ++measured;
  if (state.cut === 'solid' || panes.length === 0) {
    fillTable('measures', []);
    return;
  }
  const { normal, offset } = planeOf(state);
  let answers;
  try {
    answers = await Promise.all(panes.map(({ info }) => client.call('slice', { file: info.file, normal, offset })));
  } catch {
    // What is damaged was said when it was to be shown.
    if (turn === measured) fillTable('measures', [['', 'not whole']]);
    return;
  }
  if (turn !== measured) return;
  element('save').disabled = answers.every(({ sections }) =>
    sections.every(({ name, numTriangles }) => numTriangles === 0 || state.hidden.includes(name)));
  const totals = answers.map(({ sections }) => totalOf(sections.filter(({ name }) => !state.hidden.includes(name))));
  const unit = panes[0].info.head.length_unit ?? '';
  const [squared, cubed] = isSpace() && unit ? [` ${unit}²`, ` ${unit}³`] : ['', ''];
  const row = (title, pick) => [title, ...totals.map(pick)];
  fillTable('measures', [
    row('triangles', ({ numTriangles }) => shown(numTriangles)), row('vertices', ({ numPoints }) => shown(numPoints)),
    row('volume', ({ volume }) => shown(volume) + cubed), row('area', ({ area }) => shown(area) + squared),
    ...(showsDistances() && comparison.shown !== null
      ? [['largest distance', shown(comparison.largest) + (unit ? ` ${unit}` : '')]] : []),
  ]);
}

const totalOf = (sections) => sections.reduce((sum, each) => ({
  numTriangles: sum.numTriangles + each.numTriangles, numPoints: sum.numPoints + each.numPoints,
  volume: sum.volume + each.volume, area: sum.area + each.area,
}), { numTriangles: 0, numPoints: 0, volume: 0, area: 0 });

function fillTable(id, rows) {
  element(id).replaceChildren(...rows.map((cells) => {
    const row = document.createElement('tr');
    row.append(...cells.map((text) => Object.assign(document.createElement('td'), { textContent: text })));
    return row;
  }));
}

function fillFacts() {
  const facts = (title, pick) => [title, ...panes.map(pick)];
  if (panes.length === 0) return;
  fillTable('facts', [
    facts('size', ({ info }) => shownBytes(info.size)),
    facts('read', ({ read, requests }) => `${shownBytes(read)}${requests ? ` in ${requests}` : ''}`),
    facts('cells', ({ info }) => shown(info.bodies.reduce((sum, body) => sum + body.numCells, 0))),
    facts('slabs', ({ info }) => shown(info.bodies.reduce((sum, body) => sum + body.slabs.length, 0))),
  ]);
}

function fillSpeeds() {
  const lines = [];
  const ms = (value) => (value < 1000 ? `${value.toPrecision(3)} ms` : `${shown(value / 1000, 3)} s`);
  if (speeds.firstPicture !== null) lines.push(`first picture after ${ms(speeds.firstPicture)}`);
  if (speeds.gpu !== null) {
    lines.push(`a frame: ${ms(speeds.gpu)}`);
    lines.push(`cutting on the CPU: ${ms(speeds.cpu)}, ${(speeds.cpu / speeds.gpu).toPrecision(2)} times a frame`);
  }
  element('speeds').textContent = lines.join('\n');
}

/**
 * Milliseconds of a frame while the slider moves, the GPU waited for, and of cutting the same slices on the CPU:
 * medians over times within one slab, which are there.
 */
async function measureSpeed(count = 11) {
  const key = sliderKey();
  const at = state[key];
  const [low, high] = sliderRange();
  const gpu = [];
  const cpu = [];
  for (let i = 0; i < count; ++i) {
    const value = low + (high - low) * (i + 0.37) / count;
    set({ [key]: value });
    await whole();
    // The slabs are there now; the frame of another value of the same slab.
    state = { ...state, [key]: value + (high - low) * 1e-4 };
    const begin = performance.now();
    update();
    draw();
    view.finish();
    gpu.push(performance.now() - begin);
    const { normal, offset } = planeOf(state);
    const answers = await Promise.all(panes.map(({ info }) => client.call('slice', { file: info.file, normal, offset })));
    cpu.push(answers.reduce((sum, { milliseconds }) => sum + milliseconds, 0));
  }
  const median = (values) => values.sort((a, b) => a - b)[values.length >> 1];
  speeds.gpu = median(gpu);
  speeds.cpu = median(cpu);
  set({ [key]: at });
  fillSpeeds();
  return { ...speeds };
}

/** Resolves when all that the state says is drawn. */
async function whole() {
  do {
    await new Promise((resolve) => { requestAnimationFrame(resolve); });
  } while (isDirty || hasArrivals || !isWhole);
}

// The panel --------------------------------------------------------------------------------------

function fillPanel() {
  const { head } = panes[0].info;
  const bodies = panes.flatMap(({ info, bodyColors }) => info.bodies.map(({ name }, i) => ({ name, color: bodyColors[i] })))
    .filter(({ name }, i, all) => all.findIndex((each) => each.name === name) === i);
  element('bodies').replaceChildren(...(bodies.length < 2 ? [] : bodies).map(({ name, color }) => {
    const label = document.createElement('label');
    const box = Object.assign(document.createElement('input'), { type: 'checkbox', checked: !state.hidden.includes(name) });
    box.dataset.body = name;
    box.onchange = () => set({
      hidden: box.checked ? state.hidden.filter((each) => each !== name) : [...state.hidden, name],
    });
    const swatch = Object.assign(document.createElement('span'), { textContent: '■ ' });
    swatch.style.color = color.getStyle();
    label.append(box, ' ', swatch, name);
    return label;
  }));
  for (const span of document.querySelectorAll('.lengthUnit')) span.textContent = head.length_unit ?? '';
  element('names').replaceChildren(...(panes.length < 2 ? [] : panes)
    .map(({ info }) => Object.assign(document.createElement('span'), { textContent: info.name })));
  fillNormal();
}

/** The attributes that there are, as colours to choose. */
function fillColors() {
  const names = new Map(panes.flatMap((pane) => [...pane.attributeNames()]));
  const options = [['body', 'body'], ['time', 'time'],
    ['age', 'age'], ...(panes.length === 2 ? [['distance', 'distance apart']] : []),
    ...[...names.keys()].map((name) => [`attribute:${name}`, name === 'triangle' ? 'original triangle' : name])];
  const select = element('color');
  if (select.dataset.options !== JSON.stringify(options)) {
    select.dataset.options = JSON.stringify(options);
    select.replaceChildren(...options.map(([value, text]) => new Option(text, value)));
  }
  if (!options.some(([value]) => value === state.color)
    && areAllOpen && panes.some(({ slabs }) => [...slabs.values()].some(({ gpu }) => gpu))) {
    set({ color: 'body' });
  }
  select.value = state.color;
  const attribute = names.get(state.color.slice('attribute:'.length));
  const isRamp = ['time', 'age'].includes(state.color) || showsDistances() || (attribute?.components === 1 && state.color !== 'attribute:triangle');
  element('ramp').hidden = !isRamp;
  const range = state.color === 'time' ? [bounds.min[3], bounds.max[3]] : state.color === 'age' ? [0, longestLife()]
    : showsDistances() ? [0, comparison.largest] : isRamp ? panes[0].rangeOf(state.color.slice('attribute:'.length)) : null;
  element('range').textContent = range ? `${shown(range[0])} to ${shown(range[1])}` : '';
  if (isRamp) drawRamp();
}

function drawRamp() {
  const canvas = element('ramp');
  canvas.width = canvas.clientWidth;
  const context = canvas.getContext('2d');
  const gradient = context.createLinearGradient(0, 0, canvas.width, 0);
  ['#440154', '#3b528b', '#21918c', '#5ec962', '#fde725'].forEach((color, i) => gradient.addColorStop(i / 4, color));
  context.fillStyle = gradient;
  context.fillRect(0, 0, canvas.width, canvas.height);
}

function fillNormal() {
  element('normal').replaceChildren(...['x', 'y', 'z', 't'].map((name, i) => {
    const label = document.createElement('label');
    const slider = Object.assign(document.createElement('input'), { type: 'range', min: -1, max: 1, step: 0.01 });
    const value = document.createElement('span');
    slider.dataset.normal = i;
    slider.oninput = () => {
      // Time counts as it is shown, so that its slider turns as the others do.
      const normal = [...state.normal];
      normal[i] = Number(slider.value) * (i === 3 ? state.timeScale : 1);
      if (normal.some((each) => each !== 0)) turnTo(normal);
      else slider.value = state.normal[i] / (i === 3 ? state.timeScale : 1);
    };
    label.append(name, slider, value);
    return label;
  }));
}

/** Turns the hyperplane about the middle of what it cuts. */
function turnTo(normal) {
  const [low, high] = sliderRange();
  const share = high > low ? (state.offset - low) / (high - low) : 0.5;
  state = { ...state, normal };
  const [nextLow, nextHigh] = sliderRange();
  set({ offset: nextLow + share * (nextHigh - nextLow) });
}

function fillControls() {
  for (const button of document.querySelectorAll('[data-cut]')) {
    button.setAttribute('aria-pressed', button.dataset.cut === state.cut);
  }
  element('save').disabled = state.cut === 'solid' || panes.length === 0;
  element('normal').hidden = state.cut !== 'any';
  element('dropped').hidden = state.cut !== 'solid';
  element('timeScaleRow').hidden = state.cut === 't';
  for (const slider of document.querySelectorAll('[data-normal]')) {
    const i = Number(slider.dataset.normal);
    const value = state.normal[i] / (i === 3 ? state.timeScale : 1);
    if (document.activeElement !== slider) slider.value = value;
    slider.nextSibling.textContent = shown(state.normal[i], 3);
  }
  for (const box of document.querySelectorAll('[data-body]')) box.checked = !state.hidden.includes(box.dataset.body);
  const put = (id, key, value) => {
    const input = element(id);
    if (document.activeElement !== input) input[key] = value;
  };
  put('drop', 'value', state.drop);
  put('timeScale', 'value', state.timeScale);
  put('onionStep', 'value', state.onionStep);
  element('onion').value = String(state.onion);
  element('onionStepRow').hidden = state.onion === 0;
  element('wire').checked = state.wire;
  element('speed').value = String(state.speed);
  element('loop').checked = state.loop;
  const [low, high] = sliderRange();
  const slider = element('slider');
  slider.min = low;
  slider.max = high;
  slider.value = state[sliderKey()];
  slider.disabled = state.cut === 'solid';
  put('value', 'value', Number(state[sliderKey()].toPrecision(9)));
  element('axisName').textContent = state.cut === 'any' ? 'offset' : sliderKey();
  const { length_unit: length = '', time_unit: time = '' } = panes[0]?.info.head ?? {};
  element('unit').textContent = { t: time, x: length, y: length, z: length }[sliderKey()] ?? '';
  drawMarks();
}

/** Where the slabs begin and end, on the time line. */
function drawMarks() {
  const canvas = element('marks');
  const width = canvas.clientWidth * devicePixelRatio;
  const style = getComputedStyle(document.body).color;
  const key = JSON.stringify([sliderKey(), width, style, panes.map(({ info }) => info.file)]);
  if (canvas.dataset.key === key) return;
  canvas.dataset.key = key;
  canvas.width = width;
  canvas.height = canvas.clientHeight * devicePixelRatio;
  if (sliderKey() !== 't') return;
  const context = canvas.getContext('2d');
  const [low, high] = sliderRange();
  context.fillStyle = style;
  context.globalAlpha = 0.5;
  // The thumb of a slider keeps this far from its ends.
  const margin = 8 * devicePixelRatio;
  const times = marks();
  const height = times.length > width / 4 ? 0.35 : 0.7;
  for (const time of times) {
    const x = margin + (width - 2 * margin) * (time - low) / (high - low || 1);
    context.fillRect(x, canvas.height * (1 - height), 1, canvas.height * height);
  }
}

/** The times at which slabs begin or end. */
const marks = () => [...new Set(panes.flatMap(({ info }) =>
  info.bodies.flatMap(({ slabs }) => slabs.flatMap(({ begin, end }) => [begin, end]))))].sort((a, b) => a - b);

// Saving -----------------------------------------------------------------------------------------

function download(bytes, name, type) {
  const url = URL.createObjectURL(new Blob([bytes], { type }));
  Object.assign(document.createElement('a'), { href: url, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(url), 60_000);
}

/** The slice of a file as .glb, with its exact points; null of an empty slice. */
async function sliceAsGlb({ info, bodyColors } = panes[0]) {
  const { normal, offset, isTime } = planeOf(state);
  const { sections } = await client.call('slice', { file: info.file, normal, offset, meshes: true });
  const meshes = sections.map((section, i) => ({ ...section, color: bodyColors[i].toArray() }))
    .filter(({ name }) => !state.hidden.includes(name));
  return glbOf(meshes, { isZUp: isTime && info.head.up === 'z' });
}

async function save() {
  if (element('save').disabled) return;
  try {
    const key = sliderKey();
    const empty = [];
    for (const pane of panes) {
      const glb = await sliceAsGlb(pane);
      const name = pane.info.name.replace(/\.t4d$/, '');
      if (glb) download(glb, `${name}-${key === 't' ? 'at-' : key}${shown(state[key])}.glb`, 'model/gltf-binary');
      else empty.push(pane.info.name);
    }
    if (empty.length > 0) say(`Nothing to save of ${empty.join(' and ')}: the slice is empty.`);
  } catch (error) {
    showError(error);
  }
}

// Input ------------------------------------------------------------------------------------------

function step(steps, byMarks) {
  const key = sliderKey();
  const [low, high] = sliderRange();
  let value = state[key] + steps * (high - low) / 200;
  if (byMarks && key === 't') {
    const times = marks();
    value = (steps > 0 ? times.find((time) => time > state.t) : times.findLast((time) => time < state.t)) ?? state.t;
  }
  direction = Math.sign(steps);
  set({ [key]: Math.min(high, Math.max(low, value)) });
}

const themeKey = 't4d-viewer-theme';

function restoreTheme() {
  try {
    const theme = localStorage.getItem(themeKey);
    if (['dark', 'light'].includes(theme)) document.documentElement.dataset.theme = theme;
  } catch {
    // The browser keeps nothing of this page.
  }
}

const isLight = () => getComputedStyle(document.documentElement).colorScheme === 'light'
  || (!document.documentElement.dataset.theme && matchMedia('(prefers-color-scheme: light)').matches);

function switchTheme() {
  const theme = isLight() ? 'dark' : 'light';
  document.documentElement.dataset.theme = theme;
  try {
    localStorage.setItem(themeKey, theme);
  } catch {
    // The browser keeps nothing of this page.
  }
  element('marks').dataset.key = '';
  onState();
}

const keys = {
  ' ': () => play(!isPlaying),
  ArrowLeft: (event) => step(-1, event.shiftKey), ArrowRight: (event) => step(1, event.shiftKey),
  Home: () => set({ [sliderKey()]: sliderRange()[0] }), End: () => set({ [sliderKey()]: sliderRange()[1] }),
  t: () => set({ cut: 't' }), x: () => set({ cut: 'x' }), y: () => set({ cut: 'y' }), z: () => set({ cut: 'z' }),
  h: () => set({ cut: 'any' }), m: () => set({ cut: 'solid' }),
  w: () => set({ wire: !state.wire }), o: () => set({ onion: { 0: 1, 1: 2, 2: 4, 4: 0 }[state.onion] ?? 0 }),
  f: () => fitCamera(), d: switchTheme, s: save,
  p: () => togglePanel(), '?': () => element('keys').showModal(),
};

function togglePanel() {
  element('panel').toggleAttribute('data-hidden');
  invalidate();
}

function listen() {
  addEventListener('keydown', (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    // The keys of form controls are theirs.
    if (event.target.matches('input[type="number"], input[type="text"], select, dialog *')) return;
    if (event.target.matches('button, input[type="checkbox"]') && event.key === ' ') return;
    if (event.target.matches('[data-normal]') && /^(Arrow|Page|Home|End)/.test(event.key)) return;
    if (panes.length === 0 || !Object.hasOwn(keys, event.key)) return;
    event.preventDefault();
    keys[event.key](event);
  });
  const number = (id, key, isRight = Number.isFinite) => {
    element(id).onchange = () => {
      const value = element(id).valueAsNumber;
      if (isRight(value)) set({ [key]: value });
      element(id).value = state[key];
    };
  };
  for (const button of document.querySelectorAll('[data-cut]')) button.onclick = () => set({ cut: button.dataset.cut });
  element('drop').onchange = () => set({ drop: element('drop').value });
  number('timeScale', 'timeScale', (value) => value > 0);
  number('onionStep', 'onionStep', (value) => value > 0);
  element('color').onchange = () => set({ color: element('color').value });
  element('wire').onchange = () => set({ wire: element('wire').checked });
  element('onion').onchange = () => set({ onion: Number(element('onion').value) });
  element('slider').oninput = () => {
    const value = element('slider').valueAsNumber;
    direction = value < state[sliderKey()] ? -1 : 1;
    set({ [sliderKey()]: value });
  };
  element('value').onchange = () => {
    const input = element('value');
    const [low, high] = sliderRange();
    const value = input.valueAsNumber;
    if (Number.isFinite(value)) set({ [sliderKey()]: Math.min(high, Math.max(low, value)) });
    // Also while it is focused.
    input.value = Number(state[sliderKey()].toPrecision(9));
  };
  element('speed').onchange = () => set({ speed: Number(element('speed').value) });
  element('loop').onchange = () => set({ loop: element('loop').checked });
  element('play').onclick = () => {
    direction = 1;
    play(!isPlaying);
  };
  element('fit').onclick = fitCamera;
  element('theme').onclick = switchTheme;
  element('help').onclick = () => element('keys').showModal();
  element('hide').onclick = togglePanel;
  element('save').onclick = save;
  element('link').onclick = async () => {
    const { href, missing } = linkNow();
    const lines = missing.length === 0 ? []
      : [`The link does not open ${missing.join(' and ')}: it can only name files on a web server. Whoever follows it has to open the rest by hand.`];
    try {
      await navigator.clipboard.writeText(href);
    } catch {
      say('The browser does not let this page copy. This is the link:', href, ...lines);
      return;
    }
    if (lines.length > 0) say(...lines);
    element('link').textContent = 'Copied';
    setTimeout(() => { element('link').textContent = 'Copy link'; }, 1500);
  };
  element('measureSpeed').onclick = () => measureSpeed();
  element('compare').onclick = () => element('other').click();
  element('other').onchange = () => openFile(element('other').files[0], { beside: true });
  element('choose').onclick = () => element('chooser').click();
  element('chooser').onchange = () => openFile(element('chooser').files[0]);
  addEventListener('dragover', (event) => event.preventDefault());
  addEventListener('drop', (event) => {
    event.preventDefault();
    const file = event.dataTransfer.files[0] ?? event.dataTransfer.getData('URL');
    if (file) openFile(file, { beside: panes.length > 0 && event.shiftKey });
  });
  addEventListener('hashchange', () => {
    state = { ...base, ...stateOf(location.hash) };
    if (state.camera) placeCamera(state.camera);
    onState();
  });
  new ResizeObserver(() => {
    element('marks').dataset.key = '';
    drawMarks();
    invalidate();
  }).observe(element('stage'));
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => onState());
  // Shift turns the hyperplane: across about its first axis and time, up and down about its second.
  let turning = null;
  const canvas = element('canvas');
  canvas.addEventListener('pointerdown', (event) => {
    if (state.cut !== 'any' || !event.shiftKey) return;
    event.stopImmediatePropagation();
    canvas.setPointerCapture(event.pointerId);
    turning = [event.clientX, event.clientY];
  }, { capture: true });
  canvas.addEventListener('pointermove', (event) => {
    if (!turning) return;
    const { axes } = shownAxes(planeOf(state), 1);
    const [dx, dy] = [(event.clientX - turning[0]) / 200, (turning[1] - event.clientY) / 200];
    turning = [event.clientX, event.clientY];
    const length = Math.hypot(...state.normal);
    turnTo(state.normal.map((n, i) => n / length + dx * axes[0][i] + dy * axes[1][i]));
  }, { capture: true });
  canvas.addEventListener('pointerup', () => { turning = null; }, { capture: true });
}

// Start ------------------------------------------------------------------------------------------

/** The files that the page comes with: [{ name, base64 }] or [{ url }]. */
function ownFiles() {
  const script = element('t4d-files');
  return script ? JSON.parse(script.textContent) : [];
}

const bytesOf = (base64) => Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));

let areAllOpen = false; // the files that the page was asked for

async function start() {
  restoreTheme();
  listen();
  requestAnimationFrame(frame);
  const query = new URLSearchParams(location.search);
  const asked = query.getAll('file').map((url) => ({ url: new URL(url, location.href).href }));
  const files = asked.length > 0 ? asked : ownFiles();
  const { camera } = stateOf(location.hash);
  if (files.length === 0) element('welcome').hidden = false;
  for (const [i, { url, base64, name }] of files.entries()) {
    await openFile(base64 ? bytesOf(base64) : new URL(url, location.href).href, { beside: i > 0, name, isOwn: true });
  }
  // Each file was fitted into the picture.
  if (camera && panes.length > 1) placeCamera(camera);
  areAllOpen = true;
  onState();
}

// For tests, and for scripts in the console.
window.t4dViewer = {
  get state() { return { ...state }; },
  get panes() { return panes; },
  get camera() { return view.camera; },
  set, whole, measureSpeed, sliceAsGlb, speeds,
  measures: () => panes.map((pane) => pane.measureShown(planeOf(state))),
  largestDistance: () => comparison.largest,
  open: openFile,
};
window.t4dViewer.started = start();
