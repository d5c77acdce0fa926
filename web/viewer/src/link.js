// The link that shows the same again.
import { element } from './common.js';
import { say } from './messages.js';
import { areAllOpen, base, panes, state } from './page.js';
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
  // Without its first file, a comparison is none.
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

let linkTimer = 0;
const startSearch = location.search;

/** The address that shows the same again, and the names of the files that it does not open. */
function linkNow() {
  const { search, missing } = filesOfLink(panes.map(({ link }) => link), startSearch, location.href);
  const hash = hashOf(state, base);
  return { href: `${location.href.split(/[?#]/)[0]}${search}${hash && `#${hash}`}`, missing };
}

/** Keeps the address of the page up to date. */
export function linkLater() {
  clearTimeout(linkTimer);
  linkTimer = setTimeout(() => {
    // While files are on their way, the address says what to show of them.
    if (panes.length === 0 || !areAllOpen) return;
    const { href } = linkNow();
    if (href !== location.href) history.replaceState(null, '', href);
  }, 250);
}

/** Copies the link, and says what it does not open. */
export async function copyLink() {
  const { href, missing } = linkNow();
  const lines = missing.length === 0 ? []
    : [`The link does not open ${missing.join(' and ')}: it can only name files on a web server. Whoever follows it has to open the rest by hand.`];
  try {
    await navigator.clipboard.writeText(href);
  } catch {
    say('The browser does not let this page copy. This is the link:', href, ...lines);
    return;
  }
  if (lines.length > 0) say(...lines);
  element('link').textContent = 'Copied';
  setTimeout(() => { element('link').textContent = 'Copy link'; }, 1500);
}
