#!/usr/bin/env node
// Reads a .t4d file as the appendix "A reader under test" of t4d/formats/t4d/SPEC.md asks:
//
//     t4d_reader.mjs FILE describe     reads everything and checks every rule
//     t4d_reader.mjs FILE slice T      reads what the slice needs, no more if there is an index
//     t4d_reader.mjs FILE slice x C    slices by x = C, y = C or z = C; reads and checks everything
//     t4d_reader.mjs FILE slice A,B,C,D E      the same for A x + B y + C z + D t = E
//     t4d_reader.mjs --serve           answers such requests from standard input, one a line
//
// Prints one JSON object and exits with 0, or refuses the file, exits with 1 and says why on
// standard error. 2 is wrong usage. A mistake in this program exits with 70: Node's own 1 would
// look like a refusal.
//
// Bytes are taken apart by the parser that compile.mjs makes of t4d/formats/t4d/t4d.ksy, and by nothing
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
import { createInterface } from 'node:readline';

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

function crc32c(bytes) {
  let crc = 0xffffffff;
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

/** What a payload breaks that ends too early. */
const endRules = { HEAD: 'M3', CONN: 'N11', LAYR: 'L4', SLAB: 'S9', DONE: 'D4', INDX: 'I1' };

/** The chunk at this offset, whole and with right checksums: {at, type, size, payload}. */
function readChunk(file, at) {
  const headerBytes = file.read(at, 24, 'C3');
  const header = parse(T4d.ChunkHeader, headerBytes, at, 'C3');
  const type = header.type.text;
  const size = header.lenChunk;
  check(at + size <= file.size, at + 8, 'C3', `${header.lenPayload} bytes are not there`);
  const headerSum = crc32c(headerBytes.subarray(0, 20));
  check(header.headerChecksum === headerSum, at + 20, 'C4', 'header checksum');
  check(type !== 'HEAD' || header.lenPayload <= 16 << 20, at + 8, 'M1', 'HEAD above 16 MiB');
  const bytes = file.read(at, size, 'C3');
  const payload = bytes.subarray(24, 24 + header.lenPayload);
  check(header.payloadChecksum === crc32c(payload), at + 16, 'C5', 'payload checksum');
  check(header.isKnown || !header.isCritical, at, 'C8', `unknown critical chunk ${type}`);
  return { at, type, size, payload: parse(T4d.Chunk, bytes, at, endRules[type] ?? 'C3').payload };
}

// HEAD -------------------------------------------------------------------------------------------

const knownFeatures = ['zstd', 'means'];

function readHead({ at, payload }) {
  at += 24;
  const json = text(payload.json, at, 'M2');
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
  const bodies = strings('bodies', 'M7');
  check(bodies.length >= 1 && bodies.length <= 65536, at, 'M7', `${bodies.length} bodies`);
  for (const name of bodies) {
    const bytes = Buffer.from(name);
    check(bytes.length >= 1 && bytes.length <= 255, at, 'M8', 'length of a name');
    check(bytes.toString() === name, at, 'M8', 'a surrogate without a partner has no UTF-8');
  }
  check(new Set(bodies).size === bodies.length, at, 'M9', 'two bodies of one name');
  for (const name of ['generator', 'backend', 'length_unit', 'time_unit', 'up']) {
    check(['string', 'undefined'].includes(typeof member(name)), at, 'M10', `type of ${name}`);
  }
  check(['y', 'z', undefined].includes(member('up')), at, 'M10', 'up is neither y nor z');
  const details = member('details');
  check(details === undefined || (isObject(details) && !Array.isArray(details)), at, 'M10',
    'type of details');
  return { features, bodies };
}

// Arrays -----------------------------------------------------------------------------------------

let zstd = null;

/** Loads the decompressor, for files that name the feature. */
async function prepareZstd() {
  const { ZSTDDecoder } = await import('zstddec');
  const { ZstdFrame } = require('./ZstdFrame.cjs');
  // Where there is fetch(), the package loads itself through it, which takes 30 ms.
  globalThis.fetch = undefined;
  const decoder = new ZSTDDecoder();
  await decoder.init();
  zstd = { decoder, ZstdFrame };
}

const maxArray = 2 ** 28;

/** The bytes of an array record, row after row. */
function bytesOf(record, at, features) {
  if (record.codec === T4d.Codec.RAW) return record._raw_stored;
  check(features.includes('zstd'), at, 'A13', 'HEAD does not name the feature zstd');
  const frame = parse(zstd.ZstdFrame, record.stored, at, 'A10');
  const size = record.numRows * record.lenRow;
  check(frame.hasContentSize && frame.contentSize === size, at, 'A11', `not ${size} bytes`);
  check(size <= maxArray, at, 'A9', `not enough memory here for an array of ${size} bytes`);
  const content = zstd.decoder.decode(record.stored, size);
  check(content.length === size, at, 'A12', 'the frame does not decompress');
  const bytes = new Uint8Array(size);
  for (let byte = 0, from = 0; byte < record.lenRow; ++byte) {
    for (let to = byte; to < size; to += record.lenRow) bytes[to] = content[from++];
  }
  return bytes;
}

function numbersOf(record, at, features) {
  const stream = new KaitaiStream(bytesOf(record, at, features));
  const count = record.numRows * record.numComponents;
  return new T4d.Scalars(stream, null, null, record.scalarType, count).values;
}

function readAttributes(attributes, at, features) {
  return attributes.map(({ domain, nameBytes, values }) => ({
    domain: domain === T4d.Domain.VERTEX ? 'vertex' : 'cell',
    name: text(nameBytes, at, 'T4'),
    rows: values.numRows,
    type: values.scalarType,
    components: values.numComponents,
    bytes: bytesOf(values, at, features),
  }));
}

function checkAttributes(attributes, conn, at) {
  const seen = new Set();
  for (const { domain, name, rows } of attributes) {
    const expected = domain === 'vertex' ? conn.numVertices : conn.numCells;
    check(rows === expected, at, 'T6', `attribute ${name}: ${rows} rows, not ${expected}`);
    check(!seen.has(domain + name), at, 'T7', `attribute ${name} again`);
    seen.add(domain + name);
  }
}

// Parts and slabs --------------------------------------------------------------------------------

function readConn({ at, payload }, features) {
  const { numVertices, numLower, numUpper, numMeans, numStored } = payload;
  const numCells = payload.cells.numRows;
  const indices = numbersOf(payload.cells, at, features);
  const cells = [];
  for (let i = 0; i < indices.length; i += 4) {
    const [a, b, c, d] = indices.slice(i, i + 4);
    check(Math.max(a, b, c, d) < numVertices, at, 'N4', `index in cell ${i / 4}`);
    check(a !== b && a !== c && a !== d && b !== c && b !== d && c !== d, at, 'N5',
      `cell ${i / 4} has a vertex twice`);
    cells.push([a, b, c, d]);
  }
  const sources = [];
  if (numMeans > 0) {
    check(features.includes('means'), at, 'N12', 'HEAD does not name the feature means');
    const sizes = numbersOf(payload.meanSizes, at, features);
    const numbers = numbersOf(payload.meanSources, at, features);
    check(!sizes.includes(0), at, 'N7', 'a mean of nothing');
    const total = sizes.reduce((sum, size) => sum + size, 0);
    check(total === numbers.length, at, 'N8', `${numbers.length} sources, the sizes say ${total}`);
    const end = numVertices - numUpper;
    check(numbers.every((i) => i < end - numMeans || (i >= end && i < numVertices)), at, 'N9',
      'a source is a mean, or no vertex');
    let first = 0;
    for (const size of sizes) sources.push(numbers.slice(first, (first += size)));
  }
  const attributes = readAttributes(payload.attributes, at, features);
  const conn = {
    kind: 'CONN', numVertices, numLower, numUpper, numMeans, numStored, numCells, cells, sources,
    attributes,
  };
  checkAttributes(attributes, conn, at);
  return conn;
}

function readLayr({ at, payload }, features) {
  const points = pointsOf(numbersOf(payload.positions, at, features), () => payload.time);
  return { kind: 'LAYR', time: payload.time, points };
}

/** Points [x, y, z, t]. */
function pointsOf(positions, timeOf) {
  const points = [];
  for (let i = 0; i < positions.length; i += 3) {
    points.push([positions[i], positions[i + 1], positions[i + 2], timeOf(i / 3)]);
  }
  return points;
}

const readPart = (chunk, features) =>
  ({ CONN: readConn, LAYR: readLayr })[chunk.type]?.(chunk, features);

/** A slab as its chunk says; `fields` are those that INDX repeats. */
function readSlab({ at, size, payload }, head) {
  check(payload.body < head.bodies.length, at, 'S4', `body ${payload.body}`);
  const times = numbersOf(payload.times, at, head.features);
  return {
    at,
    size,
    fields: fieldsOf(payload),
    interior: pointsOf(numbersOf(payload.positions, at, head.features), (i) => times[i]),
    attributes: readAttributes(payload.attributes, at, head.features),
  };
}

const fieldsOf = ({ timeBegin, timeEnd, ofsConnectivity, ofsLower, ofsUpper, body }) =>
  ({ timeBegin, timeEnd, ofsConnectivity, ofsLower, ofsUpper, body });

/** Puts a slab together; part(offset) is a part, or undefined. */
function assemble({ at, fields, interior, attributes }, part) {
  const find = (offset, kind, rule) => {
    const found = offset >= 24 && offset < at ? part(offset) : undefined;
    check(found?.kind === kind, at, rule, `no ${kind} at ${offset}, before the slab`);
    return found;
  };
  const { timeBegin, timeEnd, ofsConnectivity, ofsLower, ofsUpper } = fields;
  const conn = find(ofsConnectivity, 'CONN', 'S2');
  const layer = (offset, rows, time) => {
    const { points, time: found } =
      offset === 0 ? { points: [], time } : find(offset, 'LAYR', 'S3');
    check(points.length === rows, at, 'P1', `layer of ${points.length} vertices, not ${rows}`);
    check(found === time, at, 'P3', `layer at ${found}, not ${time}`);
    return points;
  };
  const lower = layer(ofsLower, conn.numLower, timeBegin);
  const upper = layer(ofsUpper, conn.numUpper, timeEnd);
  check(interior.length === conn.numStored, at, 'P1',
    `${interior.length} interior vertices, not ${conn.numStored}`);
  const known = [...lower, ...interior, ...new Array(conn.numMeans), ...upper];
  const means = conn.sources.map((sources) => mean(sources.map((i) => known[i])));
  const vertices = [...lower, ...interior, ...means, ...upper];
  check(vertices.every((point) => point.every(Number.isFinite)), at, 'P2', 'not all are finite');
  check([...interior, ...means].every(([, , , t]) => t >= timeBegin && t <= timeEnd), at, 'P4',
    'an interior vertex outside the times of the slab');
  const all = [...conn.attributes, ...attributes];
  checkAttributes(all, conn, at);
  return { fields, conn, vertices, stored: [...lower, ...interior, ...upper], attributes: all };
}

function mean(points) {
  const sum = [...points[0]];
  for (const point of points.slice(1)) {
    for (let i = 0; i < 4; ++i) sum[i] += point[i];
  }
  return sum.map((value) => value / points.length);
}

/** Both slabs are of one body, one after the other. */
function checkFollows(before, slab, at) {
  check(slab.ofsLower === before.ofsUpper, at, 'S7', 'lower is not upper of the slab before');
  check(slab.ofsLower === 0 ? slab.timeBegin >= before.timeEnd : slab.timeBegin === before.timeEnd,
    at, 'S8', `begins at ${slab.timeBegin}, the slab before ends at ${before.timeEnd}`);
}

// Whole files ------------------------------------------------------------------------------------

function checkSlabs(summary, slabs, at) {
  check(summary.numSlabs === slabs.length, at, 'D5', `${slabs.length} slabs are there`);
  check(summary.timeBegin === slabs[0].timeBegin && summary.timeEnd === slabs.at(-1).timeEnd, at,
    'D7', 'times of a body');
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

/** Reads a file from the front and checks all of it; use(slab) makes of each slab what is kept. */
async function readAll(file, use) {
  const header = readFileHeader(file);
  const footer = header.hasIndex ? readFooter(file) : null;
  const end = header.hasIndex ? file.size - footerSize : file.size;
  const parts = new Map();
  const unused = new Set();
  const places = [];
  let head = null;
  let done = null;
  let indx = null;
  let bodies = [];
  let at = 24;
  for (let count = 0; !done || (header.hasIndex && !indx); ++count) {
    check(at < end, at, done ? 'O4' : head ? 'O3' : 'O1',
      `the chunks end without ${done ? 'INDX' : head ? 'DONE' : 'HEAD'}`);
    const chunk = readChunk(file, at);
    check(head || chunk.type === 'HEAD', at, 'O1', `the first chunk is ${chunk.type}`);
    check(!done || chunk.type === 'INDX', at, 'O4', `${chunk.type} after DONE`);
    if (chunk.type === 'HEAD') {
      check(!head, at, 'O2', 'HEAD again');
      head = readHead(chunk);
      if (head.features.includes('zstd')) await prepareZstd();
      bodies = head.bodies.map(() => ({
        slabs: [], results: [], vertices: 0, cells: 0,
        bounds: noBounds(3), storedBounds: noBounds(3),
      }));
    } else if (chunk.type === 'CONN' || chunk.type === 'LAYR') {
      parts.set(at, readPart(chunk, head.features));
      unused.add(at);
    } else if (chunk.type === 'SLAB') {
      const slab = assemble(readSlab(chunk, head), (offset) => parts.get(offset));
      const { fields, conn } = slab;
      unused.delete(fields.ofsConnectivity);
      unused.delete(fields.ofsLower);
      unused.delete(fields.ofsUpper);
      const body = bodies[fields.body];
      if (body.slabs.length > 0) {
        checkFollows(body.slabs.at(-1), fields, at);
        body.vertices -= conn.numLower;
      }
      body.slabs.push(fields);
      body.vertices += conn.numVertices;
      body.cells += conn.numCells;
      widen(body.bounds, slab.vertices);
      widen(body.storedBounds, slab.stored);
      body.results.push(use(slab));
      places.push({ at, size: chunk.size, fields });
    } else if (chunk.type === 'DONE') {
      done = chunk;
      check(done.payload.numChunks === count, at, 'D1', `${count} chunks are there`);
      check(done.payload.numBodies === bodies.length, at, 'D2', `HEAD names ${bodies.length}`);
      check(!footer || footer.ofsDone === at, end + 8, 'F5', `DONE is at ${at}`);
    } else if (chunk.type === 'INDX') {
      check(done, at, header.hasIndex ? 'O4' : 'O5', 'INDX not after DONE');
      check(footer.ofsIndex === at, end, 'F4', `INDX is at ${at}`);
      indx = chunk;
    }
    at += chunk.size;
  }
  check(at === end, at, header.hasIndex ? 'O4' : 'O5', `${end - at} bytes after the last chunk`);
  for (const offset of unused) check(false, offset, 'O6', 'no slab names this part');
  bodies.forEach((body, i) => {
    const summary = done.payload.bodies[i];
    check(body.slabs.length > 0, done.at, 'D5', `body ${i} has no slab`);
    checkSlabs(summary, body.slabs, done.at);
    check(summary.numVertices === body.vertices && summary.numCells === body.cells, done.at, 'D6',
      `${body.vertices} vertices and ${body.cells} cells are there`);
    const expected = body.storedBounds.flat();
    check([...summary.minimum, ...summary.maximum].every((value, k) => value === expected[k]),
      done.at, 'D8', `bounds are ${expected}`);
  });
  if (indx) {
    const { numSlabs } = indx.payload;
    check(numSlabs === places.length, indx.at, 'I1', `there are ${places.length} slabs`);
    places.forEach((place, i) => checkRecord(indx.payload.slabs[i], place, indx.at + 32 + 64 * i));
  }
  return { header, head, bodies };
}

function checkRecord(record, { at: offset, size, fields }, at) {
  check(record.ofsSlab === offset && record.lenSlab === size, at, 'I2', `the slab is at ${offset}`);
  for (const [name, value] of Object.entries(fields)) {
    check(record[name] === value, at + 16, 'I3', `${name} is ${value} in the slab`);
  }
}

/** The head, and for each body [the slab that answers a slice], or [], and the body's last time. */
async function readSlabsAt(file, time) {
  const header = readFileHeader(file);
  if (!header.hasIndex) {
    const { head, bodies } = await readAll(file, (slab) =>
      (slab.fields.timeBegin <= time && time <= slab.fields.timeEnd ? slab : null));
    return {
      head,
      found: bodies.map(({ slabs, results }) => {
        const i = answering(slabs, time);
        return { slabs: i < 0 ? [] : [results[i]], last: slabs.at(-1).timeEnd };
      }),
    };
  }
  const chunkOf = (at, type, rule) => {
    const chunk = readChunk(file, at);
    check(chunk.type === type, at, rule, `${chunk.type} instead of ${type}`);
    return chunk;
  };
  const footer = readFooter(file);
  const head = readHead(chunkOf(24, 'HEAD', 'O1'));
  if (head.features.includes('zstd')) await prepareZstd();
  const done = chunkOf(footer.ofsDone, 'DONE', 'F5');
  const indx = chunkOf(footer.ofsIndex, 'INDX', 'F4');
  check(done.at + done.size === indx.at, indx.at, 'O4', 'INDX does not follow DONE');
  check(indx.at + indx.size === file.size - footerSize, indx.at, 'O4', 'no footer after INDX');
  const count = head.bodies.length;
  check(done.payload.numBodies === count, done.at, 'D2', `HEAD names ${count}`);
  const bodies = head.bodies.map(() => []);
  indx.payload.slabs.forEach((record, i) => {
    const at = indx.at + 32 + 64 * i;
    check(record.body < bodies.length, at + 56, 'I3', `body ${record.body}`);
    const body = bodies[record.body];
    if (body.length > 0) checkFollows(body.at(-1), record, at);
    body.push(Object.assign(record, { at }));
  });
  const parts = new Map();
  const part = (offset) => {
    if (!parts.has(offset)) parts.set(offset, readPart(readChunk(file, offset), head.features));
    return parts.get(offset);
  };
  const found = bodies.map((slabs, i) => {
    check(slabs.length > 0, done.at, 'D5', `body ${i} has no slab`);
    checkSlabs(done.payload.bodies[i], slabs, done.at);
    const record = slabs[answering(slabs, time)];
    const last = slabs.at(-1).timeEnd;
    if (!record) return { slabs: [], last };
    const slab = readSlab(chunkOf(record.ofsSlab, 'SLAB', 'I2'), head);
    checkRecord(record, slab, record.at);
    return { slabs: [assemble(slab, part)], last };
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

async function describe(file) {
  const { header, head, bodies } = await readAll(file, describeSlab);
  return {
    version: `${header.versionMajor}.${header.versionMinor}`,
    features: head.features,
    bodies: bodies.map((body, i) => ({
      name: head.bodies[i],
      vertices: String(body.vertices),
      cells: String(body.cells),
      begin: real(body.slabs[0].timeBegin),
      end: real(body.slabs.at(-1).timeEnd),
      ...boundsText(body.bounds),
      hypervolume: real(body.results.reduce((sum, { hypervolume }) => sum + hypervolume, 0)),
      slabs: body.results.map(({ description }) => description),
    })),
  };
}

function describeSlab({ fields, conn, vertices, attributes }) {
  let hypervolume = 0;
  for (const cell of conn.cells) hypervolume += determinant4(...cell.map((i) => vertices[i])) / 24;
  const description = {
    begin: real(fields.timeBegin),
    end: real(fields.timeEnd),
    vertices: String(conn.numVertices),
    lower: String(conn.numLower),
    upper: String(conn.numUpper),
    means: String(conn.numMeans),
    cells: String(conn.numCells),
    ...boundsText(widen(noBounds(4), vertices)),
    attributes: attributes.map(({ domain, name, type, components, bytes }) => ({
      domain,
      name,
      type: String(type),
      components: String(components),
      checksum: crc32c(bytes).toString(16).padStart(8, '0'),
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

/** ['describe'] or ['slice', a hyperplane], or null. */
function requestOf([verb, ...rest]) {
  if (verb === 'describe' && rest.length === 0) return [verb];
  if (verb !== 'slice' || rest.length < 1 || rest.length > 2) return null;
  const numberOf = (word) => (word.trim() ? Number(word) : NaN);
  const numbersOfNormal = (word) =>
    units[['x', 'y', 'z'].indexOf(word)] ?? word.split(',').map(numberOf);
  const normal = rest.length === 1 ? units[3] : numbersOfNormal(rest[0]);
  const offset = numberOf(rest.at(-1));
  const isKnown = normal.length === 4 && normal.some((value) => value !== 0) &&
    [...normal, offset].every(Number.isFinite);
  return isKnown ? [verb, hyperplane(normal, offset)] : null;
}

/** { answer }, { refusal } or { mistake }. */
async function respond(path, [verb, plane]) {
  let file;
  try {
    file = new File(path);
    return { answer: verb === 'slice' ? await slice(file, plane) : await describe(file) };
  } catch (error) {
    const isRefusal = error instanceof Invalid || error.syscall !== undefined;
    return isRefusal ? { refusal: `${path}: ${error.message}` } : { mistake: error };
  } finally {
    file?.close();
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
    console.error('usage: t4d_reader.mjs FILE describe | FILE slice T | FILE slice x|y|z C | ' +
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
