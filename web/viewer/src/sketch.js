// Sketches of sections across time, which are there long before the sections themselves.
//
// A layer of a swept solid is a triangle mesh. A sketch has the curves in which the hyperplane cuts some of the
// layers, each as a ribbon that reaches halfway to the next ones:
//
//        t ^        ____          every ribbon has the shape of the section at the time of its layer,
//          |    ___|____|         and is as wide as the time between layers
//          |   |____|
//          +-----------> x, y, z

/** A first sketch has as many layers, about. */
const fewLayers = 32;

/** Adds the ribbons of a layer, from time `begin` to `end`, four points for each: where its prisms have a triangle. */
function addRibbons(ribbons, { positions, time }, prisms, { normal, offset }, [begin, end]) {
  const [nx, ny, nz, nt] = normal;
  const heights = new Float64Array(positions.length / 3);
  for (let i = 0, k = 0; i < heights.length; ++i, k += 3) {
    heights[i] = nx * positions[k] + ny * positions[k + 1] + nz * positions[k + 2] + nt * time - offset;
  }
  // Points move along with time, so that they stay in the hyperplane.
  const pace = -nt / (nx * nx + ny * ny + nz * nz);
  const addEdge = (from, to) => {
    const share = heights[from] / (heights[from] - heights[to]);
    const along = (axis) => {
      const value = positions[3 * from + axis];
      return value + share * (positions[3 * to + axis] - value);
    };
    const x = along(0);
    const y = along(1);
    const z = along(2);
    for (const t of [begin, end]) {
      const moved = (t - time) * pace;
      ribbons.push(x + moved * nx, y + moved * ny, z + moved * nz, t);
    }
  };
  for (let i = 0; i < prisms.length; i += 6) {
    const a = prisms[i];
    const b = prisms[i + 1];
    const c = prisms[i + 2];
    const [isA, isB, isC] = [heights[a] > 0, heights[b] > 0, heights[c] > 0];
    if (isA === isB && isB === isC) continue;
    // The edges begin at the corner that is alone on its side.
    const [alone, one, other] = isA === isB ? [c, a, b] : isA === isC ? [b, c, a] : [a, b, c];
    addEdge(alone, one);
    addEdge(alone, other);
  }
}

/** Two triangles for the four points of every ribbon. */
function meshOf(ribbons) {
  const triangles = new Uint32Array(6 * ribbons.length / 16);
  for (let i = 0, point = 0; i < triangles.length; i += 6, point += 4) {
    triangles.set([point, point + 1, point + 2, point + 2, point + 1, point + 3], i);
  }
  return { points4: Float64Array.from(ribbons), triangles, isSketch: true };
}

/** The sketch of a body, of every so many of its layers, without its caps. */
async function sketchOf(file, records, plane, stride) {
  const ribbons = [];
  const steps = records.filter(isStep);
  file.parsed(steps.filter((_, i) => i % stride === 0).map(({ lower }) => lower)); // in few requests
  let begin = steps[0].begin;
  for (let i = 0; i < steps.length; i += stride) {
    const { lower, connectivity } = steps[i];
    const end = i + stride < steps.length ? (steps[i].begin + steps[i + stride].begin) / 2 : steps.at(-1).end;
    const { prisms } = await file.part(connectivity);
    if (prisms) addRibbons(ribbons, await file.part(lower), prisms, plane, [begin, end]);
    begin = end;
  }
  return meshOf(ribbons);
}

/** Whether a slab is not a cap. */
const isStep = ({ begin, end }) => begin < end;

/** Whether a body was swept: by one of its slabs. */
async function wasSwept(file, records) {
  const step = records.find(isStep);
  return Boolean(step && (await file.part(step.connectivity)).prisms);
}

/**
 * Sketches of a section across time, each finer than the one before; none of a file that was not swept.
 * @param {import('t4d-reader').T4dFile} file
 * @param {import('t4d-reader').SlabRecord[][]} records of each body, that the hyperplane may cut
 * @param {import('t4d-reader').Hyperplane} plane
 * @param {number} budget triangles of the finest sketch, about
 * @yields {({points4: Float64Array, triangles: Uint32Array, isSketch: true}|null)[]} one for each body, null where
 *   there is none
 */
export async function* sketchesOf(file, records, plane, budget) {
  if (plane.isTime) return;
  const can = await Promise.all(records.map((each) => wasSwept(file, each)));
  if (!can.includes(true)) return;
  const numLayers = Math.max(...records.map(({ length }, i) => (can[i] ? length : 0)));
  let stride = Math.ceil(numLayers / fewLayers);
  for (;;) {
    const sections = [];
    for (const [i, each] of records.entries()) {
      sections.push(can[i] ? await sketchOf(file, each, plane, stride) : null);
    }
    const numTriangles = sections.reduce((sum, section) => sum + (section?.triangles.length ?? 0) / 3, 0);
    yield sections;
    // Every layer has about as many triangles.
    const finer = Math.max(1, Math.ceil(stride * numTriangles / budget));
    if (finer >= stride) return;
    stride = finer;
  }
}
