// The controls, filled with what the files have and the state says.
import { shown } from './common.js';
import { element, model } from './page.js';

/** Fills the panel with the contents of the files. */
export function fillPanel() {
  const { panes, state } = model;
  const names = panes.map(({ info }) => info.name).join(' and ');
  document.title = `${names} - t4d viewer`;
  element('title').textContent = names;
  const bodies = panes.flatMap(({ info, bodyColors }) => info.bodies.map(({ name }, i) => ({ name, color: bodyColors[i] })))
    .filter(({ name }, i, all) => all.findIndex((each) => each.name === name) === i);
  element('bodies').replaceChildren(...(bodies.length < 2 ? [] : bodies).map(({ name, color }) => {
    const label = document.createElement('label');
    const box = Object.assign(document.createElement('input'), { type: 'checkbox', checked: !state.hidden.includes(name) });
    box.dataset.body = name;
    box.onchange = () => model.set({
      hidden: box.checked ? model.state.hidden.filter((each) => each !== name) : [...model.state.hidden, name],
    });
    const swatch = Object.assign(document.createElement('span'), { textContent: '■ ' });
    swatch.style.color = color.getStyle();
    label.append(box, ' ', swatch, name);
    return label;
  }));
  for (const span of document.querySelectorAll('.lengthUnit')) span.textContent = model.unitOf('length_unit');
  fillNormal();
}

/** The attributes that there are, as colours to choose. */
export function fillColors() {
  const { panes, state } = model;
  const names = new Map(panes.flatMap((pane) => [...pane.attributeNames()]));
  const options = [['body', 'body'], ['time', 'time'], ['age', 'age'], ['speed', 'speed'],
    ...(model.tracks ? [['track', 'track']] : []),
    ...(panes.length === 2 ? [['distance', 'distance apart']] : []),
    ...[...names.keys()].map((name) => [`attribute:${name}`, name === 'triangle' ? 'original triangle' : name])];
  const select = element('color');
  if (select.dataset.options !== JSON.stringify(options)) {
    select.dataset.options = JSON.stringify(options);
    select.replaceChildren(...options.map(([value, text]) => new Option(text, value)));
  }
  if (!options.some(([value]) => value === state.color)
    && model.areAllOpen && panes.some(({ slabs }) => [...slabs.values()].some(({ gpu }) => gpu))) {
    model.set({ color: 'body' });
  }
  select.value = model.state.color;
}

function fillNormal() {
  element('normal').replaceChildren(...['x', 'y', 'z', 't'].map((name, i) => {
    const label = document.createElement('label');
    const slider = Object.assign(document.createElement('input'), { type: 'range', min: -1, max: 1, step: 0.01 });
    const value = document.createElement('span');
    slider.dataset.normal = i;
    slider.oninput = () => {
      // Time counts as it is shown, so that its slider turns as the others do.
      const { state } = model;
      const normal = [...state.normal];
      normal[i] = Number(slider.value) * (i === 3 ? state.timeScale : 1);
      if (normal.some((each) => each !== 0)) model.turnTo(normal);
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

/** Sets the controls to the state. */
export function fillControls() {
  const { panes, state } = model;
  for (const control of document.querySelectorAll('fieldset, #fit')) control.disabled = panes.length === 0;
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
}
