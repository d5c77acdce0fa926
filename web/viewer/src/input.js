// Keys, buttons, files that are dropped, and the pointer.
import { fitCamera, restoreCamera } from './camera.js';
import { element } from './common.js';
import { invalidate } from './drawing.js';
import { openFile } from './files.js';
import { copyLink } from './link.js';
import { showError } from './messages.js';
import { changed, panes, restore, set, sliderKey, sliderRange, slideTo, state, turnTo } from './page.js';
import { planeOf, shownAxes } from './pane.js';
import { drawMarks } from './panel.js';
import { isPlaying, play, setDirection, step } from './play.js';
import { save } from './saving.js';
import { measureSpeed } from './speed.js';
import { switchTheme } from './theme.js';

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

export function listen() {
  addEventListener('keydown', (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    // The keys of form controls are theirs.
    if (event.target.matches('input[type="number"], input[type="text"], select')) return;
    if (event.target.matches('button, input[type="checkbox"]') && event.key === ' ') return;
    if (event.target.matches('[data-normal]') && /^(Arrow|Page|Home|End)/.test(event.key)) return;
    if (panes.length === 0 || element('keys').open || !Object.hasOwn(keys, event.key)) return;
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
    setDirection(value - state[sliderKey()]);
    set({ [sliderKey()]: value });
  };
  element('value').onchange = () => {
    const input = element('value');
    if (Number.isFinite(input.valueAsNumber)) slideTo(input.valueAsNumber);
    // Also while it is focused.
    input.value = Number(state[sliderKey()].toPrecision(9));
  };
  element('speed').onchange = () => set({ speed: Number(element('speed').value) });
  element('loop').onchange = () => set({ loop: element('loop').checked });
  element('play').onclick = () => play(!isPlaying);
  element('fit').onclick = fitCamera;
  element('theme').onclick = switchTheme;
  element('help').onclick = () => element('keys').showModal();
  element('hide').onclick = togglePanel;
  element('save').onclick = save;
  element('link').onclick = copyLink;
  element('measureSpeed').onclick = () => measureSpeed().catch(showError);
  element('compare').onclick = () => element('other').click();
  const opens = (id, options) => {
    element(id).onchange = () => {
      const [file] = element(id).files;
      // So that the same file can be chosen again.
      element(id).value = '';
      if (file) openFile(file, options);
    };
  };
  opens('other', { beside: true });
  for (const id of ['choose', 'open']) element(id).onclick = () => element('chooser').click();
  opens('chooser');
  addEventListener('dragover', (event) => event.preventDefault());
  addEventListener('drop', (event) => {
    event.preventDefault();
    const file = event.dataTransfer.files[0] ?? event.dataTransfer.getData('URL');
    if (file) openFile(file, { beside: event.shiftKey });
  });
  addEventListener('hashchange', () => {
    restore();
    restoreCamera();
    changed();
  });
  new ResizeObserver(() => {
    element('marks').dataset.key = '';
    drawMarks();
    invalidate();
  }).observe(element('stage'));
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => changed());
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
  for (const type of ['pointerup', 'pointercancel']) {
    canvas.addEventListener(type, () => { turning = null; }, { capture: true });
  }
}
