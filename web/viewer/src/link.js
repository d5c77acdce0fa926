// The link that shows the same again.
import { element, model, viewer } from './page.js';
import { hashOf } from './state.js';

/**
 * A link names files by their addresses. The files that the page comes with need no names.
 * @param {{name: string, address: string|null, isOwn: boolean}[]} files that are shown; those of the user's machine
 *   have no address
 * @param {string} search of the address that the page was opened by
 * @param {string} page the address of the page
 * @returns {{search: string, missing: string[]}} the part of the link, and the names of files that it does not open
 */
function filesOfLink(files, search, page) {
  if (files.every(({ isOwn }) => isOwn)) return { search, missing: [] };
  if (files.every(({ address }) => address)) {
    const params = files.map(({ address }) => `file=${encodeURIComponent(shortened(address, page))}`);
    return { search: `?${params.join('&')}`, missing: [] };
  }
  // A comparison needs its first file.
  const isOpened = ({ isOwn }) => isOwn && files[0].isOwn;
  return {
    search: files[0].isOwn ? search : '', missing: files.filter((file) => !isOpened(file)).map(({ name }) => name),
  };
}

/** The address relative to the page where it is beside it. */
function shortened(address, page) {
  const folder = new URL('.', page).href;
  const rest = address.slice(folder.length);
  return address.startsWith(folder) && /^[\w%.-][\w%./-]*$/.test(rest) ? rest : address;
}

const startSearch = location.search;

/** The address that shows the same again, and the names of the files that it does not open. */
function linkNow() {
  const files = model.panes.map(({ info: { name }, source: { from, isOwn = false } }) =>
    ({ name, address: typeof from === 'string' ? from : null, isOwn }));
  const { search, missing } = filesOfLink(files, startSearch, location.href);
  const hash = hashOf(model.state, model.base);
  return { href: `${location.href.split(/[?#]/)[0]}${search}${hash && `#${hash}`}`, missing };
}

/** A call that waits until it was not asked for in so many milliseconds. */
export function later(milliseconds, call) {
  let timer = 0;
  return () => {
    clearTimeout(timer);
    timer = setTimeout(call, milliseconds);
  };
}

/** Keeps the address of the page up to date. */
export const linkLater = later(250, () => {
  // While files are on their way, the address says what to show of them.
  if (model.panes.length === 0 || !model.areAllOpen) return;
  const { href } = linkNow();
  if (href !== location.href) history.replaceState(null, '', href);
});

/** Copies the link, and says what it does not open. */
export async function copyLink() {
  const { href, missing } = linkNow();
  const lines = missing.length === 0 ? []
    : [`The link does not open ${missing.join(' and ')}: it can only name files on a web server. Whoever follows it has to open the rest by hand.`];
  try {
    await navigator.clipboard.writeText(href);
  } catch {
    viewer.messages.say('The browser does not let this page copy. This is the link:', href, ...lines);
    return;
  }
  if (lines.length > 0) viewer.messages.say(...lines);
  element('link').textContent = 'Copied';
  setTimeout(() => { element('link').textContent = 'Copy link'; }, 1500);
}
