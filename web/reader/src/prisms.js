// The prisms of a sweep: what a triangle sweeps between two layers.

/** Cells of a prism, one after another, in the division that has means (mesh4d/prism.h). */
export const cellsOfPrism = 14;

/**
 * The prisms that a connectivity consists of.
 * @returns {Uint32Array|null} six corners of each prism: a triangle of the lower layer, and the same of the upper
 *   layer; its cells have no other vertices but means of these. Null where there are other cells.
 */
export function prismsOf({ cells, numVertices, numLower, numUpper, numMeans, firstSource, sources }) {
  const numPrisms = cells.length / 4 / cellsOfPrism;
  const firstUpper = numVertices - numUpper;
  const firstMean = firstUpper - numMeans;
  if (numMeans === 0 || numLower !== numUpper || firstMean !== numLower || !Number.isInteger(numPrisms)) return null;
  const prisms = new Uint32Array(6 * numPrisms);
  for (let prism = 0; prism < numPrisms; ++prism) {
    const run = cells.subarray(4 * cellsOfPrism * prism, 4 * cellsOfPrism * (prism + 1));
    const triangle = bottomOf(run, numLower);
    if (!triangle) return null;
    const corners = [...triangle, ...triangle.map((vertex) => firstUpper + vertex)];
    const isOfPrism = (vertex) => {
      if (vertex < firstMean || vertex >= firstUpper) return corners.includes(vertex);
      const mean = vertex - firstMean;
      for (let i = firstSource[mean]; i < firstSource[mean + 1]; ++i) if (!corners.includes(sources[i])) return false;
      return true;
    };
    if (!run.every(isOfPrism)) return null;
    prisms.set(corners, 6 * prism);
  }
  return prisms;
}

/** The three vertices of the lower layer that a cell has; null where none has as many. */
function bottomOf(run, numLower) {
  for (let i = 0; i < run.length; i += 4) {
    const corners = [...run.subarray(i, i + 4)].filter((vertex) => vertex < numLower);
    if (corners.length === 3) return corners;
  }
  return null;
}
