#!/usr/bin/env node
// A reader under test: the appendix of formats/t4d/SPEC.md.
//
//     conform.mjs FILE describe     reads everything and checks every rule
//     conform.mjs FILE slice T      or x C, y C, z C, or A,B,C,D E: reads what the slice needs
//     conform.mjs --serve           answers such requests from standard input, one a line
import { run } from '../../conformance/readers/javascript/under_test.mjs';
import { crc32c, determinant4, hyperplane, Invalid, measure, open, readAll } from './src/index.js';
import { fileSource } from './src/node.js';
import { noBounds, widen } from './src/parts.js';

const real = (value) => (Number.isFinite(value) ? value.toExponential(16) : String(value));
const hex = (checksum) => checksum.toString(16).padStart(8, '0');
const boundsText = ({ min, max }) =>
  (min[0] <= max[0] ? { min: min.map(real), max: max.map(real) } : { min: null, max: null });
const bytesOf = (values) => new Uint8Array(values.buffer, values.byteOffset, values.byteLength);

function hypervolumeOf({ vertices, cells }) {
  let sum = 0;
  const corner = (i) => vertices.subarray(4 * cells[i], 4 * cells[i] + 4);
  for (let i = 0; i < cells.length; i += 4) {
    sum += determinant4(corner(i), corner(i + 1), corner(i + 2), corner(i + 3)) / 24;
  }
  return sum;
}

function describeSlab(slab) {
  const bounds = noBounds(4);
  widen(bounds, slab.vertices);
  return {
    begin: real(slab.begin), end: real(slab.end), vertices: String(slab.numVertices),
    lower: String(slab.numLower), upper: String(slab.numUpper), means: String(slab.numMeans),
    cells: String(slab.cells.length / 4), ...boundsText(bounds),
    attributes: slab.attributes.map(({ domain, name, type, components, values }) => ({
      domain, name, type: String(type), components: String(components), checksum: hex(crc32c(bytesOf(values))),
    })),
  };
}

async function describe(source) {
  const sums = [];
  const { version, head, bodies, done } = await readAll(source, (slab) => {
    const sum = (sums[slab.body] ??= { vertices: 0, cells: 0, hypervolume: 0, slabs: [] });
    sum.vertices = crc32c(bytesOf(slab.vertices), sum.vertices);
    sum.cells = crc32c(bytesOf(slab.cells), sum.cells);
    sum.hypervolume += hypervolumeOf(slab);
    sum.slabs.push(describeSlab(slab));
  });
  return {
    version: version.join('.'),
    features: head.features,
    bodies: bodies.map((body, i) => ({
      name: head.bodies[i].name, vertices: String(body.vertices), cells: String(done.bodies[i].numCells),
      begin: real(done.bodies[i].begin), end: real(done.bodies[i].end), ...boundsText(body),
      hypervolume: real(sums[i].hypervolume), vertices_checksum: hex(sums[i].vertices),
      cells_checksum: hex(sums[i].cells), slabs: sums[i].slabs,
    })),
  };
}

async function slice(source, plane) {
  const file = await open(source);
  return {
    bodies: (await file.slice(plane)).map((section) => {
      const { numPoints, numTriangles, volume, area, min, max } = measure(section, [0, 0, 0]);
      return {
        name: section.name, points: String(numPoints), triangles: String(numTriangles), volume: real(volume),
        area: real(area), ...boundsText({ min, max }),
      };
    }),
  };
}

process.exitCode = await run({
  open: fileSource,
  describe,
  slice: (source, normal, offset) => slice(source, hyperplane(normal, offset)),
  Invalid,
});
