#!/usr/bin/env node
// A reader under test: the appendix of t4d/formats/t4d/SPEC.md.
//
//     conform.mjs FILE describe     reads everything and checks every rule
//     conform.mjs FILE slice T      or x C, y C, z C, or A,B,C,D E: reads what the slice needs
//     conform.mjs --serve           answers such requests from standard input, one a line
//
// Exits with 0, or with 1 if it refuses the file, 2 for wrong usage, 70 for a mistake of its own: Node's
// own 1 would look like a refusal.
import { createInterface } from 'node:readline';

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
      const { numPoints, numTriangles, volume, area, min, max } = measure(section);
      return {
        name: section.name, points: String(numPoints), triangles: String(numTriangles), volume: real(volume),
        area: real(area), ...boundsText({ min, max }),
      };
    }),
  };
}

const units = { x: [1, 0, 0, 0], y: [0, 1, 0, 0], z: [0, 0, 1, 0] };

/** ['describe'] or ['slice', a hyperplane], or null. */
function requestOf([verb, ...rest]) {
  if (verb === 'describe' && rest.length === 0) return [verb];
  if (verb !== 'slice' || rest.length < 1 || rest.length > 2) return null;
  const numberOf = (word) => (word.trim() ? Number(word) : NaN);
  const normal = rest.length === 1 ? [0, 0, 0, 1] : units[rest[0]] ?? rest[0].split(',').map(numberOf);
  const offset = numberOf(rest.at(-1));
  const isKnown = normal.length === 4 && normal.some((value) => value !== 0) &&
    [...normal, offset].every(Number.isFinite);
  return isKnown ? [verb, hyperplane(normal, offset)] : null;
}

/** { answer }, { refusal } or { mistake }. */
async function respond(path, [verb, plane]) {
  let source;
  try {
    source = fileSource(path);
    return { answer: verb === 'slice' ? await slice(source, plane) : await describe(source) };
  } catch (error) {
    const isRefusal = error instanceof Invalid || error.syscall !== undefined;
    return isRefusal ? { refusal: `${path}: ${error.message}` } : { mistake: error };
  } finally {
    source?.close();
  }
}

/** Answers requests line by line, such as "describe FILE" and "slice T FILE". */
async function serve() {
  for await (const line of createInterface({ input: process.stdin, crlfDelay: Infinity })) {
    const form = /^(describe|slice (?:[xyz]|\S*,\S*) \S+|slice \S+) (.*)$/;
    const [, words = '', path] = form.exec(line) ?? [];
    const request = requestOf(words.split(' '));
    const { answer, refusal, mistake } =
      request ? await respond(path, request) : { mistake: `not a request: ${line}` };
    if (mistake) {
      console.error(mistake);
      return 70;
    }
    process.stdout.write(answer
      ? `accept ${JSON.stringify(answer)}\n` : `refuse ${refusal.replaceAll('\n', ' ')}\n`);
  }
  return 0;
}

async function main([path, ...words]) {
  if (path === '--serve' && words.length === 0) return serve();
  const request = requestOf(words);
  if (!request) {
    console.error('usage: conform.mjs FILE describe | FILE slice T | FILE slice x|y|z C | ' +
      'FILE slice A,B,C,D E | --serve');
    return 2;
  }
  const { answer, refusal, mistake } = await respond(path, request);
  if (!answer) {
    console.error(refusal ?? mistake);
    return refusal ? 1 : 70;
  }
  process.stdout.write(`${JSON.stringify(answer, null, 1)}\n`);
  return 0;
}

process.exitCode = await main(process.argv.slice(2));
