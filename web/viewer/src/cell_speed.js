// How fast the surface of the solid moves along its own normal: of a cell with the outward normal (n, n_t), n in space,
// -n_t / |n|, positive where the solid grows. Cells of caps, whose normal is that of time, have an infinite speed.

/** vec4 positions to the speed. For cells of the file, det[normal, b - a, c - a, d - a] > 0. */
export const cellSpeed = `
float speedOfCell(vec4 a, vec4 b, vec4 c, vec4 d) {
  vec4 u = b - a;
  vec4 v = c - a;
  vec4 w = d - a;
  vec3 n = u.w * cross(v.xyz, w.xyz) + v.w * cross(w.xyz, u.xyz) + w.w * cross(u.xyz, v.xyz);
  return dot(u.xyz, cross(v.xyz, w.xyz)) / length(n);
}
`;

/** The same in double precision, for the cell of these numbers of vertices. */
export function speedOfCell(vertices, cell) {
  const [a, b, c, d] = Array.from(cell, (vertex) => vertices.subarray(4 * vertex, 4 * vertex + 4));
  const [u, v, w] = [b, c, d].map((corner) => [0, 1, 2, 3].map((i) => corner[i] - a[i]));
  const cross = (p, q) => [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]];
  const [vw, wu, uv] = [cross(v, w), cross(w, u), cross(u, v)];
  const length = Math.hypot(...[0, 1, 2].map((i) => u[3] * vw[i] + v[3] * wu[i] + w[3] * uv[i]));
  return (u[0] * vw[0] + u[1] * vw[1] + u[2] * vw[2]) / length;
}

/** The number of cells, evenly spread, whose speeds stand for those of all. */
const mostSamples = 20_000;

/** Where two frames of voxels differ much, a few cells are nearly level in time: so large a part at each end is left out. */
const outliers = 0.01;

/**
 * The speeds between which nearly all cells of a slab are; null if none is finite.
 * @param {Float64Array} vertices x, y, z, t of each
 * @param {Uint32Array} cells four vertices each
 * @returns {[number, number]|null}
 */
export function rangeOfSpeeds(vertices, cells) {
  const numCells = cells.length / 4;
  const step = Math.max(1, Math.ceil(numCells / mostSamples));
  const speeds = [];
  for (let cell = 0; cell < numCells; cell += step) {
    const speed = speedOfCell(vertices, cells.subarray(4 * cell, 4 * cell + 4));
    if (Number.isFinite(speed)) speeds.push(speed);
  }
  if (speeds.length === 0) return null;
  speeds.sort((a, b) => a - b);
  const skipped = Math.floor(outliers * speeds.length);
  return [speeds[skipped], speeds.at(-1 - skipped)];
}
