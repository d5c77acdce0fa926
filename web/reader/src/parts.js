// CONN, LAYR, POSE and SLAB, and how a slab is put together from them.
import { arrayRecord, f32Type, f64Type, i32Type, u32Type, valuesOf } from './array.js';
import { Fields, isSame } from './chunk.js';
import { isName, textOf } from './head.js';
import { check } from './invalid.js';
import { prismsOf } from './prisms.js';

/**
 * @typedef {object} Attribute
 * @property {'vertex'|'cell'} domain
 * @property {string} name
 * @property {number} type scalar type of the specification
 * @property {number} components scalars in a row
 * @property {ArrayLike<number|bigint>} values a typed array, row after row
 *
 * @typedef {object} Slab
 * @property {number} body number of its body
 * @property {number} begin
 * @property {number} end
 * @property {Float64Array} vertices x, y, z, t of each: lower layer, interior, upper layer
 * @property {Uint32Array} cells four vertices each
 * @property {number} numVertices
 * @property {number} numLower the first vertices, those of the lower layer
 * @property {number} numUpper the last vertices, those of the upper layer
 * @property {number} numMeans vertices that are means of others, the last before the upper layer
 * @property {Uint32Array|null} prisms six corners of each prism, if its cells are those of prisms (prisms.js)
 * @property {Float64Array} blockBounds minimum and maximum of x, y, z, t of each block of 65,536 cells; empty for one
 *   block
 * @property {number[]} min x, y, z, t
 * @property {number[]} max x, y, z, t
 * @property {number} connectivity offset of its CONN; slabs of the same have the same `cells`
 * @property {Attribute[]} attributes
 */

export const noBounds = (size) => ({
  min: new Array(size).fill(Infinity), max: new Array(size).fill(-Infinity),
});

/**
 * Widens the bounds by vertices of x, y, z, t, by as many coordinates as they have.
 * @returns {boolean} whether these are finite
 */
export function widen({ min, max }, vertices) {
  let nothing = 0;
  for (let axis = 0; axis < min.length; ++axis) {
    let low = min[axis];
    let high = max[axis];
    for (let i = axis; i < vertices.length; i += 4) {
      const value = vertices[i];
      if (value < low) low = value;
      if (value > high) high = value;
      nothing += value - value; // NaN if it is not finite
    }
    min[axis] = low;
    max[axis] = high;
  }
  return nothing === 0;
}

/** Arrays have blocks of as many rows. */
export const blockRows = 65536;

function parseAttribute(fields, features) {
  const { at } = fields;
  const domain = fields.u8();
  check(domain === 1 || domain === 2, at, 'T1', `domain ${domain}`);
  fields.zeros(3, 'T2');
  const length = fields.u32();
  check(length >= 1 && length <= 255 && fields.place + length <= fields.bytes.length, at, 'T3',
    `a name of ${length} bytes`);
  const name = textOf(fields.take(length), at, 'T4');
  check(isName(name), at, 'T4', `name ${JSON.stringify(name)}`);
  fields.pad('T5');
  const record = arrayRecord(fields);
  const { type, components, rows } = record;
  return {
    domain: domain === 1 ? 'vertex' : 'cell', name, type, components, rows,
    values: valuesOf(record, at, features),
  };
}

function parseAttributes(fields, count, features) {
  const attributes = [];
  // Array.from would not do: a count may be any, and the fields end sooner.
  for (let i = 0; i < count; ++i) attributes.push(parseAttribute(fields, features));
  return attributes;
}

function checkAttributes(attributes, numVertices, numCells, at) {
  const seen = new Set();
  for (const { domain, name, rows } of attributes) {
    const expected = domain === 'vertex' ? numVertices : numCells;
    check(rows === expected, at, 'T6', `attribute ${name}: ${rows} rows, not ${expected}`);
    check(!seen.has(domain + name), at, 'T7', `attribute ${name} again`);
    seen.add(domain + name);
  }
}

function checkCells(cells, numVertices, at) {
  for (let i = 0; i < cells.length; i += 4) {
    const a = cells[i];
    const b = cells[i + 1];
    const c = cells[i + 2];
    const d = cells[i + 3];
    check(a < numVertices && b < numVertices && c < numVertices && d < numVertices, at, 'N4',
      () => `index in cell ${i / 4}`);
    check(a !== b && a !== c && a !== d && b !== c && b !== d && c !== d, at, 'N5',
      () => `cell ${i / 4} has a vertex twice`);
  }
}

/** The different vertices of each block of cells. */
function verticesOfBlocks(cells) {
  // Not as long as there are vertices: a CONN may claim any number of them.
  let largest = 0;
  for (let i = 0; i < cells.length; ++i) if (cells[i] > largest) largest = cells[i];
  const seenIn = new Uint32Array(largest + 1);
  const found = new Uint32Array(largest + 1);
  const blocks = [];
  for (let begin = 0; begin < cells.length; begin += 4 * blockRows) {
    const end = Math.min(cells.length, begin + 4 * blockRows);
    const block = blocks.length + 1;
    let count = 0;
    for (let i = begin; i < end; ++i) {
      const vertex = cells[i];
      if (seenIn[vertex] === block) continue;
      seenIn[vertex] = block;
      found[count++] = vertex;
    }
    blocks.push(found.slice(0, count));
  }
  return blocks;
}

/** The ranges of the blocks of cells (N2), six numbers each. */
function rangesOf({ blockVertices, numVertices, numLower, numUpper, numMeans, firstSource, sources }) {
  const firstUpper = numVertices - numUpper;
  const firstMean = firstUpper - numMeans;
  const ranges = new Uint32Array(6 * blockVertices.length);
  const need = (block, vertex) => {
    const part = 6 * block + (vertex < numLower ? 0 : vertex < firstUpper ? 2 : 4);
    if (ranges[part + 1] === 0 || vertex < ranges[part]) ranges[part] = vertex;
    if (vertex >= ranges[part + 1]) ranges[part + 1] = vertex + 1;
  };
  blockVertices.forEach((vertices, block) => vertices.forEach((vertex) => {
    if (vertex < firstMean || vertex >= firstUpper) {
      need(block, vertex);
      return;
    }
    const mean = vertex - firstMean;
    for (let k = firstSource[mean]; k < firstSource[mean + 1]; ++k) need(block, sources[k]);
  }));
  return ranges;
}

export function parseConn(chunk, head) {
  const { at } = chunk;
  const { features } = head;
  const fields = new Fields(chunk, 'N11');
  const [numVertices, numLower, numUpper, numMeans, numAttributes, numRanges] =
    [fields.u32(), fields.u32(), fields.u32(), fields.u32(), fields.u32(), fields.u32()];
  check(numLower + numUpper + numMeans <= numVertices, at, 'N1', 'more vertices in layers than there are');
  const rangeBytes = fields.take(24 * numRanges);
  const cellRecord = arrayRecord(fields);
  check(cellRecord.type === u32Type && cellRecord.components === 4, at, 'N3', 'type of the cells');
  const expectedRanges = cellRecord.blocks.length > 1 ? cellRecord.blocks.length : 0;
  check(numRanges === expectedRanges, at, 'N2', `${numRanges} ranges, expected ${expectedRanges}`);
  let sizeRecord = null;
  let sourceRecord = null;
  if (numMeans > 0) {
    check(features.includes('means'), at, 'N12', 'HEAD does not name the feature means');
    sizeRecord = arrayRecord(fields);
    sourceRecord = arrayRecord(fields);
    check([sizeRecord, sourceRecord].every(({ type, components }) => type === u32Type && components === 1)
      && sizeRecord.rows === numMeans, at, 'N6', 'types of the means');
  }
  const cells = valuesOf(cellRecord, at, features);
  checkCells(cells, numVertices, at);
  const firstSource = new Uint32Array(numMeans + 1);
  const sources = numMeans > 0 ? valuesOf(sourceRecord, at, features) : new Uint32Array(0);
  if (numMeans > 0) {
    let total = 0;
    valuesOf(sizeRecord, at, features).forEach((size, i) => {
      check(size > 0, at, 'N7', 'a mean of nothing');
      total += size;
      firstSource[i + 1] = total;
    });
    check(total === sources.length, at, 'N8', `${sources.length} sources, the sizes say ${total}`);
    const firstUpper = numVertices - numUpper;
    for (const source of sources) {
      check(source < firstUpper - numMeans || (source >= firstUpper && source < numVertices), at, 'N9',
        'a source is a mean, or no vertex');
    }
  }
  const attributes = parseAttributes(fields, numAttributes, features);
  check(attributes.every(({ domain }) => domain === 'cell'), at, 'N10', 'an attribute of vertices');
  fields.finish();
  checkAttributes(attributes, 0, cells.length / 4, at);
  const conn = {
    kind: 'CONN', at, numVertices, numLower, numUpper, numMeans, cells, firstSource, sources, attributes,
    numStored: numVertices - numLower - numUpper - numMeans, numRanges,
  };
  conn.prisms = prismsOf(conn);
  if (numRanges > 0) {
    conn.blockVertices = verticesOfBlocks(cells);
    const said = new Uint32Array(rangeBytes.slice().buffer);
    check(isSame(said, rangesOf(conn)), at, 'N2', 'not the vertices that the blocks of cells need');
  }
  return conn;
}

/** Positions as coordinates, three for each vertex. */
function positionsOf(record, at, { features, grid }, rule) {
  const { type, components } = record;
  check(components === 3 && [i32Type, f32Type, f64Type].includes(type), at, rule, 'type of the positions');
  if (type === i32Type) check(grid, at, rule, 'HEAD does not name the feature grid');
  const values = valuesOf(record, at, features);
  if (type === f64Type) return values;
  const positions = new Float64Array(values);
  if (type === i32Type) {
    for (let i = 0; i < positions.length; ++i) positions[i] = grid.origin[i % 3] + grid.step * positions[i];
  }
  return positions;
}

export function parseLayr(chunk, head) {
  const { at } = chunk;
  const fields = new Fields(chunk, 'L4');
  const time = fields.f64();
  check(Number.isFinite(time), at, 'L1', `time ${time}`);
  const numAttributes = fields.u32();
  fields.zeros(4, 'L6');
  const record = arrayRecord(fields);
  const positions = positionsOf(record, at, head, 'L2');
  check(record.rows > 0, at, 'L3', 'no vertices');
  const attributes = parseAttributes(fields, numAttributes, head.features);
  check(attributes.every(({ domain }) => domain === 'vertex'), at, 'L5', 'an attribute of cells');
  fields.finish();
  checkAttributes(attributes, record.rows, 0, at);
  return { kind: 'LAYR', at, time, positions, attributes, isFloat32: record.type === f32Type };
}

/** The fields of a POSE; `layer` is the offset of its LAYR. */
export function parsePose(chunk, head) {
  const { at } = chunk;
  check(head.features.includes('pose'), at, 'K5', 'HEAD does not name the feature pose');
  const fields = new Fields(chunk, 'K4');
  const time = fields.f64();
  check(Number.isFinite(time), at, 'K1', `time ${time}`);
  const layer = at - fields.u64();
  const matrix = fields.f64s(12);
  check(matrix.every(Number.isFinite), at, 'K3', 'matrix');
  fields.finish();
  return { kind: 'POSE', at, time, layer, matrix };
}

/** The layer that a POSE makes of its LAYR. */
export function posed(pose, layr) {
  check(layr?.kind === 'LAYR', pose.at, 'K2', `no LAYR at ${pose.layer}, before the pose`);
  const { matrix: m } = pose;
  const from = layr.positions;
  const positions = new Float64Array(from.length);
  for (let i = 0; i < from.length; i += 3) {
    const x = from[i];
    const y = from[i + 1];
    const z = from[i + 2];
    for (let row = 0; row < 3; ++row) {
      const k = 4 * row;
      const value = ((m[k] * x + m[k + 1] * y) + m[k + 2] * z) + m[k + 3];
      positions[i + row] = layr.isFloat32 ? Math.fround(value) : value;
    }
  }
  return { kind: 'POSE', at: pose.at, time: pose.time, layer: pose.layer, positions, attributes: layr.attributes };
}

/** The fields of a SLAB; its parts are offsets, 0 where a layer is empty. */
export function parseSlab(chunk, head) {
  const { at } = chunk;
  const fields = new Fields(chunk, 'S9');
  const begin = fields.f64();
  const end = fields.f64();
  check(Number.isFinite(begin) && Number.isFinite(end) && begin <= end, at, 'S1', `from ${begin} to ${end}`);
  const [connectivity, lower, upper] = [fields.u64(), fields.u64(), fields.u64()]
    .map((distance) => (distance === 0 ? 0 : at - distance));
  const body = fields.u32();
  check(body < head.bodies.length, at, 'S4', `body ${body}`);
  const numAttributes = fields.u32();
  const numBounds = fields.u32();
  fields.zeros(4, 'S11');
  check(64 * numBounds <= fields.bytes.length, at, 'S9', 'the fields end too early');
  const bounds = fields.f64s(8 * numBounds);
  const positionRecord = arrayRecord(fields);
  const positions = positionsOf(positionRecord, at, head, 'S5');
  const timeRecord = arrayRecord(fields);
  check(timeRecord.type === f64Type && timeRecord.components === 1 && timeRecord.rows === positionRecord.rows,
    at, 'S6', 'type of the times of the interior');
  const times = valuesOf(timeRecord, at, head.features);
  const attributes = parseAttributes(fields, numAttributes, head.features);
  fields.finish();
  return { kind: 'SLAB', at, begin, end, connectivity, lower, upper, body, bounds, positions, times, attributes };
}

/** Minimum and maximum of x, y, z, t of some vertices. */
function boundsOfSome(numbers, vertices) {
  const low = new Array(4).fill(Infinity);
  const high = new Array(4).fill(-Infinity);
  for (let axis = 0; axis < 4; ++axis) {
    for (let i = 0; i < numbers.length; ++i) {
      const value = vertices[4 * numbers[i] + axis];
      if (value < low[axis]) low[axis] = value;
      if (value > high[axis]) high[axis] = value;
    }
  }
  return [...low, ...high];
}

function checkBounds(slab, conn, vertices) {
  const count = slab.bounds.length / 8;
  if (count === 0) return;
  check(count === conn.numRanges, slab.at, 'S10', `${count} bounds for ${conn.numRanges} blocks of cells`);
  const found = Float64Array.from(conn.blockVertices.flatMap((numbers) => boundsOfSome(numbers, vertices)));
  check(isSame(slab.bounds, found), slab.at, 'S10', 'not the bounds of the blocks of cells');
}

function fillMeans(vertices, { numVertices, numUpper, numMeans, firstSource, sources }) {
  const first = numVertices - numUpper - numMeans;
  for (let i = 0, to = 4 * first; i < numMeans; ++i, to += 4) {
    const begin = firstSource[i];
    const end = firstSource[i + 1];
    let from = 4 * sources[begin];
    let x = vertices[from];
    let y = vertices[from + 1];
    let z = vertices[from + 2];
    let t = vertices[from + 3];
    for (let k = begin + 1; k < end; ++k) {
      from = 4 * sources[k];
      x += vertices[from];
      y += vertices[from + 1];
      z += vertices[from + 2];
      t += vertices[from + 3];
    }
    const count = end - begin;
    vertices[to] = x / count;
    vertices[to + 1] = y / count;
    vertices[to + 2] = z / count;
    vertices[to + 3] = t / count;
  }
}

/** An attribute of the vertices of a slab, from those of its three parts. */
function joined(parts, conn) {
  const { type, components } = parts.find(Boolean);
  const { numVertices, numUpper, numMeans, firstSource, sources } = conn;
  const Type = parts.find(Boolean).values.constructor;
  const values = new Type(numVertices * components);
  const [lower, interior, upper] = parts.map((part) => part?.values ?? new Type(0));
  values.set(lower);
  values.set(interior, lower.length);
  values.set(upper, (numVertices - numUpper) * components);
  const isFloat = type === f32Type || type === f64Type;
  const first = numVertices - numUpper - numMeans;
  for (let i = 0; i < numMeans; ++i) {
    for (let k = 0; k < components; ++k) {
      const begin = firstSource[i];
      const end = firstSource[i + 1];
      let value = values[sources[begin] * components + k];
      if (isFloat) {
        for (let j = begin + 1; j < end; ++j) value += values[sources[j] * components + k];
        value /= end - begin;
      }
      values[(first + i) * components + k] = value;
    }
  }
  if (isFloat) settleNans(values, first * components, (first + numMeans) * components);
  return { ...parts.find(Boolean), domain: 'vertex', values };
}

/** Which of all NaNs an engine stores is up to it; those of means have fixed bits. */
function settleNans(values, begin, end) {
  const size = values.BYTES_PER_ELEMENT;
  const words = new Uint32Array(values.buffer);
  for (let i = begin; i < end; ++i) {
    if (!Number.isNaN(values[i])) continue;
    if (size === 4) {
      words[i] = 0x7fc00000;
    } else {
      words[2 * i] = 0;
      words[2 * i + 1] = 0x7ff80000;
    }
  }
}

const kindOf = ({ name, type, components }) => JSON.stringify([name, type, components]);

/** The attributes of a slab: those of its CONN, of its vertices, and its own of cells. */
function attributesOf(slab, conn, lower, upper) {
  const own = slab.attributes;
  const ofInterior = own.filter(({ domain }) => domain === 'vertex');
  check(slab.times.length > 0 || ofInterior.length === 0, slab.at, 'P5', 'attributes of no vertices');
  checkAttributes([...conn.attributes, ...own], slab.times.length, conn.cells.length / 4, slab.at);
  const parts = [lower?.attributes, slab.times.length > 0 ? ofInterior : undefined, upper?.attributes];
  const [first, ...others] = parts.filter(Boolean).map((those) => those.map(kindOf));
  for (const other of others) check(isSame(first, other), slab.at, 'P5', 'parts with other attributes');
  const ofVertices = (first ?? []).map((_, i) => joined(parts.map((part) => part?.[i]), conn));
  return [...conn.attributes, ...ofVertices, ...own.filter(({ domain }) => domain === 'cell')];
}

const firstNotFinite = (vertices) => Math.floor(vertices.findIndex((value) => !Number.isFinite(value)) / 4);

/**
 * A slab, put together.
 * @param slab of parseSlab()
 * @param conn its CONN, or another part or undefined, which is refused
 * @param lower its lower layer, a LAYR or posed(); undefined where there is none
 * @param upper its upper layer, a LAYR or posed(); undefined where there is none
 * @returns {Slab}
 */
export function assembled(slab, conn, lower, upper) {
  const { at, begin, end } = slab;
  check(conn?.kind === 'CONN', at, 'S2', `no CONN at ${slab.connectivity}, before the slab`);
  const layer = (offset, part, count, time) => {
    if (offset !== 0) {
      check(part?.kind === 'LAYR' || part?.kind === 'POSE', at, 'S3', `no LAYR at ${offset}, before the slab`);
      check(part.time === time, at, 'P3', `layer at ${part.time}, not ${time}`);
    }
    const found = (part?.positions.length ?? 0) / 3;
    check(found === count, at, 'P1', `layer of ${found} vertices, not ${count}`);
  };
  layer(slab.lower, lower, conn.numLower, begin);
  layer(slab.upper, upper, conn.numUpper, end);
  check(slab.times.length === conn.numStored, at, 'P1',
    `${slab.times.length} interior vertices, not ${conn.numStored}`);

  const { numVertices, numLower, numUpper, numMeans } = conn;
  const vertices = new Float64Array(4 * numVertices);
  const put = (positions, first, timeOf) => {
    for (let from = 0, to = 4 * first, i = 0; from < positions.length; from += 3, to += 4, ++i) {
      vertices[to] = positions[from];
      vertices[to + 1] = positions[from + 1];
      vertices[to + 2] = positions[from + 2];
      vertices[to + 3] = timeOf(i);
    }
  };
  if (lower) put(lower.positions, 0, () => lower.time);
  put(slab.positions, numLower, (i) => slab.times[i]);
  if (upper) put(upper.positions, numVertices - numUpper, () => upper.time);
  fillMeans(vertices, conn);
  const bounds = noBounds(4);
  check(widen(bounds, vertices), at, 'P2', () => `vertex ${firstNotFinite(vertices)} is not finite`);
  for (let i = numLower; i < numVertices - numUpper; ++i) {
    const t = vertices[4 * i + 3];
    if (t >= begin && t <= end) continue;
    check(false, at, 'P4', `vertex ${i} is outside the times of the slab`);
  }
  checkBounds(slab, conn, vertices);
  return {
    at, body: slab.body, begin, end, vertices, cells: conn.cells, numVertices, numLower, numUpper, numMeans,
    ...bounds, prisms: conn.prisms, blockBounds: slab.bounds,
    connectivity: conn.at, lower: slab.lower, upper: slab.upper,
    attributes: attributesOf(slab, conn, lower, upper),
  };
}
