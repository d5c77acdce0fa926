// Keys, buttons, files that are dropped, and the pointer.
import { openFile } from './files.js';
import { copyLink } from './link.js';
import { element, model, viewer } from './page.js';
import { save } from './saving.js';
import { measureSpeed } from './speed.js';
import { stateOf } from './state.js';
import { switchTheme } from './theme.js';

const { player } = viewer;
const set = (changes) => model.set(changes);

const keys = {
  ' ': () => player.play(!player.isPlaying),
  ArrowLeft: (event) => player.step(-1, event.shiftKey), ArrowRight: (event) => player.step(1, event.shiftKey),
  Home: () => model.slideTo(-Infinity), End: () => model.slideTo(Infinity),
  t: () => set({ cut: 't' }), x: () => set({ cut: 'x' }), y: () => set({ cut: 'y' }), z: () => set({ cut: 'z' }),
  h: () => set({ cut: 'any' }), m: () => set({ cut: 'solid' }),
  w: () => set({ wire: !model.state.wire }), o: () => set({ onion: { 0: 1, 1: 2, 2: 4, 4: 0 }[model.state.onion] ?? 0 }),
  f: () => viewer.fitCamera(), d: switchTheme, s: save,
  p: () => togglePanel(), '?': () => element('keys').showModal(),
};

function togglePanel() {
  element('panel').toggleAttribute('data-hidden');
}

export function listen() {
  addEventListener('keydown', (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    // The keys of form controls are theirs, also of those in the view.
    const [target] = event.composedPath();
    if (target.matches('input[type="number"], input[type="text"], select')) return;
    if (target.matches('button, input[type="checkbox"]') && event.key === ' ') return;
    if (target.matches('[data-normal]') && /^(Arrow|Page|Home|End)/.test(event.key)) return;
    if (model.panes.length === 0 || element('keys').open || !Object.hasOwn(keys, event.key)) return;
    event.preventDefault();
    keys[event.key](event);
  });
  const number = (id, key, isRight = Number.isFinite) => {
    element(id).onchange = () => {
      const value = element(id).valueAsNumber;
      if (isRight(value)) set({ [key]: value });
      element(id).value = model.state[key];
    };
  };
  for (const button of document.querySelectorAll('[data-cut]')) button.onclick = () => set({ cut: button.dataset.cut });
  element('drop').onchange = () => set({ drop: element('drop').value });
  number('timeScale', 'timeScale', (value) => value > 0);
  number('onionStep', 'onionStep', (value) => value > 0);
  element('color').onchange = () => set({ color: element('color').value });
  element('wire').onchange = () => set({ wire: element('wire').checked });
  element('onion').onchange = () => set({ onion: Number(element('onion').value) });
  element('fit').onclick = () => viewer.fitCamera();
  element('theme').onclick = switchTheme;
  element('help').onclick = () => element('keys').showModal();
  element('hide').onclick = togglePanel;
  element('save').onclick = save;
  element('link').onclick = copyLink;
  element('measureSpeed').onclick = () => measureSpeed().catch((error) => viewer.showError(error));
  element('compare').onclick = () => element('other').click();
  const opens = (id, options) => {
    element(id).onchange = () => {
      const [file] = element(id).files;
      // The same file can then be chosen again.
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
  addEventListener('hashchange', () => viewer.restore(stateOf(location.hash)));
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => model.changed());
}
