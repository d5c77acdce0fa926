// The controls, filled with what the files have and the state says.
import { element, shown } from './common.js';
import { comparison, showsDistances } from './comparison.js';
import { areAllOpen, bounds, longestLife, marks, panes, set, sliderKey, sliderRange, state, turnTo, unitOf } from './page.js';

/** What there is in the files. */
export function fillPanel() {
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
  for (const span of document.querySelectorAll('.lengthUnit')) span.textContent = unitOf('length_unit');
  element('names').replaceChildren(...(panes.length < 2 ? [] : panes)
    .map(({ info }) => Object.assign(document.createElement('span'), { textContent: info.name })));
  fillNormal();
}

/** The attributes that there are, as colours to choose. */
export function fillColors() {
  const names = new Map(panes.flatMap((pane) => [...pane.attributeNames()]));
  const options = [['body', 'body'], ['time', 'time'], ['age', 'age'],
    ...(panes.length === 2 ? [['distance', 'distance apart']] : []),
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
  const range = rangeOf(state.color, names.get(state.color.slice('attribute:'.length)));
  element('ramp').hidden = !range;
  element('range').textContent = range ? `${shown(range[0])} to ${shown(range[1])}` : '';
  if (range) drawRamp();
}

/** The numbers at the ends of the ramp; null where colours are no numbers. */
function rangeOf(color, attribute) {
  if (color === 'time') return [bounds.min[3], bounds.max[3]];
  if (color === 'age') return [0, longestLife()];
  if (showsDistances()) return [0, comparison.largest];
  // The solid in space-time has colours of whole numbers only.
  const isNumber = attribute?.components === 1 && color !== 'attribute:triangle' && state.cut !== 'solid';
  return isNumber ? panes[0].rangeOf(color.slice('attribute:'.length)) : null;
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

const meanings = {
  t: 'The solid at one time. Marks on the time line show where slabs, the steps of the file, begin and end.',
  x: 'What passes through the plane at this x: y and z in the picture, and time as the third axis.',
  y: 'What passes through the plane at this y: x and z in the picture, and time as the third axis.',
  z: 'What passes through the plane at this z: x and y in the picture, and time as the third axis.',
  any: 'A section by any hyperplane of space-time. The sliders turn its normal; offset moves it along the normal.',
  solid: 'The whole motion as one object in space-time, with time in the place of one axis.',
};

/** What the state says. */
export function fillControls() {
  const isEmpty = panes.length === 0;
  for (const control of document.querySelectorAll('fieldset, #fit, #time :is(button, input, select)')) {
    control.disabled = isEmpty;
  }
  element('meaning').textContent = meanings[state.cut];
  document.body.dataset.files = panes.length;
  for (const button of document.querySelectorAll('[data-cut]')) {
    button.setAttribute('aria-pressed', button.dataset.cut === state.cut);
  }
  element('save').disabled = state.cut === 'solid';
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
  slider.disabled = isEmpty || state.cut === 'solid';
  put('value', 'value', Number(state[sliderKey()].toPrecision(9)));
  element('axisName').textContent = state.cut === 'any' ? 'offset' : sliderKey();
  element('unit').textContent = unitOf({ t: 'time_unit', x: 'length_unit', y: 'length_unit', z: 'length_unit' }[sliderKey()]);
  drawMarks();
}

/** Where the slabs begin and end, on the time line. */
export function drawMarks() {
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
