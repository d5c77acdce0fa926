// Opens files.
import { element, model, viewer } from './page.js';
import { speeds, startClock } from './speed.js';
import { stateOf } from './state.js';
import { Tracks } from './tracks.js';

/** Shows errors in one box. */
function say(errors) {
  if (errors.length === 0) return;
  const isDamaged = errors.some(({ rule }) => rule !== undefined);
  viewer.messages.say(...errors.map(({ message }) => message),
    ...(isDamaged ? ['The file is damaged or is no .t4d file; `t4d recover` saves what is whole of a damaged one.'] : []));
}

/** Where no file could be opened, there is a way to open another. */
function offerToOpen() {
  element('welcome').hidden = model.panes.length > 0;
}

/**
 * Opens a file beside those that are there, or instead of them, and says what is wrong with it.
 * @param {string|Blob|Uint8Array} from its address, or the file
 * @param {{beside: boolean}} options
 */
export async function openFile(from, { beside = false } = {}) {
  viewer.messages.hide();
  element('welcome').hidden = true;
  // They were of the file that the page came with.
  if (!beside) model.tracks = null;
  startClock();
  const [first] = model.panes;
  // The link says what to show of the first file.
  const asked = () => (first ? {} : stateOf(location.hash));
  await viewer.add({ from }, beside, asked).catch((error) => say([error]));
  if (model.panes[0] !== first) speeds.firstPicture = null;
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
  element('welcome').hidden = files.length > 0;
  const tracks = asked.length === 0 && element('t4d-tracks');
  if (tracks) model.tracks = new Tracks(JSON.parse(tracks.textContent));
  startClock();
  const sources = files.map(({ url, base64, name }) => ({
    // The worker refuses what is not an address.
    from: base64 ? bytesOf(base64) : URL.canParse(url, location.href) ? new URL(url, location.href).href : url,
    name, isOwn: true,
  }));
  say(await viewer.open(sources, () => stateOf(location.hash)));
  offerToOpen();
}
