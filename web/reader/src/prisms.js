// The prisms of a sweep: the cells that a triangle sweeps between two layers.

/** Cells of a prism, one after another, in the division of the paper, which has means. */
const cellsOfPrism = 14;

/**
 * @typedef {object} Prisms the cells of a slab, in runs of as many
 * @property {number} cellsEach of a prism
 * @property {Uint32Array} corners six vertices of each prism: a triangle of the lower layer, facing outward, and
 *   the same of the upper layer; its cells have no other vertices but means of these
 */

/**
 * The prisms that a connectivity consists of; null where it has other cells.
 * @returns {Prisms|null}
 */
export function prismsOf({ cells, numVertices, numLower, numUpper, numMeans, firstSource, sources }) {
  const numPrisms = cells.length / 4 / cellsOfPrism;
  const firstUpper = numVertices - numUpper;
  const firstMean = firstUpper - numMeans;
  if (numMeans === 0 || numLower !== numUpper || firstMean !== numLower || !Number.isInteger(numPrisms)) return null;
  const corners = new Uint32Array(6 * numPrisms);
  for (let prism = 0; prism < numPrisms; ++prism) {
    const begin = 4 * cellsOfPrism * prism;
    const run = cells.subarray(begin, begin + 4 * cellsOfPrism);
    const triangle = bottomOf(run, numLower, firstUpper);
    if (!triangle) return null;
    const six = [...triangle, ...triangle.map((vertex) => firstUpper + vertex)];
    const areOfPrism = (vertices, begin, end) => {
      for (let i = begin; i < end; ++i) if (!six.includes(vertices[i])) return false;
      return true;
    };
    const isRight = (vertex) => {
      if (vertex < firstMean || vertex >= firstUpper) return six.includes(vertex);
      return areOfPrism(sources, firstSource[vertex - firstMean], firstSource[vertex - firstMean + 1]);
    };
    if (!run.every(isRight)) return null;
    corners.set(six, 6 * prism);
  }
  return { cellsEach: cellsOfPrism, corners };
}

/** The triangle of the lower layer under an apex, which is a mean, in the first such cell; null without one. */
function bottomOf(run, numLower, firstUpper) {
  for (let i = 0; i < run.length; i += 4) {
    const cell = run.subarray(i, i + 4);
    const apex = cell.findIndex((vertex) => vertex >= numLower);
    if (apex < 0 || cell[apex] >= firstUpper) continue;
    const [a, b, c] = cell.filter((_, corner) => corner !== apex);
    if (a >= numLower || b >= numLower || c >= numLower) continue;
    // As the cell is oriented with the apex last.
    return apex % 2 === 0 ? [a, c, b] : [a, b, c];
  }
  return null;
}
