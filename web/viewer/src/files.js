// Opens files.
import { fitCamera, placeCamera, restoreCamera, view } from './camera.js';
import { colorsOf } from './colors.js';
import { element, shown } from './common.js';
import { onArrival } from './drawing.js';
import { say, showError, wasSaid } from './messages.js';
import { begin, center, changed, client, measureBounds, panes, setAllOpen } from './page.js';
import { Pane } from './pane.js';
import { fillPanel } from './panel.js';
import { forgetFirstPicture, startClock } from './speed.js';
import { stateOf } from './state.js';

/**
 * Opens a file beside those that are there, or instead of them.
 * @param {string|Blob|Uint8Array} from its address, or the file
 * @param {{beside: boolean, name: string, isOwn: boolean}} options `isOwn` of a file that the page comes with
 * @returns {Promise<string[]>} what is wrong if it cannot be opened
 */
async function add(from, { beside = false, name, isOwn = false }) {
  startClock();
  element('welcome').hidden = true;
  element('busy').hidden = false;
  let info;
  try {
    info = await client.call('open', { from, name });
  } catch (error) {
    element('busy').hidden = true;
    const wrong = `${name ?? (from.name ?? from)}: ${error.message}`;
    return error.rule === undefined ? [wrong]
      : [wrong, 'The file is damaged or is no .t4d file; `t4d recover` saves what is whole of a damaged one.'];
  }
  const isReplacing = !beside && panes.length > 0;
  if (isReplacing) {
    for (const pane of panes.splice(0)) pane.dispose();
    forgetFirstPicture();
  }
  const isFirst = panes.length === 0;
  const bodyColors = colorsOf(info.bodies, panes.flatMap((each) => each.namedColors()));
  const pane = new Pane(view.renderer, client, info, bodyColors, center, onArrival, (error, body, slab) => {
    // Said once of what is shown.
    if (body && wasSaid()) return;
    showError(new Error(`${info.name}: ${error.message}`),
      body && `Of '${body.name}' the time from ${shown(slab.begin)} to ${shown(slab.end)} cannot be shown; the rest can.`);
  });
  pane.link = { name: info.name, address: typeof from === 'string' ? from : null, isOwn };
  panes.push(pane);
  measureBounds();
  if (isFirst) {
    begin(info, isReplacing);
    pane.center = center;
  }
  document.title = `${panes.map((each) => each.info.name).join(' and ')} - t4d viewer`;
  element('title').textContent = panes.map((each) => each.info.name).join(' and ');
  fillPanel();
  if (isFirst) restoreCamera();
  else fitCamera();
  changed();
  return [];
}

/** Where no file could be opened, there is a way to open another. */
function offerToOpen() {
  element('welcome').hidden = panes.length > 0;
}

/** Opens a file as add() does, and says what is wrong with it. */
export async function openFile(from, options = {}) {
  element('message').hidden = true;
  const wrong = await add(from, options);
  if (wrong.length > 0) say(...wrong);
  offerToOpen();
}

/** The files that the page comes with: [{ name, base64 }] or [{ url }]. */
function ownFiles() {
  const script = element('t4d-files');
  return script ? JSON.parse(script.textContent) : [];
}

const bytesOf = (base64) => Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));

/** Opens the files that the page was asked for, or comes with. */
export async function openFirst() {
  const asked = new URLSearchParams(location.search).getAll('file').map((url) => ({ url }));
  const files = asked.length > 0 ? asked : ownFiles();
  const { camera } = stateOf(location.hash);
  const wrong = [];
  for (const { url, base64, name } of files) {
    // The worker refuses what is not an address.
    const from = base64 ? bytesOf(base64) : URL.canParse(url, location.href) ? new URL(url, location.href).href : url;
    wrong.push(...await add(from, { beside: true, name, isOwn: true }));
  }
  // Each file was fitted into the picture.
  if (camera && panes.length > 1) placeCamera(camera);
  setAllOpen();
  changed();
  if (wrong.length > 0) say(...wrong);
  offerToOpen();
}
