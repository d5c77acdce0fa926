// Saves the slice.
import { shown } from './common.js';
import { element, model, viewer } from './page.js';

function download(bytes, name, type) {
  const url = URL.createObjectURL(new Blob([bytes], { type }));
  Object.assign(document.createElement('a'), { href: url, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(url), 60_000);
}

export async function save() {
  if (element('save').disabled) return;
  try {
    const { state, sliderKey: key } = model;
    const empty = [];
    for (const pane of model.panes) {
      const glb = await viewer.glbOf(pane);
      const name = pane.info.name.replace(/\.t4d$/, '');
      const value = shown(state[key]).replaceAll(',', '');
      if (glb) download(glb, `${name}-${key === 't' ? 'at-' : key}${value}.glb`, 'model/gltf-binary');
      else empty.push(pane.info.name);
    }
    if (empty.length > 0) viewer.messages.say(`Nothing to save of ${empty.join(' and ')}: the slice is empty.`);
  } catch (error) {
    viewer.showError(error);
  }
}
