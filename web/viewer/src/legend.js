// The ramp of colours over the picture, with the numbers at its ends.
import { shown } from './common.js';

/** The colours as the shaders have them. */
const colors = ['#440154', '#3b528b', '#21918c', '#5ec962', '#fde725'];

/** The unit of what is coloured, as far as the files agree on one. */
function unitOf(color, model) {
  const [length, time] = ['length_unit', 'time_unit'].map((kind) => model.unitOf(kind));
  if (color === 'speed') return length && time ? `${length}/${time}` : '';
  return { time, age: time, distance: length }[color] ?? '';
}

/**
 * @param {import('./viewer.js').Viewer} viewer
 * @param {[number, number]|null} range
 */
export function fillLegend({ model, find }, range) {
  find('legend').hidden = !range;
  if (!range) return;
  const { color } = model.state;
  const unit = unitOf(color, model);
  const title = color === 'speed' ? 'speed along the normal: ' : '';
  const digits = color === 'speed' ? 3 : 6;
  find('range').textContent = `${title}${range.map((value) => shown(value, digits)).join(' to ')}${unit && ` ${unit}`}`;
  find('ramp').style.background = `linear-gradient(to right, ${colors.join(', ')})`;
}
