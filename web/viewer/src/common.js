/** Cells in as many rows have bounds of their own, so that what a hyperplane misses is not drawn. */
export const blockCells = 4096;

/** Textures have rows of as many texels. */
export const rowTexels = 4096;

export const units4 = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]];

/** A number with as many digits as people read. */
export function shown(value, digits = 6) {
  if (!Number.isFinite(value)) return String(value);
  if (Number.isInteger(value) && Math.abs(value) < 1e9) return value.toLocaleString('en');
  const text = value.toPrecision(digits);
  return text.includes('e') ? text : String(Number(text));
}

export function shownBytes(bytes) {
  const [unit, size] = bytes >= 1e9 ? ['GB', 1e9] : bytes >= 1e6 ? ['MB', 1e6] : ['kB', 1e3];
  return `${(bytes / size).toFixed(1)} ${unit}`;
}
