// Speeds of cells, by Reynolds' transport theorem: the speed along the normal, summed over the surface of a slice, is
// how fast its volume changes.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import path from 'node:path';
import { test } from 'node:test';
import { fileURLToPath } from 'node:url';

import { measure, open } from 't4d-reader';

import { rangeOfSpeeds, speedOfCell } from '../src/cell_speed.js';

const root = path.resolve(path.dirname(fileURLToPath(import.meta.url)), '../../..');
const fileOf = (name) =>
  open(new Uint8Array(readFileSync(path.join(root, `conformance/corpus/files/valid/${name}.t4d`))));

/** The area of a triangle of a section. */
function areaOf({ points, triangles }, triangle) {
  const [a, b, c] = [0, 1, 2].map((k) => points.subarray(3 * triangles[3 * triangle + k], 3 * triangles[3 * triangle + k] + 3));
  const [u, v] = [b, c].map((corner) => [0, 1, 2].map((i) => corner[i] - a[i]));
  return Math.hypot(u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]) / 2;
}

for (const name of ['cube-that-grows', 'cube-in-translation', 'ring', 'cross-polytope', 'one-simplex', 'screw-with-means', 'cubes-that-merge']) {
  test(`${name}: speed times area is the change of volume`, async () => {
    const file = await fileOf(name);
    const [{ begin, end }] = file.bodies;
    for (const share of [0.21, 0.47, 0.83]) {
      const time = begin + share * (end - begin);
      const [slab] = await file.slabsAt(time);
      const [section] = await file.slice(time);
      const flow = section.triangleCells.reduce((sum, cell, triangle) =>
        sum + speedOfCell(slab.vertices, slab.cells.subarray(4 * cell, 4 * cell + 4)) * areaOf(section, triangle), 0);
      // Between layers the volume is a cubic, for which this quotient is exact but for its third derivative.
      const volumeAt = async (t) => measure((await file.slice(t))[0]).volume;
      const h = 1e-5 * (end - begin);
      const change = (await volumeAt(time + h) - await volumeAt(time - h)) / (2 * h);
      assert.ok(Math.abs(flow - change) < 1e-6 * Math.max(1, Math.abs(change)), `${name} at ${time}: ${flow}, expected ${change}`);
    }
  });
}

test('what grows has speeds above 0, and caps have none', async () => {
  const file = await fileOf('cube-that-grows');
  const [slab] = await file.slabsAt(0.3);
  const [low, high] = rangeOfSpeeds(slab.vertices, slab.cells);
  assert.ok(low >= 0 && high > 0.5, [low, high]);
  assert.equal(rangeOfSpeeds(new Float64Array(16).map((_, i) => [0, 0, 0, 1, 1, 0, 0, 1, 0, 1, 0, 1, 0, 0, 1, 1][i]),
    new Uint32Array([0, 1, 2, 3])), null);
});
