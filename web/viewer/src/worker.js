// Opens files, decodes slabs and measures slices, away from the page's own thread.
//
// Requests are { id, call, args }, answers { id, value } or { id, error }; before an answer there may be { id, part }.
// { id, stop: true } stops a call that can be stopped.
import { cut, FetchError, httpSource, hyperplane, Invalid, measure, open } from 't4d-reader';

import { blockCells } from './common.js';
import { distancesFrom } from './distance.js';
import { sketchesOf } from './sketch.js';

const files = [];
/** Connectivities whose cells the page has, for each file. */
const sent = [];

/** Minimum and maximum of x, y, z, t of each block of cells. */
function boundsOfBlocks({ cells, vertices }) {
  const count = Math.ceil(cells.length / 4 / blockCells);
  const bounds = new Float64Array(8 * count);
  for (let block = 0; block < count; ++block) {
    const end = Math.min(cells.length, 4 * blockCells * (block + 1));
    for (let axis = 0; axis < 4; ++axis) {
      let low = Infinity;
      let high = -Infinity;
      for (let i = 4 * blockCells * block; i < end; ++i) {
        const value = vertices[4 * cells[i] + axis];
        if (value < low) low = value;
        if (value > high) high = value;
      }
      bounds[8 * block + axis] = low;
      bounds[8 * block + 4 + axis] = high;
    }
  }
  return bounds;
}

/** What the page draws colours from: whole numbers of 32 bits as they are, others as float32. */
const drawable = (values) => {
  if (values instanceof Uint32Array) return values;
  return values instanceof BigInt64Array || values instanceof BigUint64Array
    ? Float32Array.from(values, Number) : Float32Array.from(values);
};

const calls = {
  async open({ from, name }) {
    const file = await open(from instanceof Uint8Array || from instanceof Blob ? from : await httpSource(from));
    if (name) file.source.name = name;
    files.push(file);
    sent.push(new Set());
    const { head, bodies, version } = file;
    return {
      file: files.length - 1, name: file.source.name, size: file.source.size, version, head, bodies,
      read: file.bytesRead, requests: file.requests,
      slabBytes: bodies.map(({ slabs }) => slabs.map((record) => file.sizeOf(record))),
    };
  },

  /** A slab; with its cells if the page does not have them. */
  async slab({ file: index, body, slab: number }) {
    const file = files[index];
    const slab = await file.slab(file.bodies[body].slabs[number]);
    const hasCells = sent[index].has(slab.connectivity);
    sent[index].add(slab.connectivity);
    const { begin, end, min, max, vertices, cells, prisms, connectivity, numVertices } = slab;
    return {
      begin, end, min, max, vertices, connectivity, numVertices, numCells: cells.length / 4,
      cells: hasCells ? null : cells, prisms: hasCells ? null : prisms, bounds: boundsOfBlocks(slab),
      attributes: slab.attributes.filter((each) => each.components <= 4)
        .map(({ domain, name, type, components }) => ({ domain, name, type, components })),
      read: file.bytesRead, requests: file.requests,
    };
  },

  /** The values of an attribute in a slab. */
  async attribute({ file: index, body, slab: number, name }) {
    const file = files[index];
    const { attributes } = await file.slab(file.bodies[body].slabs[number]);
    return drawable(attributes.find((each) => each.name === name).values);
  },

  /** The page shows another file instead. */
  close({ file }) {
    files[file] = null;
    sent[file] = null;
  },

  /** The page has forgotten the cells. */
  forget({ file, connectivity }) {
    sent[file]?.delete(connectivity);
  },

  /** Slabs that are going to be asked for: those that follow one another are fetched in one request. */
  async prefetch({ file: index, body, slabs }) {
    const file = files[index];
    await Promise.allSettled(file.slabsOf(slabs.map((number) => file.bodies[body].slabs[number])));
  },

  /** Measures of a slice of each body, and its seconds without reading; with the meshes if `meshes`. */
  async slice({ file: index, normal, offset, meshes = false }) {
    const file = files[index];
    const { sections, milliseconds } = await sectionsOf(file, hyperplane(normal, offset));
    return {
      sections: sections.map((section) => ({ ...measure(section), ...(meshes ? section : { name: section.name }) })),
      milliseconds, read: file.bytesRead, requests: file.requests,
    };
  },

  /**
   * A section across time of each body, with its measures; null if the call was stopped. Parts are what there is before
   * that: for each body a mesh, or null where there is none that is new.
   */
  async sections({ file: index, normal, offset, budget }, { give, isStopped }) {
    const file = files[index];
    const plane = hyperplane(normal, offset);
    let paused = performance.now();
    const pause = async () => {
      if (performance.now() - paused < pauseMilliseconds) return;
      await new Promise((resolve) => { setTimeout(resolve); });
      if (isStopped()) throw stopped;
      paused = performance.now();
    };
    try {
      const sketch = await giveSketches(file, plane, budget, give, pause);
      const growth = giveGrowth(sketch, give);
      const { sections } = await sectionsOf(file, plane, async (body, cutter) => {
        growth(body, cutter);
        await pause();
      });
      return sections.map((section) => ({ ...measure(section), name: section.name, ...meshOf(section) }));
    } catch (error) {
      if (error === stopped) return null;
      throw error;
    }
  },

  /** Gives the sections of two files but for hidden bodies, with the `distances` of their points from the other's. */
  async distances({ files: [a, b], normal, offset, hidden }) {
    const plane = hyperplane(normal, offset);
    const [ofA, ofB] = (await Promise.all([a, b].map((index) => sectionsOf(files[index], plane))))
      .map(({ sections }) => sections.map((section) => ({ ...section, isHidden: hidden.includes(section.name) })));
    const isShown = ({ isHidden }) => !isHidden;
    const withDistances = (sections, others) => {
      const distances = distancesFrom(sections.filter(isShown), others.filter(isShown));
      return sections.map((section) => ({ ...section, distances: section.isHidden ? null : distances.shift() }));
    };
    return [withDistances(ofA, ofB), withDistances(ofB, ofA)];
  },
};

const stopped = new Error('stopped');

/** A call that can be stopped looks every so often whether it was. */
const pauseMilliseconds = 50;

/** Where there is no sketch, what was cut so far is given after this time, and whenever the time has doubled. */
const growthMilliseconds = 500;

/** The parts of a section that the page draws. */
const meshOf = ({ points4, triangles }) => ({ points4, triangles });

/** Gives the sketches of a section; whether each body has one. */
async function giveSketches(file, plane, budget, give, pause) {
  const records = file.recordsOf(plane);
  let hasSketch = records.map(() => false);
  try {
    for await (const sketch of sketchesOf(file, records, plane, budget)) {
      hasSketch = sketch.map(Boolean);
      give(sketch);
      await pause();
    }
  } catch (error) {
    // Damage is reported when the section itself is cut.
    if (error === stopped) throw error;
  }
  return hasSketch;
}

/** Gives what was cut so far of bodies without a sketch, now and then. */
function giveGrowth(hasSketch, give) {
  const begin = performance.now();
  let next = growthMilliseconds;
  return (body, cutter) => {
    const now = performance.now() - begin;
    if (hasSketch[body] || now < next) return;
    give(hasSketch.map((_, i) => (i === body ? meshOf(cutter.finish()) : null)));
    next = 2 * now;
  };
}

/**
 * The sections of all bodies of a file, and the milliseconds that they took without reading.
 * @param {(body: number, cutter) => Promise<void>} [onSlab] called after each slab
 */
async function sectionsOf(file, plane, onSlab = async () => {}) {
  const sections = [];
  let milliseconds = 0;
  for (const [i, records] of file.recordsOf(plane).entries()) {
    const cutter = cut(plane, plane.isTime && plane.offset === file.bodies[i].end);
    for (const record of records) {
      const slab = await file.slab(record);
      const begin = performance.now();
      cutter.add(slab);
      milliseconds += performance.now() - begin;
      await onSlab(i, cutter);
    }
    const begin = performance.now();
    sections.push({ ...cutter.finish(), name: file.bodies[i].name });
    milliseconds += performance.now() - begin;
  }
  return { sections, milliseconds };
}

/** The numbers of the calls that are to stop. */
const toStop = new Set();

self.onmessage = async ({ data: { id, call, args, stop } }) => {
  if (stop) {
    toStop.add(id);
    return;
  }
  try {
    const give = (part) => self.postMessage({ id, part }, buffersOf(part));
    const value = await calls[call](args, { give, isStopped: () => toStop.has(id) });
    self.postMessage({ id, value }, call === 'sections' ? buffersOf(value) : []);
  } catch (error) {
    const isKnown = error instanceof Invalid || error instanceof FetchError;
    self.postMessage({
      id, error: { message: error.message, at: error.at, rule: error.rule, isKnown, stack: isKnown ? undefined : error.stack },
    });
  }
  toStop.delete(id);
};

/** The memory of meshes, which goes to the page. */
const buffersOf = (meshes) => (meshes ?? []).filter(Boolean)
  .flatMap(({ points4, triangles }) => [points4.buffer, triangles.buffer]);
