// Which files a link to the page names.

/**
 * A link names files by their addresses. The files that the page comes with need no names.
 * @param {{name: string, address: string|null, isOwn: boolean}[]} files that are shown; those of the user's machine
 *   have no address
 * @param {string} search of the address that the page was opened by
 * @param {string} page the address of the page
 * @returns {{search: string, missing: string[]}} the part of the link, and the names of files that it does not open
 */
export function filesOfLink(files, search, page) {
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
