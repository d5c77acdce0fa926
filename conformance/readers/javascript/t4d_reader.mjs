#!/usr/bin/env node
// Reads a .t4d file as the appendix "A reader under test" of formats/t4d/SPEC.md asks:
//
//     t4d_reader.mjs FILE describe     reads everything and checks every rule
//     t4d_reader.mjs FILE slice T      reads what the slice needs, no more if there is an index
//     t4d_reader.mjs FILE slice x C    slices by x = C, y = C or z = C; reads and checks everything
//     t4d_reader.mjs FILE slice A,B,C,D E      the same for A x + B y + C z + D t = E
//     t4d_reader.mjs --serve           answers such requests from standard input, one a line
//
// Bytes are taken apart by the parser that compile.mjs makes of formats/t4d/t4d.ksy, and by nothing
// else. It checks what the grammar can say; what is checked here is the rest: checksums, text,
// JSON, compression, and whatever compares one chunk with another.
//
// The parser reads a u64 as Number, exact up to 2^53. That is enough: every length is held against
// the size of the file before it is used, every offset and count is compared for equality with one
// that was counted here, and none of these comes near 2^53; and the values of 64-bit attributes are
// never looked at, only their bytes.
//
// It is started from the folder that compile.mjs makes.
import { closeSync, fstatSync, openSync, readSync } from 'node:fs';
import { createRequire } from 'node:module';

import { run } from './under_test.mjs';

const require = createRequire(import.meta.url);
const KaitaiStream = require('kaitai-struct/KaitaiStream');
const { T4d } = require('./T4d.cjs');
const rules = require('./rules.json');

/** The file breaks a rule, or cannot be read here. */
class Invalid extends Error {}

function check(ok, at, rule, message) {
  if (!ok) throw new Invalid(`byte ${at}: ${rule}: ${message}`);
}

// Bytes ------------------------------------------------------------------------------------------

const crcTable = Uint32Array.from({ length: 256 }, (_, value) => {
  for (let bit = 0; bit < 8; ++bit) value = (value >>> 1) ^ (value & 1 ? 0x82f63b78 : 0);
  return value;
});

/** The checksum of the bytes, after others that have the checksum `before`. */
function crc32c(bytes, before = 0) {
  let crc = before ^ 0xffffffff;
  for (const byte of bytes) crc = (crc >>> 8) ^ crcTable[(crc ^ byte) & 0xff];
  return (crc ^ 0xffffffff) >>> 0;
}

class File {
  constructor(path) {
    this.descriptor = openSync(path, 'r');
    this.size = fstatSync(this.descriptor).size;
  }

  read(at, length, rule) {
    check(at + length <= this.size, at, rule, `${length} bytes, the file has ${this.size} in all`);
    const bytes = new Uint8Array(length);
    for (let done = 0; done < length;) {
      const more = readSync(this.descriptor, bytes, done, length - done, at + done);
      check(more > 0, at + done, rule, 'the file became shorter');
      done += more;
    }
    return bytes;
  }

  close() {
    closeSync(this.descriptor);
  }
}

/** What the parser found wrong; its own errors do not keep where that was. */
class NotValid extends Error {
  constructor(io, path) {
    super(`${path} is not as the grammar says`);
    Object.assign(this, { io, path });
  }
}
for (const name of ['NotEqual', 'LessThan', 'GreaterThan', 'NotInEnum', 'Expr']) {
  KaitaiStream[`Validation${name}Error`] = class extends NotValid {
    constructor(...args) {
      super(...args.slice(-2));
    }
  };
}

/**
 * The Kaitai type in `bytes`, which are at the offset `at` of the file; bytes that are missing
 * break `rule`.
 */
function parse(Type, bytes, at, rule) {
  try {
    return new Type(new KaitaiStream(bytes));
  } catch (error) {
    if (error instanceof NotValid) {
      // Streams of payloads and arrays are windows on the same buffer.
      const place = at + error.io.byteOffset - bytes.byteOffset + error.io.pos;
      throw new Invalid(`before byte ${place}: ${rules[error.path] ?? rule}: ${error.path}`);
    }
    if (error instanceof KaitaiStream.EOFError) {
      throw new Invalid(`byte ${at}: ${rule}: cut off: ${error.message}`);
    }
    throw error;
  }
}

const hexOf = (bytes) => Buffer.from(bytes).toString('hex');

const utf8 = new TextDecoder('utf-8', { fatal: true, ignoreBOM: true });

function text(bytes, at, rule) {
  try {
    return utf8.decode(bytes);
  } catch {
    return check(false, at, rule, 'not UTF-8');
  }
}

// Chunks -----------------------------------------------------------------------------------------

const footerSize = 40;

function readFileHeader(file) {
  const bytes = file.read(0, 24, 'H1');
  const header = parse(T4d.FileHeader, bytes, 0, 'H1');
  check(header.checksum === crc32c(bytes.subarray(0, 20)), 20, 'H2', 'checksum of the file header');
  return header;
}

function readFooter(file) {
  const at = file.size - footerSize;
  check(at >= 24, 24, 'F1', 'no room for the footer');
  const bytes = file.read(at, footerSize, 'F1');
  const footer = parse(T4d.FileFooter, bytes, at, 'F1');
  check(footer.checksum === crc32c(bytes.subarray(0, 28)), at + 28, 'F2', 'checksum of the footer');
  check(footer.lenFile === file.size, at + 16, 'F3', `the file has ${file.size} bytes`);
  return footer;
}

/** The rules that are broken by fields that end too early. */
const endRules = { HEAD: 'M3', CONN: 'N11', LAYR: 'L4', POSE: 'K4', SLAB: 'S9', DONE: 'D4', INDX: 'I8' };

/**
 * The chunk at this offset, whole and with right checksums; `headerText` is its header without the
 * checksum, as hexadecimal digits.
 */
function readChunk(file, at) {
  const headerBytes = file.read(at, 28, 'C3');
  const header = parse(T4d.ChunkHeader, headerBytes, at, 'C3');
  const type = header.type.text;
  const size = header.lenChunk;
  check(at + size <= file.size, at + 8, 'C3', `${header.lenPayload} bytes are not there`);
  const checksum = new KaitaiStream(file.read(at + 28, 4, 'C3')).readU4le();
  check(checksum === crc32c(headerBytes), at + 28, 'C4', 'header checksum');
  check(type !== 'HEAD' || header.lenPayload <= 16 << 20, at + 8, 'M1', 'HEAD above 16 MiB');
  const bytes = file.read(at, size, 'C3');
  const front = bytes.subarray(32, 32 + header.lenFront);
  check(header.frontChecksum === crc32c(front), at + 24, 'C5', 'front checksum');
  check(header.isKnown || !header.isCritical, at, 'C8', `unknown critical chunk ${type}`);
  const { table, fields, contents } = parse(T4d.Chunk, bytes, at, endRules[type] ?? 'C9');
  table.forEach((entry, i) => {
    const sum = crc32c(contents.blocks[i].data);
    check(entry.checksum === sum, at + 36 + 8 * i, 'C10', 'checksum of a block');
  });
  return { at, type, size, headerText: hexOf(headerBytes), checksum, fields };
}

// HEAD -------------------------------------------------------------------------------------------

const knownFeatures = ['zstd', 'means', 'pose', 'grid'];

/** HEAD from these bytes, at this offset. */
/** Whether the value is a name as the page has it. */
const isName = (value) => typeof value === 'string' && Buffer.from(value).toString() === value
  && Buffer.byteLength(value) >= 1 && Buffer.byteLength(value) <= 255
  && !/[\0-\x1f\x7f-\x9f/\u061c\u200e\u200f\u202a-\u202e\u2066-\u2069]/.test(value);

/** Checks the members of bodies beside their names. */
function checkBodies(objects, names, at) {
  const parents = new Map();
  objects.forEach((body, i) => {
    const of = (key) => (Object.hasOwn(body, key) ? body[key] : undefined);
    for (const key of ['material', 'parent']) {
      check(['string', 'undefined'].includes(typeof of(key)), at, 'M11', `type of ${key}`);
    }
    const { color = [0, 0, 0], details = {} } = { color: of('color'), details: of('details') };
    check(Array.isArray(color) && [3, 4].includes(color.length)
      && color.every((part) => typeof part === 'number' && part >= 0 && part <= 1), at, 'M11', 'color');
    check(typeof details === 'object' && details !== null && !Array.isArray(details), at, 'M11',
      'type of details');
    if (of('parent') !== undefined) parents.set(names[i], of('parent'));
  });
  const rooted = new Set(names.filter((name) => !parents.has(name)));
  const known = new Set(names);
  for (const name of names) {
    const path = [name];
    while (!rooted.has(path.at(-1))) {
      path.push(parents.get(path.at(-1)));
      check(known.has(path.at(-1)) && path.length <= names.length, at, 'M11', `parent of ${name}`);
    }
    path.forEach((each) => rooted.add(each));
  }
}

function readHead(bytes, at) {
  check(bytes.length <= 16 << 20, at, 'M1', 'HEAD above 16 MiB');
  const json = text(bytes, at, 'M2');
  check(!json.startsWith('\ufeff'), at, 'M2', 'byte order mark');
  let head;
  try {
    head = JSON.parse(json);
  } catch (error) {
    check(false, at, 'M3', error.message);
  }
  const isObject = (value) => typeof value === 'object' && value !== null;
  check(isObject(head) && !Array.isArray(head), at, 'M3', 'no JSON object');
  let level = [head];
  for (let depth = 1; level.length > 0; ++depth) {
    check(depth <= 64, at, 'M4', 'nested more than 64 deep');
    level = level.flatMap((each) => Object.values(each)).filter(isObject);
  }
  const member = (name) => (Object.hasOwn(head, name) ? head[name] : undefined);
  const strings = (name, rule) => {
    const value = member(name);
    check(Array.isArray(value) && value.every((each) => typeof each === 'string'), at, rule,
      `${name} is no array of strings`);
    return value;
  };
  const features = strings('features', 'M5');
  for (const each of features) {
    check(knownFeatures.includes(each), at, 'M6', `this reader does not know the feature ${each}`);
  }
  const isPlain = (value) => isObject(value) && !Array.isArray(value);
  const objects = member('bodies');
  check(Array.isArray(objects) && objects.every(isPlain), at, 'M7', 'bodies is no array of objects');
  check(objects.length >= 1 && objects.length <= 65536, at, 'M7', `${objects.length} bodies`);
  const bodies = objects.map((body) => (Object.hasOwn(body, 'name') ? body.name : undefined));
  for (const name of bodies) check(isName(name), at, 'M8', `name ${JSON.stringify(name)}`);
  check(new Set(bodies).size === bodies.length, at, 'M9', 'two bodies of one name');
  checkBodies(objects, bodies, at);
  for (const name of ['generator', 'backend', 'length_unit', 'time_unit', 'up']) {
    check(['string', 'undefined'].includes(typeof member(name)), at, 'M10', `type of ${name}`);
  }
  check(['y', 'z', undefined].includes(member('up')), at, 'M10', 'up is neither y nor z');
  const details = member('details');
  check(details === undefined || (isObject(details) && !Array.isArray(details)), at, 'M10',
    'type of details');
  return { bytes, features, bodies, grid: gridOf(member('grid'), features.includes('grid'), at) };
}

/** { origin, step } if the file uses it. */
function gridOf(grid, isUsed, at) {
  if (grid === undefined && !isUsed) return undefined;
  const { origin, step } = grid ?? {};
  check(Array.isArray(origin) && origin.length === 3 && [...origin, step].every(Number.isFinite)
    && step > 0, at, 'M10', 'origin or step of the grid');
  return isUsed ? { origin, step } : undefined;
}

// Arrays -----------------------------------------------------------------------------------------

let zstd = null;

/** Loads the decompressor, for files that need it. */
async function prepareZstd() {
  if (zstd) return;
  const { ZSTDDecoder } = await import('zstddec');
  const { ZstdFrame } = require('./ZstdFrame.cjs');
  // Where there is fetch(), the package loads itself through it, which takes 30 ms.
  globalThis.fetch = undefined;
  const decoder = new ZSTDDecoder();
  await decoder.init();
  zstd = { decoder, ZstdFrame };
}

const maxArray = 2 ** 28;

/** The content of a frame that has to have `least` to `most` bytes. */
function decompress(bytes, least, most, at) {
  const { hasContentSize, contentSize: size } = parse(zstd.ZstdFrame, bytes, at, 'A10');
  check(hasContentSize && size >= least && size <= most, at, 'A11', `${size} bytes, not ${most}`);
  const content = zstd.decoder.decode(bytes, size);
  check(content.length === size, at, 'A12', 'the frame does not decompress');
  return content;
}

/** Rows of `size` bytes that were transposed. */
function inRows(content, size) {
  const bytes = new Uint8Array(content.length);
  for (let byte = 0, from = 0; byte < size; ++byte) {
    for (let to = byte; to < bytes.length; to += size) bytes[to] = content[from++];
  }
  return bytes;
}

const scalars = (bytes, type, count) =>
  new T4d.Scalars(new KaitaiStream(bytes), null, null, type, count).values;

/** The bytes of `count` scalars, of codec 2. */
function repeats(content, count, components, at) {
  const distances = inRows(content.subarray(0, count), components);
  const rest = distances.reduce((sum, distance) => sum + (distance === 0), 0);
  check(content.length === count + 4 * rest, at, 'A15', `${rest} numbers are not repeated`);
  const stored = scalars(inRows(content.subarray(count), 4), T4d.ScalarType.U32, rest);
  const numbers = new Uint32Array(count);
  const bytes = new DataView(new ArrayBuffer(4 * count));
  let before = 0;
  let used = 0;
  distances.forEach((distance, i) => {
    check(distance <= i, at, 'A14', 'a distance to before the first scalar');
    if (distance === 0) {
      const z = stored[used++];
      before = (before + ((z >>> 1) ^ -(z & 1))) >>> 0;
    }
    numbers[i] = distance === 0 ? before : numbers[i - distance];
    bytes.setUint32(4 * i, numbers[i], true);
  });
  return new Uint8Array(bytes.buffer);
}

/** The bytes of an array, row after row. */
function bytesOf(record, at, features) {
  const { codec, numRows, lenRow, numComponents, blocks } = record;
  const isRaw = codec === T4d.Codec.RAW;
  check(isRaw || features.includes('zstd'), at, 'A13', 'HEAD does not name the feature zstd');
  const size = numRows * lenRow;
  check(isRaw || size <= maxArray, at, 'A9', `not enough memory here for ${size} bytes`);
  const rows = ({ stored, lenRows, numRows: count }) => {
    if (isRaw) return stored;
    if (codec === T4d.Codec.TRANSPOSED) {
      return inRows(decompress(stored, lenRows, lenRows, at), lenRow);
    }
    // A byte for each number, and the number itself for some.
    const numbers = count * numComponents;
    const content = decompress(stored, numbers, numbers + lenRows, at);
    return repeats(content, numbers, numComponents, at);
  };
  if (blocks.length === 1) return rows(blocks[0]);
  const bytes = new Uint8Array(size);
  let end = 0;
  for (const block of blocks) {
    bytes.set(rows(block), end);
    end += block.lenRows;
  }
  return bytes;
}

const numbersOf = (record, at, features) => scalars(
  bytesOf(record, at, features), record.scalarType, record.numRows * record.numComponents);

/** The numbers of an array, an array for each row. */
function rowsOf(record, at, features) {
  const numbers = numbersOf(record, at, features);
  const size = record.numComponents;
  return Array.from({ length: record.numRows }, (_, i) => numbers.slice(size * i, size * (i + 1)));
}

function nameOf(bytes, at) {
  const name = text(bytes, at, 'T4');
  check(isName(name), at, 'T4', `name ${JSON.stringify(name)}`);
  return name;
}

function readAttributes(attributes, at, features) {
  return attributes.map(({ domain, nameBytes, values }) => ({
    domain: domain === T4d.Domain.VERTEX ? 'vertex' : 'cell',
    name: nameOf(nameBytes, at),
    rows: values.numRows,
    type: values.scalarType,
    components: values.numComponents,
    bytes: bytesOf(values, at, features),
  }));
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

// Parts and slabs --------------------------------------------------------------------------------

function readConn({ at, fields }, features) {
  const { numVertices, numLower, numUpper, numMeans, numStored } = fields;
  const cells = rowsOf(fields.cells, at, features);
  cells.forEach(([a, b, c, d], i) => {
    check(Math.max(a, b, c, d) < numVertices, at, 'N4', `index in cell ${i}`);
    check(a !== b && a !== c && a !== d && b !== c && b !== d && c !== d, at, 'N5',
      `cell ${i} has a vertex twice`);
  });
  const sources = [];
  if (numMeans > 0) {
    check(features.includes('means'), at, 'N12', 'HEAD does not name the feature means');
    const sizes = numbersOf(fields.meanSizes, at, features);
    const numbers = numbersOf(fields.meanSources, at, features);
    check(!sizes.includes(0), at, 'N7', 'a mean of nothing');
    const total = sizes.reduce((sum, size) => sum + size, 0);
    check(total === numbers.length, at, 'N8', `${numbers.length} sources, the sizes say ${total}`);
    const end = numVertices - numUpper;
    check(numbers.every((i) => i < end - numMeans || (i >= end && i < numVertices)), at, 'N9',
      'a source is a mean, or no vertex');
    let first = 0;
    for (const size of sizes) sources.push(numbers.slice(first, (first += size)));
  }
  const attributes = readAttributes(fields.attributes, at, features);
  // The numbers of the vertices of each block of cells, if there is more than one.
  const blocks = fields.ranges.map((_, i) =>
    new Set(cells.slice(blockRows * i, blockRows * (i + 1)).flat()));
  const conn = {
    kind: 'CONN', numVertices, numLower, numUpper, numMeans, numStored, cells, sources, attributes,
    blocks,
  };
  fields.ranges.forEach((range, i) => {
    const expected = rangesOf(blocks[i], conn);
    check(isSame([range.lower, range.interior, range.upper].flat(), expected), at, 'N2',
      `block ${i} of the cells needs the vertices ${expected}`);
  });
  checkAttributes(attributes, 0, cells.length, at);
  return conn;
}

const blockRows = 65536;

const isSame = (some, others) =>
  some.length === others.length && some.every((value, i) => value === others[i]);

/** The range of a block of cells with these vertices. */
function rangesOf(vertices, { numVertices, numLower, numUpper, numMeans, sources }) {
  const firstUpper = numVertices - numUpper;
  const firstMean = firstUpper - numMeans;
  const range = [0, 0, 0, 0, 0, 0];
  const need = (i) => {
    const part = i < numLower ? 0 : i < firstUpper ? 2 : 4;
    const isFirst = range[part + 1] === 0;
    range[part] = isFirst ? i : Math.min(range[part], i);
    range[part + 1] = Math.max(range[part + 1], i + 1);
  };
  for (const i of vertices) {
    if (i >= firstMean && i < firstUpper) {
      sources[i - firstMean].forEach(need);
    } else {
      need(i);
    }
  }
  return range;
}

/** The rows of an array of positions, as coordinates. */
function positionsOf(record, at, { features, grid }, rule) {
  const rows = rowsOf(record, at, features);
  if (record.scalarType !== T4d.ScalarType.S32) return rows;
  check(grid, at, rule, 'HEAD does not name the feature grid');
  return rows.map((row) => row.map((k, axis) => grid.origin[axis] + grid.step * k));
}

function readLayr({ at, fields: { time, positions, attributes: records } }, head) {
  const { features } = head;
  const points = positionsOf(positions, at, head, 'L2').map((position) => [...position, time]);
  const attributes = readAttributes(records, at, features);
  checkAttributes(attributes, points.length, 0, at);
  const isFloat32 = positions.scalarType === T4d.ScalarType.F32;
  return { kind: 'LAYR', time, points, attributes, isFloat32 };
}

/** The offset of a part that begins `distance` bytes before `at`; null for an empty layer. */
const placeOf = (at, distance) => (distance === 0 ? null : at - distance);

function readPose({ at, fields: { time, distanceLayer, matrix } }, { features }, part) {
  check(features.includes('pose'), at, 'K5', 'HEAD does not name the feature pose');
  const ofsLayer = placeOf(at, distanceLayer);
  const layer = ofsLayer >= 24 && ofsLayer < at ? part(ofsLayer) : undefined;
  check(layer?.kind === 'LAYR', at, 'K2', `no LAYR ${distanceLayer} bytes before the pose`);
  const rounded = layer.isFloat32 ? Math.fround : (value) => value;
  const points = layer.points.map(([x, y, z]) => [...[0, 4, 8].map((i) =>
    rounded(((matrix[i] * x + matrix[i + 1] * y) + matrix[i + 2] * z) + matrix[i + 3])), time]);
  return { kind: 'POSE', time, points, attributes: layer.attributes, ofsLayer };
}

const readPart = (chunk, head, part) => ({
  CONN: () => readConn(chunk, head.features),
  LAYR: () => readLayr(chunk, head),
  POSE: () => readPose(chunk, head, part),
})[chunk.type]?.();

/** A slab, put together; part(offset) is a part, or undefined. `record` is what INDX says of it. */
function readSlab({ at, fields }, head, part) {
  const { timeBegin, timeEnd, body } = fields;
  const [ofsConnectivity, ofsLower, ofsUpper] =
    [fields.distanceConnectivity, fields.distanceLower, fields.distanceUpper]
      .map((distance) => placeOf(at, distance));
  check(body < head.bodies.length, at, 'S4', `body ${body}`);
  const times = numbersOf(fields.times, at, head.features);
  const interior = positionsOf(fields.positions, at, head, 'S5')
    .map((position, i) => [...position, times[i]]);
  const own = readAttributes(fields.attributes, at, head.features);
  const find = (offset, kinds, rule) => {
    const found = offset >= 24 && offset < at ? part(offset) : undefined;
    check(kinds.includes(found?.kind), at, rule, `no ${kinds} at ${offset}, before the slab`);
    return found;
  };
  const conn = find(ofsConnectivity, ['CONN'], 'S2');
  const layer = (offset, rows, time) => {
    const { points, time: found, attributes } =
      offset === null ? { points: [], time, attributes: [] } : find(offset, ['LAYR', 'POSE'], 'S3');
    check(points.length === rows, at, 'P1', `layer of ${points.length} vertices, not ${rows}`);
    check(found === time, at, 'P3', `layer at ${found}, not ${time}`);
    return { points, attributes };
  };
  const { points: lower, attributes: ofLower } = layer(ofsLower, conn.numLower, timeBegin);
  const { points: upper, attributes: ofUpper } = layer(ofsUpper, conn.numUpper, timeEnd);
  check(interior.length === conn.numStored, at, 'P1',
    `${interior.length} interior vertices, not ${conn.numStored}`);
  const known = [...lower, ...interior, ...new Array(conn.numMeans), ...upper];
  const means = conn.sources.map((sources) => mean(sources.map((i) => known[i])));
  const vertices = [...lower, ...interior, ...means, ...upper];
  check(vertices.every((point) => point.every(Number.isFinite)), at, 'P2', 'not all are finite');
  check([...interior, ...means].every(([, , , t]) => t >= timeBegin && t <= timeEnd), at, 'P4',
    'an interior vertex outside the times of the slab');
  checkAttributes([...conn.attributes, ...own], interior.length, conn.cells.length, at);
  const ofInterior = own.filter(({ domain }) => domain === 'vertex');
  check(interior.length > 0 || ofInterior.length === 0, at, 'P5', 'attributes of no vertices');
  const parts = [[lower, ofLower], [interior, ofInterior], [upper, ofUpper]]
    .filter(([points]) => points.length > 0).map(([, those]) => those);
  const kindOf = ({ name, type, components }) => JSON.stringify([name, type, components]);
  for (const part of parts) {
    check(isSame(part.map(kindOf), parts[0].map(kindOf)), at, 'P5', 'parts with other attributes');
  }
  const ofVertices = (parts[0] ?? []).map((kind, i) => withMeans(
    kind, [ofLower, ofInterior, ofUpper].map((those) => those[i]?.bytes ?? new Uint8Array(0)), conn));
  const attributes = [
    ...conn.attributes, ...ofVertices, ...own.filter(({ domain }) => domain === 'cell'),
  ];
  const bounds = conn.blocks.flatMap((block) =>
    widen(noBounds(4), [...block].map((i) => vertices[i])).flat());
  check(fields.bounds.length === 0 || isSame(fields.bounds, bounds), at, 'S10', `the bounds are ${bounds}`);
  const record = {
    at, timeBegin, timeEnd, ofsConnectivity, ofsLower, ofsUpper, body, numCells: conn.cells.length,
    bounds: widen(noBounds(3), vertices).flat(),
  };
  return { record, conn, vertices, attributes };
}

const lenScalar = { [T4d.ScalarType.F32]: 4, [T4d.ScalarType.F64]: 8 };

/** An attribute of the vertices of a slab, made of the bytes of its three parts. */
function withMeans(kind, [lower, interior, upper], { numVertices, numUpper, numMeans, sources }) {
  const { type, components } = kind;
  const stored = lower.length + interior.length + upper.length;
  const size = stored / (numVertices - numMeans);
  const bytes = new Uint8Array(numVertices * size);
  bytes.set(lower);
  bytes.set(interior, lower.length);
  bytes.set(upper, (numVertices - numUpper) * size);
  const view = new DataView(bytes.buffer);
  const isSingle = type === T4d.ScalarType.F32;
  sources.forEach((from, i) => {
    const at = (numVertices - numUpper - numMeans + i) * size;
    if (!lenScalar[type]) {
      bytes.copyWithin(at, from[0] * size, (from[0] + 1) * size);
      return;
    }
    const scalar = lenScalar[type];
    for (let k = 0; k < components; ++k) {
      const numbers = Array.from(from, (row) => {
        const place = row * size + k * scalar;
        return isSingle ? view.getFloat32(place, true) : view.getFloat64(place, true);
      });
      const value = numbers.reduce((sum, number) => sum + number) / numbers.length;
      const place = at + k * scalar;
      // The engine chooses which NaN setFloat64() writes.
      if (Number.isNaN(value)) {
        bytes.fill(0, place, place + scalar);
        bytes.set(isSingle ? [0xc0, 0x7f] : [0xf8, 0x7f], place + scalar - 2);
      } else if (isSingle) {
        view.setFloat32(place, value, true);
      } else {
        view.setFloat64(place, value, true);
      }
    }
  });
  return { ...kind, domain: 'vertex', bytes };
}

function mean(points) {
  const sum = [...points[0]];
  for (const point of points.slice(1)) {
    for (let i = 0; i < 4; ++i) sum[i] += point[i];
  }
  return sum.map((value) => value / points.length);
}

// Whole files ------------------------------------------------------------------------------------

/**
 * Checks DONE, as far as that is possible without the slabs; `bodies` has the records of each,
 * `headers` those of all chunks but INDX.
 */
function checkDone({ at, fields: done }, bodies, headers) {
  check(done.numBodies === bodies.length, at, 'D2', `HEAD names ${bodies.length}`);
  check(done.numChunks === headers.size - 1, at, 'D1', `${headers.size - 1} chunks are there`);
  const isOf = (type) => (offset) => headers.get(offset).startsWith(hexOf(new TextEncoder().encode(type)));
  const isCopy = (layer, other) => headers.has(layer) && headers.get(layer) === headers.get(other)
    && isOf('LAYR')(layer);
  // The last of each type before a slab may be named by it.
  const places = ['CONN', 'LAYR', 'POSE'].map((type) => [...headers.keys()].filter(isOf(type)));
  const isNear = (part, slab, lists) => lists.some((offsets) => {
    const [i, next] = [offsets.indexOf(part), offsets.findIndex((each) => each > slab.at)];
    return i >= 0 && part < slab.at && i >= (next < 0 ? offsets.length : next) - 16 * bodies.length;
  });
  bodies.forEach((slabs, i) => {
    const said = done.bodies[i];
    check(said.numSlabs === slabs.length && slabs.length > 0, at, 'D5',
      `body ${i} has ${slabs.length} slabs`);
    slabs.slice(1).forEach((slab, k) => {
      const before = slabs[k];
      const { at: place, timeBegin: begin } = slab;
      const { ofsLower: lower } = slab;
      check(lower === before.ofsUpper || isCopy(lower, before.ofsUpper), place, 'S7',
        'lower is not upper before');
      check(lower === null ? begin >= before.timeEnd : begin === before.timeEnd, place, 'S8',
        `begins at ${begin}, the slab before ends at ${before.timeEnd}`);
    });
    slabs.forEach((slab, k) => {
      const layers = [slab.ofsUpper, ...(k > 0 && slab.ofsLower === slabs[k - 1].ofsUpper ? [] : [slab.ofsLower])];
      check(isNear(slab.ofsConnectivity, slab, [places[0]]) &&
        layers.every((layer) => layer === null || isNear(layer, slab, places.slice(1))), slab.at, 'S12',
        'a part is far back');
    });
    check(said.timeBegin === slabs[0].timeBegin && said.timeEnd === slabs.at(-1).timeEnd, at, 'D7',
      'times of a body');
    const numCells = slabs.reduce((sum, slab) => sum + slab.numCells, 0);
    check(said.numCells === numCells, at, 'D6', `${numCells} cells are there`);
  });
}

/** [minimum, maximum] of each coordinate, where there is no point. */
const noBounds = (size) => [new Array(size).fill(Infinity), new Array(size).fill(-Infinity)];

/** Widens [minimum, maximum] so that it holds the points, and returns it. */
function widen([low, high], points) {
  for (const point of points) {
    for (let i = 0; i < low.length; ++i) {
      low[i] = Math.min(low[i], point[i]);
      high[i] = Math.max(high[i], point[i]);
    }
  }
  return [low, high];
}

/** INDX and DONE, by the footer; they take all bytes from DONE on. */
async function readEnds(file) {
  const footer = readFooter(file);
  const chunkOf = (at, type, rule) => {
    const chunk = readChunk(file, at);
    check(chunk.type === type, at, rule, `${chunk.type} instead of ${type}`);
    return chunk;
  };
  const chunk = chunkOf(footer.ofsIndex, 'INDX', 'F4');
  const { at, checksum } = chunk;
  check(checksum === footer.indexChecksum, file.size - 16, 'F6', 'not the checksum of INDX');
  const done = chunkOf(footer.ofsDone, 'DONE', 'F5');
  check(done.at + done.size === at, at, 'O4', 'INDX does not follow DONE');
  check(at + chunk.size === file.size - footerSize, at, 'O4', 'no footer after INDX');
  const indx = await readIndx(chunk);
  check(indx.fileHeader === hexOf(file.read(0, 20, 'H1')), at, 'I1', 'another file header');
  check(indx.headers.get(done.at) === done.headerText && indx.end === at, at, 'I2',
    `DONE at ${done.at} is not the last of the chunks`);
  return { indx, done };
}

/** The contents of INDX: HEAD, headers of chunks by offset, a record for each slab, the same by body. */
async function readIndx({ at, fields }) {
  const copy = bytesOf(fields.head, at, []);
  const head = readHead(copy, at);
  const { features } = head;
  if (features.includes('zstd')) await prepareZstd();
  const bytes = bytesOf(fields.chunks, at, features);
  const headers = new Map();
  const slabs = [];
  let end = 24;
  for (let i = 0; i < bytes.length; i += 28) {
    const one = bytes.subarray(i, i + 28);
    const header = parse(T4d.ChunkHeader, one, at, 'I2');
    if (i === 0) {
      check(header.type.text === 'HEAD' && header.lenPayload === copy.length &&
        header.frontChecksum === crc32c(copy), at, 'I1', 'another HEAD');
    }
    headers.set(end, hexOf(one));
    if (header.type.text === 'SLAB') slabs.push(end);
    end += header.lenChunk;
  }
  check(slabs.length === fields.numSlabs, at, 'I3', `${slabs.length} slabs are there`);
  const [times, parts, numbers, cells, bounds] =
    [fields.times, fields.parts, fields.bodies, fields.cells, fields.bounds]
      .map((column) => rowsOf(column, at, features));
  const records = slabs.map((place, i) => ({
    at: place, timeBegin: times[i][0], timeEnd: times[i][1],
    ofsConnectivity: placeOf(place, parts[i][0]), ofsLower: placeOf(place, parts[i][1]),
    ofsUpper: placeOf(place, parts[i][2]), body: numbers[i][0], numCells: cells[i][0],
    bounds: bounds[i],
  }));
  const bodies = head.bodies.map(() => []);
  for (const record of records) {
    check(record.body < bodies.length, at, 'I4', `body ${record.body}`);
    bodies[record.body].push(record);
  }
  return { at, fileHeader: hexOf(fields.header), head, headers, end, records, bodies };
}

/** Checks what INDX says of a slab. */
function checkRecord(said, found, at) {
  for (const [name, value] of Object.entries(found)) {
    if (name === 'bounds') {
      check(isSame(said.bounds, value), at, 'I6', `bounds are ${value}`);
    } else {
      check(said[name] === value, at, name === 'numCells' ? 'I5' : 'I4', `${name} is ${value}`);
    }
  }
}

/** Reads a file from the front and checks all of it; use(slab) makes of each slab what is kept. */
async function readAll(file, use) {
  const header = readFileHeader(file);
  const { indx, done: found } = header.hasIndex ? await readEnds(file) : {};
  const headers = new Map();
  const parts = new Map();
  const unused = new Set();
  const layers = [];                                    // offsets of the LAYRs
  const records = [];
  let done = null;
  let head = null;
  let bodies = [];
  let at = 24;
  while (!done) {
    check(at < file.size, at, 'O3', 'the chunks end without DONE');
    const chunk = readChunk(file, at);
    check(head || chunk.type === 'HEAD', at, 'O1', `the first chunk is ${chunk.type}`);
    if (chunk.type === 'HEAD') {
      check(!head, at, 'O2', 'HEAD again');
      head = readHead(chunk.fields.json, at + 32);
      if (head.features.includes('zstd')) await prepareZstd();
      bodies = head.bodies.map(() => ({
        slabs: [], results: [], vertices: 0, bounds: noBounds(3),
      }));
    } else if (['CONN', 'LAYR', 'POSE'].includes(chunk.type)) {
      const made = readPart(chunk, head, (offset) => parts.get(offset));
      check(made.kind !== 'POSE' || layers.slice(-16 * bodies.length).includes(made.ofsLayer), at, 'K6',
        'a LAYR far back');
      if (made.kind === 'LAYR') layers.push(at);
      parts.set(at, made);
      unused.add(at);
      unused.delete(made.ofsLayer);
    } else if (chunk.type === 'SLAB') {
      const slab = readSlab(chunk, head, (offset) => parts.get(offset));
      const { record, conn } = slab;
      unused.delete(record.ofsConnectivity);
      unused.delete(record.ofsLower);
      unused.delete(record.ofsUpper);
      const body = bodies[record.body];
      body.vertices += conn.numVertices - (body.slabs.length > 0 ? conn.numLower : 0);
      body.slabs.push(record);
      widen(body.bounds, slab.vertices);
      body.results.push(use(slab));
      records.push(record);
    } else if (chunk.type === 'DONE') {
      done = chunk;
    } else {
      check(chunk.type !== 'INDX', at, header.hasIndex ? 'O4' : 'O5', 'INDX before DONE');
    }
    if (chunk.type !== 'INDX') headers.set(at, chunk.headerText);
    at += chunk.size;
  }
  for (const offset of unused) check(false, offset, 'O6', 'no slab names this part');
  if (indx) {
    check(hexOf(head.bytes) === hexOf(indx.head.bytes), indx.at, 'I1', 'another HEAD');
    check(done.at === found.at, done.at, 'O3', 'DONE, and again');
    check(isSame([...headers.values()], [...indx.headers.values()]), indx.at, 'I2',
      'other headers of chunks');
    records.forEach((record, i) => checkRecord(indx.records[i], record, indx.at));
  } else {
    check(at === file.size, at, 'O5', `${file.size - at} bytes after DONE`);
  }
  checkDone(done, bodies.map(({ slabs }) => slabs), headers);
  bodies.forEach((body, i) => {
    const summary = done.fields.bodies[i];
    check(summary.numVertices === body.vertices, done.at, 'D6', `${body.vertices} vertices`);
    const expected = body.bounds.flat();
    check(isSame([...summary.minimum, ...summary.maximum], expected), done.at, 'D8',
      `bounds are ${expected}`);
  });
  return { header, head, bodies };
}

/** The head, and for each body [the slab that answers a slice], or [], and the body's last time. */
async function readSlabsAt(file, time) {
  const header = readFileHeader(file);
  if (!header.hasIndex) {
    const { head, bodies } = await readAll(file, (slab) =>
      (slab.record.timeBegin <= time && time <= slab.record.timeEnd ? slab : null));
    return {
      head,
      found: bodies.map(({ slabs, results }) => {
        const i = answering(slabs, time);
        return { slabs: i < 0 ? [] : [results[i]], last: slabs.at(-1).timeEnd };
      }),
    };
  }
  const { indx, done } = await readEnds(file);
  const { head } = indx;
  checkDone(done, indx.bodies, indx.headers);
  const chunkAt = (offset) => {
    const chunk = readChunk(file, offset);
    check(chunk.headerText === indx.headers.get(offset), offset, 'I2', 'another header');
    return chunk;
  };
  const parts = new Map();
  const part = (offset) => {
    if (indx.headers.has(offset) && !parts.has(offset)) {
      parts.set(offset, readPart(chunkAt(offset), head, part));
    }
    return parts.get(offset);
  };
  const found = indx.bodies.map((slabs) => {
    const record = slabs[answering(slabs, time)];
    const last = slabs.at(-1).timeEnd;
    if (!record) return { slabs: [], last };
    const slab = readSlab(chunkAt(record.at), head, part);
    checkRecord(record, slab.record, indx.at);
    return { slabs: [slab], last };
  });
  return { head, found };
}

/** The number of the slab that answers a slice, -1 where it is empty (X2). */
function answering(slabs, time) {
  const last = slabs.at(-1).timeEnd;
  const i = slabs.findIndex(({ timeEnd }) => timeEnd > time || (timeEnd === time && time === last));
  return i >= 0 && slabs[i].timeBegin <= time ? i : -1;
}

// Answers ----------------------------------------------------------------------------------------

const real = (value) => (Number.isFinite(value) ? value.toExponential(16) : String(value));

const boundsText = ([low, high]) =>
  (low[0] <= high[0] ? { min: low.map(real), max: high.map(real) } : { min: null, max: null });

const hex = (checksum) => checksum.toString(16).padStart(8, '0');

/** The bytes of rows of four numbers, each of `size` bytes and stored by a method of DataView. */
function bytesOfRows(rows, size, method) {
  const view = new DataView(new ArrayBuffer(rows.length * 4 * size));
  rows.forEach((row, i) =>
    row.forEach((number, k) => view[method]((4 * i + k) * size, number, true)));
  return new Uint8Array(view.buffer);
}

async function describe(file) {
  const checksums = []; // of vertices and of cells so far, by body
  const { header, head, bodies } = await readAll(file, (slab) => {
    const { body } = slab.record;
    const [vertices, cells] = checksums[body] ?? [0, 0];
    checksums[body] = [
      crc32c(bytesOfRows(slab.vertices, 8, 'setFloat64'), vertices),
      crc32c(bytesOfRows(slab.conn.cells, 4, 'setUint32'), cells),
    ];
    return describeSlab(slab);
  });
  return {
    version: `${header.versionMajor}.${header.versionMinor}`,
    features: head.features,
    bodies: bodies.map((body, i) => ({
      name: head.bodies[i],
      vertices: String(body.vertices),
      cells: String(body.slabs.reduce((sum, { numCells }) => sum + numCells, 0)),
      begin: real(body.slabs[0].timeBegin),
      end: real(body.slabs.at(-1).timeEnd),
      ...boundsText(body.bounds),
      hypervolume: real(body.results.reduce((sum, { hypervolume }) => sum + hypervolume, 0)),
      vertices_checksum: hex(checksums[i][0]),
      cells_checksum: hex(checksums[i][1]),
      slabs: body.results.map(({ description }) => description),
    })),
  };
}

function describeSlab({ record, conn, vertices, attributes }) {
  let hypervolume = 0;
  for (const cell of conn.cells) hypervolume += determinant4(...cell.map((i) => vertices[i])) / 24;
  const description = {
    begin: real(record.timeBegin),
    end: real(record.timeEnd),
    vertices: String(conn.numVertices),
    lower: String(conn.numLower),
    upper: String(conn.numUpper),
    means: String(conn.numMeans),
    cells: String(conn.cells.length),
    ...boundsText(widen(noBounds(4), vertices)),
    attributes: attributes.map(({ domain, name, type, components, bytes }) => ({
      domain,
      name,
      type: String(type),
      components: String(components),
      checksum: hex(crc32c(bytes)),
    })),
  };
  return { hypervolume, description };
}

const determinant3 = (a, b, c) =>
  a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) +
  a[2] * (b[0] * c[1] - b[1] * c[0]);

/** det[a, b, c, d], by the t of each. */
const determinant4 = (a, b, c, d) =>
  d[3] * determinant3(a, b, c) - c[3] * determinant3(a, b, d) +
  b[3] * determinant3(a, c, d) - a[3] * determinant3(b, c, d);

const units = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]];

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];

/** All p with normal . p = offset, and the axes of its slices. */
function hyperplane(normal, offset) {
  const unit = (vector) => vector.map((value) => value / Math.hypot(...vector));
  const along = normal.map(Math.abs);
  const steepest = along.indexOf(Math.max(...along));
  // Gram-Schmidt. The axes for x, y, z and t are the other three, in their order.
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
  return {
    normal,
    offset,
    axes,
    isTime: units[3].every((value, i) => value === normal[i]),
    isReversed: determinant4(...axes, normal) < 0,
  };
}

async function slice(file, plane) {
  const { head, found } =
    plane.isTime ? await readSlabsAt(file, plane.offset) : await readAllSlabs(file);
  return {
    bodies: found.map(({ slabs, last }, i) => ({
      name: head.bodies[i],
      ...measure(cut(slabs, plane, plane.offset === last)),
    })),
  };
}

async function readAllSlabs(file) {
  const { head, bodies } = await readAll(file, (slab) => slab);
  return { head, found: bodies.map(({ results }) => ({ slabs: results })) };
}

// A cell whose first vertices, as many as the key says, are above: the edges that are cut, so that
// they run counterclockwise seen from outside (X5), or clockwise where the hyperplane isReversed.
// The other cases are even permutations of these.
const cutEdges = { 1: ['01', '03', '02'], 2: ['12', '13', '03', '02'], 3: ['23', '13', '03'] };
const evenOrders = [
  '0123', '1032', '2301', '3210', '0231', '0312', '1203', '1320', '2013', '2130', '3021', '3102',
];

/** For each set of vertices above, as bits: the edges that are cut. */
const cutTable = Array.from({ length: 16 }, (_, mask) => {
  const isAbove = (i) => (mask >> i) & 1;
  const count = [0, 1, 2, 3].filter(isAbove).length;
  const order = evenOrders.find((each) => [...each].slice(0, count).every(isAbove));
  return (cutEdges[count] ?? []).map((edge) => [...edge].map((i) => Number(order[i])));
});

/** Marching tetrahedra: points by what they come from, and triangles of these. */
function cut(slabs, { normal, offset, axes, isReversed }, atLast) {
  const points = new Map();
  const triangles = [];
  let end = 0;
  for (const { conn, vertices } of slabs) {
    // Vertices are numbered through all slabs: those of a shared layer have one number (X3).
    const first = end - conn.numLower;
    end = first + conn.numVertices;
    const heights = vertices.map((vertex) => dot(normal, vertex));
    const above = heights.map((height) => (atLast ? height >= offset : height > offset)); // X1
    // The key of a cut, the same for both orders of its ends (X3): a vertex, or an edge.
    const place = (a, b) => {
      const on = [a, b].find((i) => heights[i] === offset);
      if (on !== undefined) {
        points.set(first + on, vertices[on]);
        return first + on;
      }
      const [i, k] = a < b ? [a, b] : [b, a];
      const key = `${first + i} ${first + k}`;
      const s = (offset - heights[i]) / (heights[k] - heights[i]);
      points.set(key, vertices[i].map((value, axis) => value + s * (vertices[k][axis] - value)));
      return key;
    };
    for (const cell of conn.cells) {
      const mask = cell.reduce((bits, i, k) => bits | (above[i] << k), 0);
      const corners = cutTable[mask].map(([i, k]) => place(cell[i], cell[k]));
      if (isReversed) corners.reverse();
      for (let i = 2; i < corners.length; ++i) {
        const triangle = [corners[0], corners[i - 1], corners[i]];
        if (new Set(triangle).size === 3) triangles.push(triangle); // X4
      }
    }
  }
  const inAxes = (key) => axes.map((axis) => dot(axis, points.get(key)));
  const used = new Set(triangles.flat());
  return { points: new Map([...used].map((key) => [key, inAxes(key)])), triangles };
}

function measure({ points, triangles }) {
  let volume = 0;
  let area = 0;
  for (const triangle of triangles) {
    const [a, b, c] = triangle.map((key) => points.get(key));
    volume += determinant3(a, b, c) / 6;
    const [u, v] = [b, c].map((point) => point.map((value, axis) => value - a[axis]));
    area += Math.hypot(u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2],
      u[0] * v[1] - u[1] * v[0]) / 2;
  }
  return {
    points: String(points.size),
    triangles: String(triangles.length),
    volume: real(volume),
    area: real(area),
    ...boundsText(widen(noBounds(3), points.values())),
  };
}

process.exitCode = await run({
  open: (path) => new File(path),
  describe,
  slice: (file, normal, offset) => slice(file, hyperplane(normal, offset)),
  Invalid,
});
