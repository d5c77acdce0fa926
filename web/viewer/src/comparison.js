// Two solids coloured by their distance from each other.
import { showError } from './messages.js';
import { client, panes, state } from './page.js';
import { planeOf } from './pane.js';

/** The distances of the two solids at a time that are shown, or asked for. */
export const comparison = { asked: null, shown: null, largest: 0 };

export const showsDistances = () => state.color === 'distance' && state.cut === 't' && panes.length === 2;

/**
 * Colours two solids by their distance from each other; whether that is there. The one before stays meanwhile, and
 * onDone is called when it has come.
 */
export function updateDistances(hidden, onDone) {
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
    const look = { mode: 'distance', rangeOfBody: () => [0, comparison.largest] };
    panes.forEach((pane, i) => pane.showSections(sections[i], plane, state.timeScale, hidden, look));
    comparison.shown = key;
  }).catch((error) => {
    showError(error);
    comparison.shown = key;
  }).finally(() => {
    comparison.asked = null;
    onDone();
  });
  return false;
}
