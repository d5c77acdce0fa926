import { footerBytes } from './chunk.js';
import { check, Invalid } from './invalid.js';
import { cut, hyperplane } from './slice.js';

/** Parts that are kept open: their indexes and caches. */
const mostOpen = 8;

/** Number of slabs to request at once for a slice across time. */
const slabsAhead = 16;

const wrong = (name, message) => new Invalid(0, 'manifest', `${name}: ${message}`);

const isNumber = (value) => typeof value === 'number' && Number.isFinite(value);
const isCount = (value) => Number.isSafeInteger(value) && value >= 0;

/** Whether the name of a file, or a URL, is that of a manifest. */
export const isManifest = (name) => /\.t4dm$/i.test(name);

/** Checks a manifest as far as reading by it depends on it. */
function parseManifest(text, name) {
  let manifest;
  try {
    manifest = JSON.parse(text);
  } catch (error) {
    throw wrong(name, `is not JSON: ${error.message}`);
  }
  const { t4dm, head, parts } = manifest ?? {};
  if (t4dm !== 1) throw wrong(name, `is a manifest of version ${t4dm}; this reader knows 1`);
  if (!Array.isArray(head?.bodies)) throw wrong(name, 'has no head with bodies');
  if (!Array.isArray(parts) || parts.length === 0) throw wrong(name, 'names no part');
  parts.forEach((part, k) => {
    const { path, bytes, footer, bodies } = part ?? {};
    const isPath = typeof path === 'string' && path !== '' && !path.startsWith('/') && !path.includes('\\')
      && !path.split('/').includes('..');
    const isUrl = typeof path === 'string' && /^https?:\/\//i.test(path);
    if (!isUrl && (!isPath || /^[a-z][a-z0-9+.-]*:/i.test(path))) {
      throw wrong(name, `part ${k + 1} is '${path}': a part is a path in its folder or below, without '..', or an `
        + 'http:// or https:// URL');
    }
    if (!isCount(bytes) || typeof footer !== 'string' || !Array.isArray(bodies) || bodies.length !== head.bodies.length) {
      throw wrong(name, `part ${k + 1} lacks bytes, footer, or one of ${head.bodies.length} bodies`);
    }
    bodies.forEach((body, i) => {
      const sound = isNumber(body?.begin) && isNumber(body.end) && body.begin <= body.end
        && [body.slabs, body.vertices, body.cells, body.shared].every(isCount);
      if (!sound) throw wrong(name, `part ${k + 1} has a body ${i + 1} that is not described`);
      const before = parts[k - 1]?.bodies[i];
      if (before && (body.shared > 0 ? body.begin !== before.end : body.begin < before.end)) {
        throw wrong(name, `part ${k + 1} begins at ${body.begin}, the part before ends at ${before.end}`);
      }
    });
  });
  return manifest;
}

const widest = (points, pick) => {
  const known = points.filter(Boolean);
  const none = pick === Math.min ? Infinity : -Infinity;
  return [0, 1, 2].map((axis) => known.reduce((found, point) => pick(found, point[axis]), none));
};

/** The summary of body i in the manifest, over all parts. */
function summary({ head, parts }, i) {
  const all = parts.map(({ bodies }) => bodies[i]);
  const sum = (of) => all.reduce((total, body, k) => total + of(body, k), 0);
  return {
    ...head.bodies[i], begin: all[0].begin, end: all.at(-1).end, numSlabs: sum(({ slabs }) => slabs),
    numVertices: sum(({ vertices, shared }, k) => vertices - (k > 0 ? shared : 0)), numCells: sum(({ cells }) => cells),
    min: widest(all.map(({ min }) => min), Math.min), max: widest(all.map(({ max }) => max), Math.max),
  };
}

/**
 * A file in parts, by its manifest (NAME.t4dm). Parts are opened when they are needed, and must be those that
 * the manifest describes, by their sizes and footers.
 */
export class PartedFile {
  /** @param openOne opens a source as a T4dFile */
  constructor(source, manifest, openOne) {
    Object.assign(this, { source, manifest, openOne, files: new Map(), closed: { bytesRead: 0, requests: 0 } });
    /** HEAD of the file that the parts are together. */
    this.head = manifest.head;
    /** The bodies as T4dFile has them, but with `numSlabs` instead of `slabs`. */
    this.bodies = manifest.head.bodies.map((_, i) => summary(manifest, i));
  }

  sum(what) {
    return [...this.files.values()].reduce((total, { opened }) => total + (opened?.[what] ?? 0),
      this.source[what] + this.closed[what]);
  }

  get bytesRead() { return this.sum('bytesRead'); }

  get requests() { return this.sum('requests'); }

  /** Part k, from 0, as a T4dFile. */
  part(k) {
    const known = this.files.get(k);
    this.files.delete(k);
    const entry = known ?? { opened: null, promise: null };
    this.files.set(k, entry);
    entry.promise ??= this.openPart(k).then((file) => { entry.opened = file; return file; });
    entry.promise.catch(() => this.files.delete(k));
    if (this.files.size > mostOpen) this.close(this.files.keys().next().value);
    return entry.promise;
  }

  close(k) {
    const { opened } = this.files.get(k);
    this.files.delete(k);
    if (!opened) return;
    this.closed.bytesRead += opened.bytesRead;
    this.closed.requests += opened.requests;
    opened.source.close?.();
  }

  async openPart(k) {
    const { path, bytes, footer, bodies } = this.manifest.parts[k];
    const other = (message) => wrong(path, `is not the part that ${this.source.name} describes: ${message}`);
    const source = await this.source.beside(path);
    const end = source.tail.subarray(Math.max(0, source.tail.length - footerBytes));
    const found = [...end].map((byte) => byte.toString(16).padStart(2, '0')).join('');
    if (!Number.isNaN(source.size) && source.size !== bytes) throw other(`it has ${source.size} bytes, not ${bytes}`);
    if (found !== footer) throw other('its footer, which has its checksums, is another');
    const file = await this.openOne(source);
    bodies.forEach((body, i) => {
      const own = file.bodies[i];
      if (own?.name !== this.bodies[i].name || own.slabs.length !== body.slabs || own.begin !== body.begin
        || own.end !== body.end) throw other(`its body ${i + 1} is another`);
    });
    return file;
  }

  /** The numbers of the parts that may have something of body i there. */
  partsAt(plane, i) {
    const ends = this.manifest.parts.map(({ bodies }) => bodies[i]);
    if (plane.isTime) {
      const time = plane.offset;
      const atLast = time === ends.at(-1).end;
      const k = ends.findIndex(({ end }) => end > time || (atLast && end === time));
      return k < 0 || ends[k].begin > time ? [] : [k];
    }
    return [...ends.keys()].filter((k) => {
      const { min, max, begin, end } = ends[k];
      return min !== null && plane.mayCut([...min, begin], [...max, end]);
    });
  }

  /** The slabs of body i that a hyperplane may cut, in the order of time. */
  async* slabsOf(plane, i) {
    for (const k of this.partsAt(plane, i)) {
      const file = await this.part(k);
      const records = file.recordsOf(plane)[i];
      for (let next = 0; next < records.length; next += slabsAhead) {
        yield* file.slabsOf(records.slice(next, next + slabsAhead));
      }
    }
  }

  /** Like T4dFile.slabsAt. */
  async slabsAt(time) {
    const slabs = [];
    for (const i of this.bodies.keys()) {
      for await (const slab of this.slabsOf(hyperplane([0, 0, 0, 1], time), i)) slabs.push(slab);
    }
    return slabs;
  }

  /** Like T4dFile.slice. */
  async slice(at) {
    const plane = typeof at === 'number' ? hyperplane([0, 0, 0, 1], at) : at;
    const sections = [];
    for (const [i, { name, end }] of this.bodies.entries()) {
      const cutter = cut(plane, plane.isTime && plane.offset === end);
      for await (const slab of this.slabsOf(plane, i)) cutter.add(slab);
      sections.push({ name, ...cutter.finish() });
    }
    return sections;
  }
}

/** Opens a file in parts. @param source of its manifest */
export async function openManifest(source, openOne) {
  if (!source.beside) throw wrong(source.name, 'is a file in parts: open it by its URL, which says where they are');
  check(source.size > 0, 0, 'manifest', `${source.name} is empty`);
  const text = new TextDecoder().decode(await source.read(0, source.size));
  return new PartedFile(source, parseManifest(text, source.name), openOne);
}
