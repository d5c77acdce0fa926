import { blockRows } from './parts.js';
import { cellsOfPrism } from './prisms.js';

/**
 * @typedef {object} Hyperplane all p with normal . p = offset
 * @property {number[]} normal
 * @property {number} offset
 * @property {number[][]} axes of its slices: three orthonormal vectors in the hyperplane
 * @property {boolean} isTime
 * @property {boolean} isReversed whether det[axes, normal] is negative
 *
 * @typedef {object} Section a closed triangle mesh that faces outward
 * @property {string} name of the body
 * @property {Float64Array} points three coordinates each, along the axes of the hyperplane
 * @property {Float64Array} points4 the same in space-time, four each
 * @property {Uint32Array} triangles three points each
 * @property {Uint32Array} triangleCells the cell of each, by number within its slab
 */

const units = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]];

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];

const determinant3 = (a, b, c) =>
  a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) +
  a[2] * (b[0] * c[1] - b[1] * c[0]);

/** det[a, b, c, d], by the t of each. */
export const determinant4 = (a, b, c, d) =>
  d[3] * determinant3(a, b, c) - c[3] * determinant3(a, b, d) +
  b[3] * determinant3(a, c, d) - a[3] * determinant3(b, c, d);

/** Bounds decide which slabs are read; so much of the largest term is left for the rounding of n.p. */
const boundsSlack = 8 * Number.EPSILON;

/**
 * The hyperplane of all p with normal . p = offset. For x = c the axes are (y, z, t), for y = c (x, z, t),
 * for z = c (x, y, t), for t = c (x, y, z); for others they are those of `t4d slice --hyperplane`.
 * @param {number[]} normal x, y, z, t; not all 0
 * @param {number} offset
 * @returns {Hyperplane}
 */
export function hyperplane(normal, offset) {
  const unit = (vector) => vector.map((value) => value / Math.hypot(...vector));
  // A normal along t, of either sign and any length, is a time.
  if (normal[3] !== 0 && normal.slice(0, 3).every((value) => value === 0)) {
    return withMayCut({ normal: units[3], offset: offset / normal[3], axes: units.slice(0, 3), isTime: true, isReversed: false });
  }
  const along = normal.map(Math.abs);
  const steepest = along.lastIndexOf(Math.max(...along));
  // Gram-Schmidt. The axes are the other three, in their order.
  const basis = [unit(normal)];
  for (const each of units.filter((_, i) => i !== steepest)) {
    let axis = each;
    for (const other of basis) {
      const shadow = dot(axis, other);
      axis = axis.map((value, i) => value - shadow * other[i]);
    }
    basis.push(unit(axis));
  }
  const axes = basis.slice(1);
  return withMayCut({ normal, offset, axes, isTime: false, isReversed: determinant4(...axes, normal) < 0 });
}

const withMayCut = (plane) => ({
  ...plane,
  /** Whether the hyperplane can meet a box. */
  mayCut(min, max) {
    let [low, high, size] = [0, 0, 0];
    plane.normal.forEach((n, i) => {
      if (n === 0) return;
      low += Math.min(n * min[i], n * max[i]);
      high += Math.max(n * min[i], n * max[i]);
      size = Math.max(size, Math.abs(n * min[i]), Math.abs(n * max[i]));
    });
    const slack = boundsSlack * size;
    return low - slack <= plane.offset && plane.offset <= high + slack;
  },
});

/** For X1: n.p - offset of each vertex; exact in its sign. */
export function heightsOf(vertices, { normal, offset }) {
  const [nx, ny, nz, nt] = normal;
  const heights = new Float64Array(vertices.length / 4);
  for (let i = 0, k = 0; i < heights.length; ++i, k += 4) {
    heights[i] = ((nx * vertices[k] + ny * vertices[k + 1]) + nz * vertices[k + 2]) + nt * vertices[k + 3] - offset;
  }
  return heights;
}

// A cell whose first vertices, as many as the key says, are above: the edges that are cut, so that
// they run counterclockwise seen from outside (X5), or clockwise where the hyperplane isReversed.
// The other cases are even permutations of these.
const cutEdges = { 1: ['01', '03', '02'], 2: ['12', '13', '03', '02'], 3: ['23', '13', '03'] };
const evenOrders = [
  '0123', '1032', '2301', '3210', '0231', '0312', '1203', '1320', '2013', '2130', '3021', '3102',
];

/**
 * For each set of corners above, as bits of a number: the edges that are cut, in the order of the polygon,
 * as pairs of corners.
 * @type {number[][][]}
 */
export const cutTable = Array.from({ length: 16 }, (_, mask) => {
  const isAbove = (i) => (mask >> i) & 1;
  const count = [0, 1, 2, 3].filter(isAbove).length;
  const order = evenOrders.find((each) => [...each].slice(0, count).every(isAbove));
  return (cutEdges[count] ?? []).map((edge) => [...edge].map((i) => Number(order[i])));
});
// cutTable as one flat array: for each mask the number of corners, then a and b of each.
const flatTable = new Uint8Array(16 * 9);
cutTable.forEach((edges, mask) => flatTable.set([edges.length, ...edges.flat()], 9 * mask));

/** The points of a slice on the edges of one slab, by the two ends: open addressing. */
class EdgePoints {
  constructor(expected) {
    this.count = 0;
    this.resize(2 ** Math.ceil(Math.log2(Math.max(64, 2 * expected))));
  }

  resize(size) {
    const { low, high, points } = this;
    this.mask = size - 1;
    this.low = new Uint32Array(size);
    this.high = new Uint32Array(size);
    this.points = new Int32Array(size).fill(-1);
    if (!points) return;
    this.count = 0;
    for (let i = 0; i < points.length; ++i) {
      if (points[i] >= 0) this.set(this.place(low[i], high[i]), low[i], high[i], points[i]);
    }
  }

  /** Where the edge from a to b is, or is to be, a < b. */
  place(a, b) {
    const { low, high, points, mask } = this;
    let i = (Math.imul(a, 0x9e3779b1) ^ Math.imul(b, 0x85ebca6b)) >>> 0;
    i = (i ^ (i >>> 15)) & mask;
    while (points[i] >= 0 && (low[i] !== a || high[i] !== b)) i = (i + 1) & mask;
    return i;
  }

  /** The point of an edge; -1 where there is none. */
  get(a, b) { return this.points[this.place(a, b)]; }

  /** The edge has the place() that there is for it. */
  set(place, a, b, point) {
    this.low[place] = a;
    this.high[place] = b;
    this.points[place] = point;
    if (++this.count * 2 > this.mask) this.resize(2 * (this.mask + 1));
  }
}

/** Numbers that are added one after another. */
class Growing {
  constructor(Type) {
    this.values = new Type(65536);
    this.length = 0;
  }

  push4(a, b, c, d) {
    this.reserve(4);
    const { values, length } = this;
    values[length] = a;
    values[length + 1] = b;
    values[length + 2] = c;
    values[length + 3] = d;
    this.length += 4;
  }

  push3(a, b, c) {
    this.reserve(3);
    const { values, length } = this;
    values[length] = a;
    values[length + 1] = b;
    values[length + 2] = c;
    this.length += 3;
  }

  push(a) {
    this.reserve(1);
    this.values[this.length++] = a;
  }

  reserve(more) {
    if (this.length + more <= this.values.length) return;
    const values = new this.values.constructor(2 * this.values.length);
    values.set(this.values);
    this.values = values;
  }

  take() { return this.values.slice(0, this.length); }
}

/**
 * The cells that may be cut, in their order.
 * @param {import('./parts.js').Slab} slab
 * @param {Float64Array} heights of its vertices, from heightsOf()
 * @param {Hyperplane} plane
 * @param {(begin: number, end: number) => void} use called with the ends of a part of `slab.cells`
 */
export function eachRunThatMayBeCut(slab, heights, plane, use) {
  const { cells, prisms, blockBounds: bounds = [] } = slab;
  if (prisms) {
    const clear = clearHeight(slab, plane);
    for (let i = 0, k = 0; i < cells.length; i += 4 * cellsOfPrism, k += 6) {
      if (!areOnOneSide(prisms, k, heights, clear)) use(i, i + 4 * cellsOfPrism);
    }
    return;
  }
  const cellsOfBlocks = 4 * blockRows;
  for (let i = 0, k = 0; i < cells.length; i += cellsOfBlocks, k += 8) {
    if (bounds.length > 0 && !plane.mayCut(bounds.subarray(k, k + 4), bounds.subarray(k + 4, k + 8))) continue;
    use(i, Math.min(cells.length, i + cellsOfBlocks));
  }
}

/** Whether the six corners of a prism, so also their means, are all above the hyperplane or all below. */
function areOnOneSide(corners, k, heights, clear) {
  const first = heights[corners[k]];
  if (first > clear) {
    return heights[corners[k + 1]] > clear && heights[corners[k + 2]] > clear && heights[corners[k + 3]] > clear
      && heights[corners[k + 4]] > clear && heights[corners[k + 5]] > clear;
  }
  return first < -clear && heights[corners[k + 1]] < -clear && heights[corners[k + 2]] < -clear
    && heights[corners[k + 3]] < -clear && heights[corners[k + 4]] < -clear && heights[corners[k + 5]] < -clear;
}

/** Means are rounded, and heights: by some 16 units in the last place of the largest term, in all. */
const meanSlack = 64 * Number.EPSILON;

/** Vertices that are higher above the hyperplane have only means above it. */
function clearHeight({ min, max }, { normal, offset }) {
  const terms = normal.map((n, axis) => Math.abs(n) * Math.max(Math.abs(min[axis]), Math.abs(max[axis])));
  return meanSlack * (Math.abs(offset) + terms.reduce((sum, term) => sum + term));
}

/**
 * Marching tetrahedra: add() the slabs of a body that the hyperplane cuts in the order of time, then finish().
 * @param {Hyperplane} plane
 * @param {boolean} [atLast] for a slice at the last time of the body: vertices there are above (X1)
 */
export function cut(plane, atLast = false) {
  const points = new Growing(Float64Array); // in space-time
  const triangles = new Growing(Uint32Array);
  const triangleCells = new Growing(Uint32Array);
  let before = null; // the slab before: its vertices and edges on the shared layer are those of the next

  function add(slab) {
    const { vertices, cells, numVertices, numLower, numUpper } = slab;
    const heights = heightsOf(vertices, plane);
    const isAbove = (vertex) => (heights[vertex] > 0 || (atLast && heights[vertex] === 0) ? 1 : 0);
    const pointOf = new Int32Array(numVertices).fill(-1); // of vertices on the hyperplane
    const edges = new EdgePoints(before?.edges.count ?? 0);
    const shared = before && slab.lower !== 0 && before.slab.end === slab.begin
      && before.slab.numUpper === numLower ? before : null;
    const firstShared = shared ? shared.slab.numVertices - numLower : 0;
    if (shared) for (let i = 0; i < numLower; ++i) pointOf[i] = shared.pointOf[firstShared + i];

    const place = (a, b) => {
      if (heights[a] === 0 || heights[b] === 0) {
        const on = heights[a] === 0 ? a : b;
        if (pointOf[on] < 0) {
          pointOf[on] = points.length / 4;
          const k = 4 * on;
          points.push4(vertices[k], vertices[k + 1], vertices[k + 2], vertices[k + 3]);
        }
        return pointOf[on];
      }
      if (a > b) [a, b] = [b, a];
      const edge = edges.place(a, b);
      if (edges.points[edge] >= 0) return edges.points[edge];
      let point = shared && b < numLower ? shared.edges.get(firstShared + a, firstShared + b) : -1;
      if (point < 0) {
        point = points.length / 4;
        const s = heights[a] / (heights[a] - heights[b]);
        const i = 4 * a;
        const k = 4 * b;
        points.push4(
          vertices[i] + s * (vertices[k] - vertices[i]), vertices[i + 1] + s * (vertices[k + 1] - vertices[i + 1]),
          vertices[i + 2] + s * (vertices[k + 2] - vertices[i + 2]),
          vertices[i + 3] + s * (vertices[k + 3] - vertices[i + 3]));
      }
      edges.set(edge, a, b, point);
      return point;
    };

    const cutCells = (begin, end) => {
      for (let i = begin; i < end; i += 4) {
        const mask = isAbove(cells[i]) | (isAbove(cells[i + 1]) << 1) | (isAbove(cells[i + 2]) << 2)
          | (isAbove(cells[i + 3]) << 3);
        if (mask === 0 || mask === 15) continue;
        const row = 9 * mask;
        const corners = flatTable[row];
        const at = (k) => place(cells[i + flatTable[row + 1 + 2 * k]], cells[i + flatTable[row + 2 + 2 * k]]);
        const first = at(0);
        let second = at(1);
        for (let k = 2; k < corners; ++k) {
          const third = at(k);
          if (first !== second && second !== third && third !== first) { // X4
            if (plane.isReversed) triangles.push3(first, third, second);
            else triangles.push3(first, second, third);
            triangleCells.push(i / 4);
          }
          second = third;
        }
      }
    };

    eachRunThatMayBeCut(slab, heights, plane, cutCells);
    before = { slab, pointOf, edges };
    // Only the upper layer is looked at again.
    if (numUpper === 0) before = null;
  }

  /** The slice, of the points that its triangles use. */
  function finish() {
    const used = new Int32Array(points.length / 4).fill(-1);
    const corners = triangles.take();
    const all = points.values;
    const places = new Float64Array(points.length);
    let count = 0;
    for (let i = 0; i < corners.length; ++i) {
      const point = corners[i];
      if (used[point] < 0) {
        used[point] = count;
        const from = 4 * point;
        const to = 4 * count;
        places[to] = all[from];
        places[to + 1] = all[from + 1];
        places[to + 2] = all[from + 2];
        places[to + 3] = all[from + 3];
        ++count;
      }
      corners[i] = used[point];
    }
    const four = places.subarray(0, 4 * count);
    const three = new Float64Array(3 * count);
    plane.axes.forEach(([x, y, z, t], axis) => {
      for (let i = 0, k = axis; i < four.length; i += 4, k += 3) {
        three[k] = x * four[i] + y * four[i + 1] + z * four[i + 2] + t * four[i + 3];
      }
    });
    return { points: three, points4: four, triangles: corners, triangleCells: triangleCells.take() };
  }

  return { add, finish };
}

/**
 * Counts, volume, area and bounds of a section. The volume is the sum of the tetrahedra from `apex` to
 * the triangles. That of a closed section is the same for every apex, and loses least to cancellation
 * with one of its own points; for an open section the format's specification has the origin.
 */
export function measure({ points, triangles }, apex = points.subarray(0, 3)) {
  let volume = 0;
  let area = 0;
  const [ox, oy, oz] = apex;
  for (let i = 0; i < triangles.length; i += 3) {
    const a = 3 * triangles[i];
    const b = 3 * triangles[i + 1];
    const c = 3 * triangles[i + 2];
    const ax = points[a] - ox;
    const ay = points[a + 1] - oy;
    const az = points[a + 2] - oz;
    const bx = points[b] - ox;
    const by = points[b + 1] - oy;
    const bz = points[b + 2] - oz;
    const cx = points[c] - ox;
    const cy = points[c + 1] - oy;
    const cz = points[c + 2] - oz;
    volume += (ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)) / 6;
    const ux = bx - ax;
    const uy = by - ay;
    const uz = bz - az;
    const vx = cx - ax;
    const vy = cy - ay;
    const vz = cz - az;
    const nx = uy * vz - uz * vy;
    const ny = uz * vx - ux * vz;
    const nz = ux * vy - uy * vx;
    area += Math.sqrt(nx * nx + ny * ny + nz * nz) / 2; // Math.hypot() takes ten times as long
  }
  const min = [Infinity, Infinity, Infinity];
  const max = [-Infinity, -Infinity, -Infinity];
  for (let i = 0; i < points.length; ++i) {
    const axis = i % 3;
    if (points[i] < min[axis]) min[axis] = points[i];
    if (points[i] > max[axis]) max[axis] = points[i];
  }
  return { numPoints: points.length / 3, numTriangles: triangles.length / 3, volume, area, min, max };
}
