// Saves the slice.
import { element, shown } from './common.js';
import { glbOf } from './glb.js';
import { say, showError } from './messages.js';
import { panes, sliceOf, sliderKey, state } from './page.js';
import { planeOf } from './pane.js';

function download(bytes, name, type) {
  const url = URL.createObjectURL(new Blob([bytes], { type }));
  Object.assign(document.createElement('a'), { href: url, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(url), 60_000);
}

/** The slice of a file as .glb, with its exact points; null of an empty slice. */
export async function sliceAsGlb({ info, bodyColors } = panes[0]) {
  const plane = planeOf(state);
  const { sections } = await sliceOf(info, plane, true);
  const meshes = sections.map((section, i) => ({ ...section, color: bodyColors[i].toArray() }))
    .filter(({ name }) => !state.hidden.includes(name));
  return glbOf(meshes, { isZUp: plane.isTime && info.head.up === 'z' });
}

export async function save() {
  if (element('save').disabled) return;
  try {
    const key = sliderKey();
    const empty = [];
    for (const pane of panes) {
      const glb = await sliceAsGlb(pane);
      const name = pane.info.name.replace(/\.t4d$/, '');
      const value = shown(state[key]).replaceAll(',', '');
      if (glb) download(glb, `${name}-${key === 't' ? 'at-' : key}${value}.glb`, 'model/gltf-binary');
      else empty.push(pane.info.name);
    }
    if (empty.length > 0) say(`Nothing to save of ${empty.join(' and ')}: the slice is empty.`);
  } catch (error) {
    showError(error);
  }
}
