// Sketches of sections across time.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdirSync, readFileSync, rmSync } from 'node:fs';
import path from 'node:path';
import { before, test } from 'node:test';
import { fileURLToPath } from 'node:url';

import { hyperplane, measure, open } from 't4d-reader';

import { sketchesOf } from '../src/sketch.js';

const root = path.resolve(path.dirname(fileURLToPath(import.meta.url)), '../../..');
const build = process.env.T4D_BUILD ?? path.join(root, 'build/release');
const folder = path.join(root, 'build/web-test/sketch');
const at = (name) => path.join(folder, name);
const run = (program, ...args) => execFileSync(path.join(build, program), args.map(String), { encoding: 'utf8' });

before(() => {
  rmSync(folder, { recursive: true, force: true });
  mkdirSync(folder, { recursive: true });
  run('t4d-fixtures', at('fx'));
  for (const motion of ['rest', 'skew-axis', 'screw-in']) {
    run('t4d', 'sweep', at('fx/torus.obj'), '--motion', at(`fx/${motion}.json`), '-o', at(`${motion}.t4d`));
  }
});

const fileOf = (name) => open(new Uint8Array(readFileSync(at(name))));

/** The sketches of the only body. */
async function sketches(file, plane, budget = Infinity) {
  const found = [];
  for await (const [sketch] of sketchesOf(file, file.recordsOf(plane), plane, budget)) found.push(sketch);
  return found;
}

const numTriangles = ({ triangles }) => triangles.length / 3;

/** A section with its points along the axes of the hyperplane, for measure(). */
const alongAxes = ({ points4, triangles }, { axes }) => {
  const points = Float64Array.from({ length: points4.length / 4 * 3 }, (_, i) =>
    axes[i % 3].reduce((sum, part, k) => sum + part * points4[4 * Math.floor(i / 3) + k], 0));
  return { points, triangles };
};

const isNear = (found, expected) =>
  assert.ok(Math.abs(found - expected) <= 1e-9 * Math.abs(expected), `${found}, expected ${expected}`);

test('at rest, the sketch is the section but for its caps', async () => {
  const file = await fileOf('rest.t4d');
  const plane = hyperplane([1, 0, 0, 0], 0.3);
  const [section] = await file.slice(plane);
  const { area, volume } = measure(section);
  const [{ begin, end }] = file.bodies;
  const [sketch] = await sketches(file, plane);
  isNear(measure(alongAxes(sketch, plane)).area, area - 2 * volume / (end - begin));
});

test('a sketch is in its hyperplane, and lasts as long as the motion', async () => {
  const file = await fileOf('skew-axis.t4d');
  const [{ begin, end }] = file.bodies;
  for (const [normal, offset] of [[[1, 0, 0, 0], 0.3], [[0, 0, 2, 0], 0.1], [[1, 0.2, 0, 0.1], 0.4]]) {
    for (const { points4 } of await sketches(file, hyperplane(normal, offset))) {
      const times = points4.filter((_, i) => i % 4 === 3);
      assert.deepEqual([Math.min(...times), Math.max(...times)], [begin, end]);
      for (let i = 0; i < points4.length; i += 4) {
        const height = normal.reduce((sum, n, axis) => sum + n * points4[i + axis], -offset);
        assert.ok(Math.abs(height) < 1e-11, height);
      }
    }
  }
});

test('sketches are finer one by one, as far as the budget allows', async () => {
  const file = await fileOf('screw-in.t4d');
  const plane = hyperplane([1, 0, 0, 0], 0.3);
  const unlimited = (await sketches(file, plane)).map(numTriangles);
  assert.ok(unlimited.length > 1, unlimited);
  const finest = unlimited.at(-1);
  for (const budget of [1, finest / 3, finest]) {
    const counts = (await sketches(file, plane, budget)).map(numTriangles);
    assert.ok(counts.every((count, i) => i === 0 || count > counts[i - 1]), counts);
    if (counts.length > 1) assert.ok(counts.at(-1) < 1.5 * budget, `${counts}, ${budget}`);
  }
});

test('a slice at a time has no sketch', async () => {
  assert.deepEqual(await sketches(await fileOf('skew-axis.t4d'), hyperplane([0, 0, 0, 1], 0.1)), []);
});

test('what was not swept has no sketch', async () => {
  const name = path.join(root, 'conformance/corpus/files/valid/ring.t4d');
  const file = await open(new Uint8Array(readFileSync(name)));
  assert.deepEqual(await sketches(file, hyperplane([1, 0, 0, 0], 0.1)), []);
});
