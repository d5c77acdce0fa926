import { arrayRecord, f64Type, u32Type, valuesOf } from './array.js';
import {
  directoryEntryBytes, Fields, fileHeaderBytes, footerBytes, isEndSignature, isSame, parseChunk,
  parseChunkHeader, parseFileHeader, parseFooter, readFileHeader,
} from './chunk.js';
import { crc32c } from './crc32c.js';
import { parseHead } from './head.js';
import { check, Invalid } from './invalid.js';
import { isManifest, openManifest } from './parted.js';
import { assembled, noBounds, parseConn, parseLayr, parsePose, parseSlab, posed, widen } from './parts.js';
import { cut, hyperplane } from './slice.js';
import { blobSource, bytesSource, httpSource } from './source.js';
import { prepareZstd } from './zstd.js';

/**
 * @typedef {object} SlabRecord what the index says of a slab
 * @property {number} at offset
 * @property {number} begin
 * @property {number} end
 * @property {number} connectivity offset of its CONN
 * @property {number} lower offset of its lower layer, 0 for none
 * @property {number} upper offset of its upper layer, 0 for none
 * @property {number} body
 * @property {number} numCells
 * @property {number[]} min x, y, z
 * @property {number[]} max x, y, z
 */

/** Maximum bytes of decoded parts to keep, and of slabs; the most recently used are kept. */
const cacheBytes = 256 * 1024 * 1024;

/** Number of slabs to request at once for a slice across time. */
const slabsAhead = 16;

/** Slabs that follow one another are fetched together, up to this size in the file. */
const runBytes = 4 * 1024 * 1024;

/** Two ranges are fetched as one if there are at most as many bytes between them, and no more than they have. */
const smallGap = 16 * 1024;

const parsers = { CONN: parseConn, LAYR: parseLayr, POSE: parsePose, SLAB: parseSlab };

const bytesOfPart = ({ cells, positions }) => (cells ?? positions)?.byteLength ?? 1024;
const bytesOfSlab = ({ vertices }) => vertices.byteLength;

const isLayr = (bytes) => String.fromCharCode(...bytes.subarray(0, 4)) === 'LAYR';

/** Parses the summary of each body in DONE. */
function parseDone(chunk) {
  const fields = new Fields(chunk, 'D4');
  const numChunks = fields.u64();
  const numBodies = fields.u32();
  fields.zeros(4, 'D3');
  const bodies = [];
  for (let i = 0; i < numBodies; ++i) {
    bodies.push({
      numSlabs: fields.u64(), numVertices: fields.u64(), numCells: fields.u64(), begin: fields.f64(),
      end: fields.f64(), min: [...fields.f64s(3)], max: [...fields.f64s(3)],
    });
  }
  fields.finish();
  return { at: chunk.at, numChunks, bodies };
}

/**
 * What INDX says: the copies of file header and HEAD, the headers of chunks by offset, a record for each
 * slab, and the records of each body.
 */
async function parseIndx(chunk) {
  const { at } = chunk;
  const fields = new Fields(chunk, 'I8');
  const fileHeader = fields.take(20);
  const { version } = parseFileHeader(fileHeader, at).checkRest();
  const numSlabs = fields.u32();
  const isOf = (record, type, components) =>
    check(record.type === type && record.components === components, at, 'I7', 'type of an array of INDX');
  const headRecord = arrayRecord(fields);
  isOf(headRecord, 1, 1);
  check(headRecord.codec === 0, at, 'I7', 'codec of head');
  const columns = [[1, directoryEntryBytes], [f64Type, 2], [7, 3], [u32Type, 1], [7, 1], [f64Type, 6]]
    .map(([type, components]) => {
      const record = arrayRecord(fields);
      isOf(record, type, components);
      return record;
    });
  fields.finish();
  check(columns.slice(1).every(({ rows }) => rows === numSlabs), at, 'I3', 'rows of the arrays of INDX');
  const headBytes = valuesOf(headRecord, at, []);
  const head = parseHead(headBytes, at);
  if (head.features.includes('zstd')) await prepareZstd();
  const [directory, times, parts, numbers, cells, bounds] =
    columns.map((record) => valuesOf(record, at, head.features));

  const headers = new Map();
  const slabs = [];
  let end = fileHeaderBytes;
  for (let i = 0; i < directory.length; i += directoryEntryBytes) {
    const bytes = directory.subarray(i, i + directoryEntryBytes);
    const header = parseChunkHeader(bytes, end);
    if (i === 0) {
      check(header.type === 'HEAD' && header.length === headBytes.length &&
        header.frontChecksum === crc32c(headBytes), at, 'I1', 'another HEAD');
    }
    headers.set(end, header);
    if (header.type === 'SLAB') slabs.push(end);
    end += header.size;
  }
  check(slabs.length === numSlabs, at, 'I3', `${slabs.length} slabs are there`);
  const offset = (place, distance) => (distance === 0n ? 0 : place - Number(distance));
  const records = slabs.map((place, i) => ({
    at: place, begin: times[2 * i], end: times[2 * i + 1], connectivity: offset(place, parts[3 * i]),
    lower: offset(place, parts[3 * i + 1]), upper: offset(place, parts[3 * i + 2]), body: numbers[i],
    numCells: Number(cells[i]), min: [...bounds.subarray(6 * i, 6 * i + 3)],
    max: [...bounds.subarray(6 * i + 3, 6 * i + 6)],
  }));
  const bodies = head.bodies.map(() => []);
  for (const record of records) {
    check(record.body < bodies.length, at, 'I4', `body ${record.body}`);
    bodies[record.body].push(record);
  }
  return { at, fileHeader, version, head, headBytes, headers, end, records, bodies };
}

/** Checks DONE as far as that is possible without the slabs. */
function checkDone(done, bodies, headers) {
  const { at } = done;
  check(done.bodies.length === bodies.length, at, 'D2', `HEAD names ${bodies.length}`);
  check(done.numChunks === headers.size - 1, at, 'D1', `${headers.size - 1} chunks are there`);
  const isCopy = (layer, other) => {
    const [one, two] = [headers.get(layer), headers.get(other)];
    return one !== undefined && two !== undefined && isLayr(one.bytes) && isSame(one.bytes, two.bytes);
  };
  bodies.forEach((slabs, i) => {
    const said = done.bodies[i];
    check(said.numSlabs === slabs.length && slabs.length > 0, at, 'D5', `body ${i} has ${slabs.length} slabs`);
    let before = null;
    let numCells = 0;
    for (const slab of slabs) {
      numCells += slab.numCells;
      if (before) {
        check(slab.lower === before.upper || isCopy(slab.lower, before.upper), slab.at, 'S7',
          'lower is not upper of the slab before');
        check(slab.lower === 0 ? slab.begin >= before.end : slab.begin === before.end, slab.at, 'S8',
          `begins at ${slab.begin}, the slab before ends at ${before.end}`);
      }
      before = slab;
    }
    check(said.begin === slabs[0].begin && said.end === slabs.at(-1).end, at, 'D7', 'times of a body');
    check(said.numCells === numCells, at, 'D6', `${numCells} cells are there`);
  });
}

const recordOf = (slab) => {
  const { at, begin, end, connectivity, lower, upper, body, cells, min, max } = slab;
  return {
    at, begin, end, connectivity, lower, upper, body, numCells: cells.length / 4,
    min: min.slice(0, 3), max: max.slice(0, 3),
  };
};

/** Checks what INDX says of a slab. */
function checkRecord(said, found, at) {
  for (const [name, value] of Object.entries(found)) {
    if (name === 'min' || name === 'max') {
      check(isSame(said[name], value), at, 'I6', `${name} is ${value}`);
    } else {
      check(said[name] === value, at, name === 'numCells' ? 'I5' : 'I4', `${name} is ${value}`);
    }
  }
}

/**
 * The number of the slab that answers a slice at a time, -1 where it is empty (X2).
 * @param {SlabRecord[]} slabs of one body
 */
export function answering(slabs, time) {
  const last = slabs.at(-1).end;
  let low = 0;
  let high = slabs.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    const { end } = slabs[middle];
    if (end > time || (end === time && time === last)) high = middle;
    else low = middle + 1;
  }
  return low < slabs.length && slabs[low].begin <= time ? low : -1;
}

/** The offsets of CONNs, LAYRs and POSEs so far, of which the last ones may be named (K6, S12). */
class Window {
  constructor() {
    this.places = { CONN: [], LAYR: [], POSE: [] };
  }

  has(type, offset, numBodies) {
    const places = this.places[type] ?? [];
    const i = places.lastIndexOf(offset);
    return i >= 0 && i >= places.length - 16 * numBodies;
  }

  /** Checks a slab; `before` is that of the same body before it. */
  check(slab, before, numBodies) {
    const { at, connectivity, lower, upper } = slab;
    const hasLayer = (layer) =>
      layer === 0 || this.has('LAYR', layer, numBodies) || this.has('POSE', layer, numBodies);
    check(this.has('CONN', connectivity, numBodies) && hasLayer(upper) && (before?.upper === lower || hasLayer(lower)),
      at, 'S12', 'a part is far back');
  }
}

/** Checks S12 by the headers that INDX has. */
function checkParts({ headers, records, bodies }) {
  const window = new Window();
  const before = new Map();
  let i = 0;
  for (const [offset, { type }] of headers) {
    window.places[type]?.push(offset);
    if (type !== 'SLAB') continue;
    const slab = records[i++];
    window.check(slab, before.get(slab.body), bodies.length);
    before.set(slab.body, slab);
  }
}

/** Reads and checks a file from its front, in the memory of some slabs. */
class Scan {
  constructor() {
    this.headers = new Map();
    this.parts = new Map();
    this.records = [];
    this.unused = new Set();
    this.window = new Window();
  }

  /** Forgets the parts that nothing may name any more. */
  forget(type) {
    const offset = this.window.places[type].at(-1 - 16 * this.bodies.length);
    if (offset !== undefined && !this.bodies.some(({ slabs }) => slabs.at(-1)?.upper === offset)) {
      this.parts.delete(offset);
    }
  }

  takePart(chunk) {
    const { at, type } = chunk;
    let part = parsers[type](chunk, this.head);
    if (type === 'POSE') {
      const layr = this.parts.get(part.layer);
      this.unused.delete(part.layer);
      part = posed(part, layr);
      check(this.window.has('LAYR', part.layer, this.bodies.length), at, 'K6', 'a LAYR far back');
    }
    this.window.places[type].push(at);
    this.parts.set(at, part);
    this.unused.add(at);
    this.forget(type);
  }

  takeSlab(chunk, use) {
    const parsed = parseSlab(chunk, this.head);
    const { connectivity, lower, upper } = parsed;
    const slab = assembled(parsed, this.parts.get(connectivity), this.parts.get(lower), this.parts.get(upper));
    for (const offset of [connectivity, lower, upper]) this.unused.delete(offset);
    const body = this.bodies[slab.body];
    this.window.check(parsed, body.slabs.at(-1), this.bodies.length);
    body.vertices += slab.numVertices - (body.slabs.length > 0 ? slab.numLower : 0);
    const record = recordOf(slab);
    body.slabs.push(record);
    this.records.push(record);
    widen(body, slab.vertices);
    use(slab);
  }

  /**
   * @param source
   * @param {(slab: import('./parts.js').Slab) => void} use called for each slab, in the order of the file
   */
  async run(source, use) {
    const header = readFileHeader(await source.read(0, fileHeaderBytes));
    const ends = header.hasIndex ? await readEnds(source) : null;
    let at = fileHeaderBytes;
    let done = null;
    while (!done) {
      check(at < source.size, at, 'O3', 'the chunks end without DONE');
      const chunk = await readChunk(source, at);
      const { type } = chunk;
      check(this.head || type === 'HEAD', at, 'O1', `the first chunk is ${type}`);
      if (type !== 'INDX') this.headers.set(at, { type, bytes: chunk.header, size: chunk.size });
      if (type === 'HEAD') {
        check(!this.head, at, 'O2', 'HEAD again');
        this.headBytes = chunk.fields;
        this.head = parseHead(chunk.fields, at);
        if (this.head.features.includes('zstd')) await prepareZstd();
        this.bodies = this.head.bodies.map(() => ({ slabs: [], vertices: 0, ...noBounds(3) }));
      } else if (type === 'SLAB') {
        this.takeSlab(chunk, use);
      } else if (type === 'DONE') {
        done = parseDone(chunk);
      } else if (this.window.places[type]) {
        this.takePart(chunk);
      } else {
        check(type !== 'INDX', at, header.hasIndex ? 'O4' : 'O5', 'INDX before DONE');
      }
      at += chunk.size;
    }
    for (const offset of this.unused) check(false, offset, 'O6', 'no slab names this part');
    if (ends) {
      const { indx } = ends;
      check(isSame(indx.fileHeader, await source.read(0, 20)), indx.at, 'I1', 'another file header');
      check(isSame(this.headBytes, indx.headBytes), indx.at, 'I1', 'another HEAD');
      check(done.at === ends.done.at, done.at, 'O3', 'DONE, and again');
      check(this.headers.size === indx.headers.size && [...this.headers].every(([offset, { bytes }]) =>
        isSame(bytes, indx.headers.get(offset)?.bytes ?? [])), indx.at, 'I2', 'other headers of chunks');
      this.records.forEach((record, i) => checkRecord(indx.records[i], record, indx.at));
    } else {
      check(at === source.size, at, 'O5', `${source.size - at} bytes after DONE`);
    }
    checkDone(done, this.bodies.map(({ slabs }) => slabs), this.headers);
    this.bodies.forEach(({ vertices, min, max }, i) => {
      const summary = done.bodies[i];
      check(summary.numVertices === vertices, done.at, 'D6', `${vertices} vertices`);
      check(isSame([...summary.min, ...summary.max], [...min, ...max]), done.at, 'D8', `bounds are ${min}, ${max}`);
    });
    return { version: header.version, head: this.head, headers: this.headers, bodies: this.bodies, done };
  }
}

async function readChunk(source, at) {
  check(at + 32 <= source.size, at, 'C3', 'a chunk header is cut off');
  const header = await source.read(at, 32);
  check(crc32c(header.subarray(0, 28)) === new DataView(header.buffer, header.byteOffset).getUint32(28, true),
    at + 28, 'C4', 'header checksum');
  const { type, size, length } = parseChunkHeader(header.subarray(0, 28), at);
  check(type !== 'HEAD' || length <= 16 << 20, at + 8, 'M1', 'HEAD above 16 MiB');
  check(at + size <= source.size, at + 8, 'C3', `${length} bytes are not there`);
  return parseChunk(await source.read(at, size), at);
}

/** INDX and DONE, by the footer. */
async function readEnds(source) {
  const footerAt = source.size - footerBytes;
  check(footerAt >= fileHeaderBytes, fileHeaderBytes, 'F1', 'no room for the footer');
  const footer = parseFooter(await source.read(footerAt, footerBytes), footerAt);
  const chunkOf = async (at, type, rule) => {
    const chunk = await readChunk(source, at);
    check(chunk.type === type, at, rule, `${chunk.type} instead of ${type}`);
    return chunk;
  };
  check(footer.done >= fileHeaderBytes && footer.done < footer.index && footer.index < footerAt, footerAt,
    'F4', 'offsets of the footer');
  if (source.size - source.tail.length > footer.done) {
    // One request for all of it.
    source.tail = await source.read(footer.done, source.size - footer.done - source.tail.length)
      .then((bytes) => joinedBytes(bytes, source.tail));
  }
  const index = await chunkOf(footer.index, 'INDX', 'F4');
  check(index.checksum === footer.indexChecksum, footerAt + 24, 'F6', 'not the checksum of INDX');
  const end = await chunkOf(footer.done, 'DONE', 'F5');
  check(end.at + end.size === index.at, index.at, 'O4', 'INDX does not follow DONE');
  check(index.at + index.size === footerAt, index.at, 'O4', 'no footer after INDX');
  const indx = await parseIndx(index);
  check(isSame(indx.headers.get(end.at)?.bytes ?? [], end.header) && indx.end === index.at, index.at, 'I2',
    `DONE at ${end.at} is not the last of the chunks`);
  return { indx, done: parseDone(end) };
}

function joinedBytes(one, two) {
  const bytes = new Uint8Array(one.length + two.length);
  bytes.set(one);
  bytes.set(two, one.length);
  return bytes;
}

/** Promises by key; the least recently used are forgotten beyond a number of bytes, failed ones at once. */
class Cache {
  constructor(limit) {
    Object.assign(this, { limit, bytes: 0, entries: new Map() });
  }

  get(key) {
    const entry = this.entries.get(key);
    if (!entry) return undefined;
    this.entries.delete(key);
    this.entries.set(key, entry);
    return entry.promise;
  }

  /** @param {(value: any) => number} bytesOf what the promised value takes */
  set(key, promise, bytesOf) {
    const entry = { promise, bytes: 0 };
    this.entries.set(key, entry);
    promise.then((value) => {
      entry.bytes = bytesOf(value);
      this.bytes += entry.bytes;
      for (const [oldest, { bytes }] of this.entries) {
        if (this.bytes <= this.limit) break;
        if (oldest === key) continue;
        this.entries.delete(oldest);
        this.bytes -= bytes;
      }
    }, () => this.entries.delete(key));
    return promise;
  }
}

/** An open .t4d file. All data is checked when it is read; a broken rule throws Invalid. */
export class T4dFile {
  constructor(source, { version, head, headers, bodies, done }) {
    this.source = source;
    /** @type {number[]} major and minor version */
    this.version = version;
    /** HEAD: features, length_unit, time_unit, up, generator, details and so on. */
    this.head = head;
    this.headers = headers;
    /**
     * The bodies, in the order of the file.
     * @type {{name: string, color?: number[], begin: number, end: number, min: number[], max: number[],
     *   numVertices: number, numCells: number, slabs: SlabRecord[]}[]}
     */
    this.bodies = bodies.map((slabs, i) => {
      const { numVertices, numCells, begin, end, min, max } = done.bodies[i];
      return { ...head.bodies[i], numVertices, numCells, begin, end, min, max, slabs };
    });
    this.parts = new Cache(cacheBytes);
    this.slabs = new Cache(cacheBytes);
  }

  get bytesRead() { return this.source.bytesRead; }

  get requests() { return this.source.requests; }

  /** The sum of the bytes of a slab and its parts in the file, and their offsets. */
  partsOf(record) {
    return [record.connectivity, record.lower, record.upper, record.at]
      .filter((offset, i, all) => offset !== 0 && all.indexOf(offset) === i);
  }

  sizeOf(record) {
    return this.partsOf(record).reduce((sum, offset) => sum + (this.headers.get(offset)?.size ?? 0), 0);
  }

  /** The chunks at these offsets; those close to each other in one request. */
  async chunksAt(offsets) {
    const runs = [];
    for (const at of [...new Set(offsets)].sort((a, b) => a - b)) {
      const { size } = this.headers.get(at);
      const run = runs.at(-1);
      const gap = run ? at - run.end : Infinity;
      if (gap <= smallGap && gap <= size) {
        run.end = at + size;
        run.offsets.push(at);
      } else {
        runs.push({ begin: at, end: at + size, offsets: [at] });
      }
    }
    const chunks = new Map();
    await Promise.all(runs.map(async ({ begin, end, offsets: places }) => {
      const bytes = await this.source.read(begin, end - begin);
      for (const at of places) {
        const { size, bytes: header } = this.headers.get(at);
        const chunk = parseChunk(bytes.slice(at - begin, at - begin + size), at);
        check(isSame(chunk.header, header), at, 'I2', 'another header than that in INDX');
        chunks.set(at, chunk);
      }
    }));
    return chunks;
  }

  /** The parsed chunks at these offsets, a promise for each; those that are not known are fetched together. */
  parsed(offsets) {
    const unknown = offsets.filter((at) => this.parts.get(at) === undefined);
    const chunks = this.chunksAt(unknown);
    for (const at of unknown) {
      const part = chunks.then((found) => parsers[found.get(at).type](found.get(at), this.head));
      this.parts.set(at, part, bytesOfPart);
    }
    return new Map(offsets.map((at) => [at, this.parts.get(at) ?? chunks]));
  }

  /**
   * Slabs, put together and checked. Those that follow one another in the file take one request for
   * up to 4 MiB.
   * @param {SlabRecord[]} records of `bodies[i].slabs`
   * @returns {Promise<import('./parts.js').Slab>[]}
   */
  slabsOf(records) {
    let run = [];
    let bytes = 0;
    const fetchRun = () => {
      if (run.length === 0) return;
      const isPart = (offset, { at }) => offset === at
        || (offset < at && ['CONN', 'LAYR', 'POSE'].includes(this.headers.get(offset)?.type));
      const offsets = new Set(run.flatMap((record) => this.partsOf(record).filter((at) => isPart(at, record))));
      const parsed = this.parsed([...offsets]);
      for (const record of run) this.slabs.set(record.at, this.assemble(record, parsed), bytesOfSlab);
      run = [];
      bytes = 0;
    };
    const wanted = records.map((record) => {
      const known = this.slabs.get(record.at);
      if (known) return () => known;
      const size = this.sizeOf(record);
      if (bytes + size > runBytes) fetchRun();
      run.push(record);
      bytes += size;
      return () => this.slabs.get(record.at);
    });
    fetchRun();
    return wanted.map((promise) => promise());
  }

  /**
   * A CONN, or a layer: a LAYR, or what a POSE makes of one.
   * @param {number} offset
   */
  async part(offset, parsed = this.parsed([offset])) {
    const part = await parsed.get(offset);
    if (part?.kind !== 'POSE') return part;
    const { layer: layr, at } = part;
    check(layr < at && this.headers.get(layr)?.type === 'LAYR', at, 'K2', `no LAYR at ${layr}, before the pose`);
    return posed(part, await this.parsed([layr]).get(layr));
  }

  async assemble(record, parsed) {
    const slab = await parsed.get(record.at);
    const found = await Promise.all([slab.connectivity, slab.lower, slab.upper].map((offset) => this.part(offset, parsed)));
    const made = assembled(slab, ...found);
    checkRecord(record, recordOf(made), record.at);
    return made;
  }

  /**
   * A slab, put together and checked.
   * @param {SlabRecord} record one of `bodies[i].slabs`
   * @returns {Promise<import('./parts.js').Slab>}
   */
  slab(record) {
    return this.slabsOf([record])[0];
  }

  /**
   * The slabs that answer a slice at a time, one for each body that is there then.
   * @param {number} time
   * @returns {Promise<import('./parts.js').Slab[]>}
   */
  async slabsAt(time) {
    const records = this.recordsOf(hyperplane([0, 0, 0, 1], time)).flat();
    return Promise.all(this.slabsOf(records));
  }

  /**
   * The records of the slabs that a hyperplane may cut, for each body.
   * @returns {SlabRecord[][]}
   */
  recordsOf(plane) {
    return this.bodies.map(({ slabs }) => {
      if (!plane.isTime) return slabs.filter((slab) => plane.mayCut([...slab.min, slab.begin], [...slab.max, slab.end]));
      const i = answering(slabs, plane.offset);
      return i < 0 ? [] : [slabs[i]];
    });
  }

  /**
   * The slice at a time, or by any hyperplane: closed triangle meshes that face outward.
   * @param {number|import('./slice.js').Hyperplane} at a time, or hyperplane(normal, offset)
   * @returns {Promise<import('./slice.js').Section[]>} one for each body
   */
  async slice(at) {
    const plane = typeof at === 'number' ? hyperplane([0, 0, 0, 1], at) : at;
    const sections = [];
    for (const [i, records] of this.recordsOf(plane).entries()) {
      const cutter = cut(plane, plane.isTime && plane.offset === this.bodies[i].end);
      for (let k = 0; k < records.length; k += slabsAhead) {
        for (const slab of this.slabsOf(records.slice(k, k + slabsAhead))) cutter.add(await slab);
      }
      sections.push({ name: this.bodies[i].name, ...cutter.finish() });
    }
    return sections;
  }
}

/**
 * Opens a .t4d file. One with index is read by need: its end now, slabs when they are asked for. One
 * without index is read and checked as a whole. A name that ends in .t4dm is that of a file in parts.
 * @param {string|URL|Blob|Uint8Array|object} from a URL, a File, bytes, or a source (source.js)
 * @returns {Promise<T4dFile|import('./parted.js').PartedFile>}
 */
export async function open(from) {
  let source = from;
  if (typeof from === 'string' || from instanceof URL) source = await httpSource(from);
  else if (from instanceof Uint8Array) source = bytesSource(from);
  else if (typeof Blob !== 'undefined' && from instanceof Blob) source = await blobSource(from);
  return isManifest(source.name ?? '') ? openManifest(source, openOne) : openOne(source);
}

/** Opens one file, whole. */
async function openOne(whole) {
  let source = whole;
  const { tail } = source;
  const hasEnd = tail.length >= footerBytes && isEndSignature(tail.subarray(tail.length - 8));
  if (Number.isNaN(source.size)) {
    check(hasEnd, 0, 'F1', 'the end signature is missing; the file may have been cut off');
    source.size = Number(new DataView(tail.buffer, tail.byteOffset + tail.length - 24).getBigUint64(0, true));
  }
  if (!hasEnd) {
    check(source.size >= fileHeaderBytes, 0, 'H1', `${source.size} bytes are no .t4d file`);
    const header = readFileHeader(await source.read(0, fileHeaderBytes));
    check(!header.hasIndex, Math.max(0, source.size - 8), 'F1',
      'the end signature is missing; the file may have been cut off');
    source = Object.assign(bytesSource(await source.read(0, source.size), source.name),
      { requests: source.requests, bytesRead: source.bytesRead });
    const found = await new Scan().run(source, () => {});
    return new T4dFile(source, { ...found, bodies: found.bodies.map(({ slabs }) => slabs) });
  }
  const { indx, done } = await readEnds(source);
  checkDone(done, indx.bodies, indx.headers);
  checkParts(indx);
  return new T4dFile(source, { ...indx, done });
}

/**
 * Reads a whole file from its front and checks every rule, in the memory of some slabs.
 * @param source as for open()
 * @param {(slab: import('./parts.js').Slab) => void} use called for each slab
 */
export const readAll = (source, use) => new Scan().run(source, use);

export { Invalid };
