// Prisms of swept slabs, and cuts that look at them before their cells.
import assert from 'node:assert/strict';
import { readFileSync, readdirSync } from 'node:fs';
import path from 'node:path';
import { test } from 'node:test';
import { fileURLToPath } from 'node:url';

import { cut, heightsOf, hyperplane, open } from '../src/index.js';

const here = path.dirname(fileURLToPath(import.meta.url));
const folder = path.resolve(here, '../../../conformance/corpus/files/valid');
const fileOf = (name) => open(new Uint8Array(readFileSync(path.join(folder, name))));
const all = readdirSync(folder).filter((name) => name.endsWith('.t4d'));

/** The slabs of each body of a file. */
async function bodiesOf(name) {
  const file = await fileOf(name);
  return Promise.all(file.bodies.map(({ slabs }) => Promise.all(file.slabsOf(slabs))));
}

const swept = await Promise.all(all.map(async (name) => ({ name, bodies: await bodiesOf(name) })))
  .then((files) => files.filter(({ bodies }) => bodies.flat().some(({ prisms }) => prisms)));

function sectionOf(slabs, plane, change = (slab) => slab) {
  const cutter = cut(plane, plane.isTime && plane.offset === slabs.at(-1).end);
  for (const slab of slabs) cutter.add(change(slab));
  return cutter.finish();
}

const withoutPrisms = (slab) => ({ ...slab, prisms: null, blockBounds: [] });

/** A seeded generator. */
function generator() {
  let state = 1;
  return () => {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    return state / 2 ** 32;
  };
}

/** Hyperplanes through vertices of layers and through means, and close to them. */
function* planesThrough(slabs, random) {
  const normals = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1], [1, 2, -1, 0.5], [-1e-9, 1, 1e9, 3]];
  for (let i = 0; i < 3; ++i) normals.push([0, 1, 2, 3].map(() => random() - 0.5));
  for (const normal of normals) {
    const slab = slabs[Math.floor(random() * slabs.length)];
    const heights = heightsOf(slab.vertices, hyperplane(normal, 0));
    for (let i = 0; i < 4; ++i) {
      const height = heights[Math.floor(random() * heights.length)];
      for (const scale of [1, 1 + Number.EPSILON, 1 + 1e-3]) yield hyperplane(normal, height * scale);
    }
  }
}

test('the cut by prisms is that of all cells, in the same order', () => {
  assert.ok(swept.length > 5);
  const random = generator();
  let numTriangles = 0;
  for (const { name, bodies } of swept) {
    for (const slabs of bodies) {
      for (const plane of planesThrough(slabs, random)) {
        const section = sectionOf(slabs, plane);
        assert.deepEqual(section, sectionOf(slabs, plane, withoutPrisms), `${name}: ${plane.normal} ${plane.offset}`);
        numTriangles += section.triangles.length / 3;
      }
    }
  }
  assert.ok(numTriangles > 10_000, numTriangles);
});

test('the cut far from the origin is that of all cells, where means are rounded', () => {
  const random = generator();
  for (const { name, bodies } of swept) {
    for (const slabs of bodies) {
      const moved = slabs.map((slab) => ({
        ...slab, vertices: slab.vertices.map((value, i) => (i % 4 < 3 ? value / 3 + 1e15 : value)),
        min: slab.min.map((value) => value + 1e15), max: slab.max.map((value) => value + 1e15),
      }));
      for (const plane of planesThrough(moved, random)) {
        assert.deepEqual(sectionOf(moved, plane), sectionOf(moved, plane, withoutPrisms), `${name}: ${plane.normal}`);
      }
    }
  }
});

test('prisms are 14 cells of six corners each, which lie in layers over each other', () => {
  for (const { name, bodies } of swept) {
    for (const { prisms, cells, numLower, numVertices, numUpper, begin, end, vertices } of bodies.flat()) {
      if (!prisms) continue;
      assert.equal(14 * 4 * prisms.length / 6, cells.length, name);
      for (let i = 0; i < prisms.length; i += 6) {
        const [a, b, c, ...upper] = prisms.subarray(i, i + 6);
        assert.ok([a, b, c].every((corner) => corner < numLower && vertices[4 * corner + 3] === begin));
        assert.deepEqual(upper, [a, b, c].map((corner) => corner + numVertices - numUpper));
        assert.ok(upper.every((corner) => vertices[4 * corner + 3] === end));
      }
    }
  }
});

test('other cells with means are no prisms', async () => {
  for (const name of ['float32-with-means.t4d', 'attributes-of-means.t4d', 'means-of-all-sources.t4d']) {
    for (const { prisms } of (await bodiesOf(name)).flat()) assert.equal(prisms, null, name);
  }
});

test('blocks of cells that a hyperplane misses are left out, and nothing else', () => {
  const corners = [0, 0, 0, 0, 1, 0, 0, 1, 0, 1, 0, 1, 0, 0, 1, 1];
  const vertices = Float64Array.from([...corners, ...corners.map((value, i) => (i % 4 === 0 ? value + 10 : value))]);
  const cells = Uint32Array.from({ length: 4 * 65537 }, (_, i) => i % 4 + (i < 4 * 65536 ? 0 : 4));
  const blockBounds = Float64Array.from([0, 0, 0, 0, 1, 1, 1, 1, 10, 0, 0, 0, 11, 1, 1, 1]);
  const slab = {
    begin: 0, end: 1, vertices, cells, numVertices: 8, numLower: 0, numUpper: 0, prisms: null, blockBounds,
  };
  const countAt = (x, change) => sectionOf([slab], hyperplane([1, 0, 0, 0], x), change).triangles.length / 3;
  assert.deepEqual([0.5, 5, 10.5].map((x) => countAt(x)), [65536, 0, 1]);
  // A block is judged by its bounds alone.
  const wrongBounds = blockBounds.map((value, i) => (i < 8 ? value + 20 : value));
  const withWrongBounds = (each) => ({ ...each, blockBounds: wrongBounds });
  assert.equal(countAt(0.5, withWrongBounds), 0);
});
