// One file on the page: its slabs on the GPU and the sections that are shown of it.
import * as THREE from 'three';

import { answering, hyperplane } from 't4d-reader';

import { CutMesh, FacesMesh, measureCorners, mostTexels, readBack, SectionMesh } from './gpu.js';

/**
 * Slabs on the page are kept up to this many bytes, those that were used last. Sections of more are cut by
 * the worker.
 */
const slabBudget = 768 * 1024 * 1024;

/**
 * Triangles of a sketch, which is shown until a section of the worker is there. Without a GPU, as many are drawn in 0.1
 * to 0.2 s.
 */
const sketchBudget = 100_000;

/** What a cell takes on the page, about: itself where cells are not shared, and a quarter of a vertex. */
const cellBytes = 32;

/** Slabs that are asked for at once, for sections across time. */
const mostRequests = 16;

/**
 * The axes that a section is shown along, as rows of x, y, z, t: those of the hyperplane in a space-time
 * whose time was multiplied by `timeScale`.
 */
export function shownAxes(plane, timeScale) {
  const [x, y, z, t] = plane.normal;
  const { axes, isReversed } = hyperplane([x, y, z, t / timeScale], 0);
  return { axes: axes.map(([a, b, c, d]) => [a, b, c, d * timeScale]), isReversed };
}

const keyOf = ({ normal, offset }) => JSON.stringify([normal, offset]);

/** Resolves when the browser has shown the present state of the page. */
const framesLater = () => new Promise((resolve) => { requestAnimationFrame(() => requestAnimationFrame(resolve)); });

export class Pane {
  /**
   * @param {THREE.WebGLRenderer} renderer
   * @param {import('./shared.js').SharedFile} file that the pane closes
   * @param {THREE.Color[]} bodyColors
   * @param {(what?: {isPicture: boolean}) => void} onChange called when there is something new to draw, with what is
   *   drawn at once even if more is to come
   * @param {(error: Error) => void} onError
   */
  constructor(renderer, file, bodyColors, onChange, onError) {
    const { info, center } = file;
    Object.assign(this, { renderer, file, info, center, bodyColors, onChange, onError, budget: slabBudget });
    this.scene = new THREE.Scene();
    this.group = new THREE.Group();
    this.scene.add(this.group);
    this.slabs = new Map(); // by 'body/slab': { body, number, gpu }, the last used at the end
    this.sections = new Map(); // by 'onion/body/slab'
    this.ahead = new Set(); // the keys of slabs that were asked for before they are shown
    this.cut = null; // the section that the worker cuts
    this.loading = 0;
    this.failed = new Map(); // the errors of slabs, by 'body/slab'
    this.awaited = new Set(); // the values of attributes that are on their way
    this.isClosed = false;
  }

  /** [name, colour] of each body. */
  namedColors() {
    return this.info.bodies.map(({ name }, i) => [name, this.bodyColors[i]]);
  }

  /** The names of attributes that slabs had so far, by their domain. */
  attributeNames() {
    const names = new Map();
    for (const { gpu } of this.slabs.values()) {
      for (const { name, domain, components } of gpu?.attributes ?? []) names.set(name, { domain, components });
    }
    return names;
  }

  /** The slab on the GPU, or null while it is on its way; then onChange() follows. */
  slab(body, number) {
    const key = `${body}/${number}`;
    const known = this.slabs.get(key);
    if (known) {
      this.slabs.delete(key);
      this.slabs.set(key, known);
      return known.gpu;
    }
    if (this.failed.has(key) || this.loading >= mostRequests) return null;
    const entry = { body, number, gpu: null };
    this.slabs.set(key, entry);
    ++this.loading;
    this.file.take(body, number).then((gpu) => { entry.gpu = gpu; }).catch((error) => {
      this.slabs.delete(key);
      this.failed.set(key, error);
    }).finally(() => {
      --this.loading;
      if (!this.isClosed) this.onChange();
    });
    return null;
  }

  /** Has slabs that are not there read together, before slab() asks for each. */
  ask(numbers) {
    const missing = numbers.filter(({ body, number }) => !this.slabs.has(`${body}/${number}`))
      .slice(0, mostRequests - this.loading);
    if (missing.length < 2) return;
    for (const body of new Set(missing.map((each) => each.body))) {
      const slabs = missing.filter((each) => each.body === body).map(({ number }) => number);
      this.file.call('prefetch', { body, slabs });
    }
  }

  /** Asks for the values of an attribute of a slab, unless it has them; whether they are there. */
  attribute(gpu, body, number, name) {
    if (gpu.colorTextures.has(name) || !gpu.attributes.some((each) => each.name === name)) return true;
    const values = this.file.attribute(gpu, body, number, name);
    if (!this.awaited.has(values)) {
      this.awaited.add(values);
      values.then(() => this.awaited.delete(values)).catch(this.onError).finally(() => this.onChange());
    }
    return false;
  }

  /** The memory that the slabs take. */
  get bytes() {
    const there = [...this.slabs.values()].map(({ gpu }) => gpu).filter(Boolean);
    return sum(there.map(({ bytes }) => bytes)) + sum([...new Set(there.map(({ cells }) => cells))].map(({ bytes }) => bytes));
  }

  /** Forgets slabs that were not used for long. */
  evict(isWanted) {
    let { bytes } = this;
    for (const [key, { body, number, gpu }] of this.slabs) {
      if (bytes <= this.budget) return;
      if (!gpu || isWanted(key)) continue;
      this.slabs.delete(key);
      this.file.release(body, number);
      ({ bytes } = this);
    }
  }

  /** Whether the sections of this hyperplane fit the page. */
  fits(plane) {
    if (plane.isTime) {
      const cells = this.info.bodies.map(({ slabs }) => slabs[answering(slabs, plane.offset)]?.numCells ?? 0);
      return Math.max(...cells) <= mostTexels(this.renderer) && sum(cells) * cellBytes <= this.budget;
    }
    return sum(this.numbersOf(plane).map(({ record }) => record.numCells)) * cellBytes <= this.budget;
  }

  /** The slabs that a hyperplane may cut: { body, number, record }. */
  numbersOf(plane) {
    return this.info.bodies.flatMap(({ slabs }, body) => {
      if (plane.isTime) {
        const number = answering(slabs, plane.offset);
        return number < 0 ? [] : [{ body, number, record: slabs[number] }];
      }
      return slabs.map((record, number) => ({ body, number, record }))
        .filter(({ record }) => plane.mayCut([...record.min, record.begin], [...record.max, record.end]));
    });
  }

  /**
   * Shows the sections of a state; those whose slabs are on their way follow.
   * @param {{planes: {plane, opacity: number}[], timeScale: number, hidden: Set<string>, look: object}} what
   * @returns {boolean} whether all of it is there
   */
  show({ planes, timeScale, hidden, look, faces }) {
    if (!faces && !this.fits(planes[0].plane)) return this.showCut(planes[0].plane, timeScale, hidden, look);
    this.endCut();
    const wanted = new Map();
    const slabKeys = new Set();
    let isWhole = true;
    let hasFailed = false;
    const keepOthers = new Set(); // where a slab is missing, what was shown before stays
    const lookOf = (body) => ({ ...look, color: this.bodyColors[body], range: look.rangeOfBody(this.info.bodies[body]) });
    const want = (layer, body, number, Type, prepare) => {
      if (hidden.has(this.info.bodies[body].name)) return;
      const slabKey = `${body}/${number}`;
      slabKeys.add(slabKey);
      const slab = this.slab(body, number);
      if (slab && look.mode === 'attribute' && !this.attribute(slab, body, number, look.name)) isWhole = false;
      if (!slab) {
        if (this.failed.has(slabKey)) {
          // What was fetched ahead is reported when it is to be shown; of many, the first.
          if (!hasFailed) this.onError(this.failed.get(slabKey), this.info.bodies[body], this.info.bodies[body].slabs[number]);
          hasFailed = true;
        } else {
          isWhole = false;
          keepOthers.add(`${layer}/${body}/`);
        }
        return;
      }
      const key = `${layer}/${body}/${number}`;
      let mesh = this.sections.get(key);
      if (!mesh || mesh.slab !== slab || !(mesh instanceof Type)) {
        if (mesh) this.drop(key);
        mesh = new Type(slab);
        this.sections.set(key, mesh);
        this.group.add(mesh);
      }
      prepare(mesh);
      wanted.set(key, mesh);
    };

    if (faces) {
      this.ask(this.info.bodies.flatMap(({ slabs }, body) => slabs.map((_, number) => ({ body, number }))));
      this.info.bodies.forEach(({ slabs }, body) => slabs.forEach((_, number) => {
        want('faces', body, number, FacesMesh, (mesh) => {
          this.place(mesh, faces.axes);
          mesh.setAxes(faces.axes);
          mesh.setLook({ ...lookOf(body), opacity: 1, wireframe: false });
        });
      }));
    }
    for (const [layer, { plane, opacity }] of (faces ? [] : planes).entries()) {
      const { axes, isReversed } = shownAxes(plane, timeScale);
      const numbers = this.numbersOf(plane);
      if (!plane.isTime) this.ask(numbers.filter(({ body }) => !hidden.has(this.info.bodies[body].name)));
      for (const { body, number } of numbers) {
        const atLast = plane.isTime && plane.offset === this.info.bodies[body].end;
        want(layer, body, number, SectionMesh, (mesh) => {
          this.place(mesh, axes);
          mesh.cut(plane, axes, isReversed, atLast);
          if (look.mode === 'track' && plane.isTime) mesh.setTracks(look.tracks, this.info.bodies[body].name);
          mesh.setLook({ ...lookOf(body), opacity });
          mesh.renderOrder = opacity < 1 ? 1 + layer : 0;
        });
      }
    }
    for (const key of [...this.sections.keys()]) {
      const isKept = planes[0]?.plane.isTime && [...keepOthers].some((prefix) => key.startsWith(prefix));
      if (!wanted.has(key) && !isKept) this.drop(key);
    }
    this.evict((key) => slabKeys.has(key) || this.ahead.has(key));
    return isWhole;
  }

  /**
   * Shows a section that the worker cuts, in the memory of a few slabs: what there is of it, and before that another.
   * @returns {boolean} whether all of it is there
   */
  showCut(plane, timeScale, hidden, look) {
    const { cut } = this;
    if (cut) this.putCut(cut, timeScale, hidden, look);
    // While the slider moves, something is seen of every section that is begun.
    if (cut?.key !== keyOf(plane) && (!cut || cut.isSeen)) this.beginCut(plane);
    return this.cut.key === keyOf(plane) && this.cut.isWhole;
  }

  /** Has the worker cut a section, and end the one that it is cutting. */
  beginCut(plane) {
    this.endCut();
    const { bodies } = this.info;
    const cut = { plane, key: keyOf(plane), isSeen: false, isWhole: false, sections: bodies.map(() => null), version: 0 };
    const take = (sections) => {
      cut.sections = sections.map((section, body) => {
        const before = cut.sections[body];
        if (!section) return before;
        return { ...section, name: bodies[body].name, sketch: before?.isSketch && !section.isSketch ? before : null };
      });
      ++cut.version;
    };
    const { normal, offset } = plane;
    const onPart = (part) => {
      take(part);
      if (this.cut === cut) this.onChange({ isPicture: true });
    };
    const args = { file: this.info.file, normal, offset, budget: sketchBudget };
    const { answer, stop } = this.file.client.begin('sections', args, onPart);
    cut.stop = stop;
    cut.measures = answer.then((sections) => {
      if (sections) take(sections);
      return sections;
    });
    cut.measures.catch((error) => this.onError(error)).then(framesLater).then(() => {
      // Its numbers are seen by now: a large picture takes long to draw.
      Object.assign(cut, { isSeen: true, isWhole: true });
      this.onChange({ isPicture: true });
    });
    this.cut = cut;
  }

  endCut() {
    this.cut?.stop();
    this.cut = null;
  }

  /** Shows what there is of a section of the worker. */
  putCut(cut, timeScale, hidden, look) {
    const shown = JSON.stringify([cut.version, timeScale, [...hidden]]);
    if (cut.version > 0 && cut.shown !== shown) {
      this.putSections(cut.sections, cut.plane, timeScale, hidden);
      cut.shown = shown;
      cut.isSeen = true;
    }
    this.lookCut(look);
  }

  /**
   * Shows sections that were cut for something else.
   * @param {object} look as of show()
   */
  showSections(sections, plane, timeScale, hidden, look) {
    this.endCut();
    this.putSections(sections, plane, timeScale, hidden);
    this.lookCut(look);
  }

  /** Puts sections in the place of what was shown. */
  putSections(sections, plane, timeScale, hidden) {
    for (const each of [...this.sections.keys()]) this.drop(each);
    const { axes } = shownAxes(plane, timeScale);
    sections.forEach((section, body) => {
      if (!section || hidden.has(section.name) || section.triangles.length === 0) return;
      const mesh = new CutMesh(section, axes, this.center);
      this.place(mesh, axes);
      this.sections.set(`cut/${body}`, mesh);
      this.group.add(mesh);
    });
  }

  /**
   * Measures of the section of each body.
   * @returns {Promise<object[]|null>} null if the worker is to cut it for the picture, and has not begun
   */
  async measuresOf(plane) {
    if (this.fits(plane)) return (await this.slice(plane)).sections;
    return this.cut?.key === keyOf(plane) ? this.cut.measures : null;
  }

  /** A section of each body, by the worker: with its measures, and with the mesh if `meshes`. */
  async slice({ normal, offset }, meshes = false) {
    try {
      return await this.file.call('slice', { normal, offset, meshes });
    } catch (error) {
      error.message = `${this.info.name}: ${error.message}`;
      throw error;
    }
  }

  /** Puts a mesh where its file is, which need not be the middle of the picture. */
  place(mesh, axes) {
    mesh.position.set(...axes.map((axis) =>
      sum(axis.map((part, i) => part * (this.center[i] - this.origin[i])))));
  }

  /** Draws sketches, where there are any, in the place of the sections of the worker. */
  setRough(isRough) {
    for (const mesh of this.sections.values()) if (mesh instanceof CutMesh) mesh.setRough(isRough);
  }

  /** Colours the sections of the worker. */
  lookCut({ mode, rangeOfBody }) {
    for (const [key, mesh] of this.sections) {
      if (!(mesh instanceof CutMesh)) continue;
      const body = Number(key.slice('cut/'.length));
      mesh.setLook({ mode, color: this.bodyColors[body], range: rangeOfBody(this.info.bodies[body]) });
    }
  }

  drop(key) {
    const mesh = this.sections.get(key);
    this.group.remove(mesh);
    mesh.dispose();
    this.sections.delete(key);
  }

  /** Has the slabs read that play will need, the next ones in its direction, as far as there is room for them. */
  prefetch(plane, direction) {
    this.ahead.clear();
    if (!this.fits(plane)) return;
    const shown = this.numbersOf(plane);
    let room = this.budget - sum(shown.map(({ record }) => record.numCells)) * cellBytes;
    for (const { body, number } of shown) {
      for (const next of [number + direction, number + 2 * direction]) {
        const record = this.info.bodies[body].slabs[next];
        if (!record || record.begin === record.end) continue;
        room -= record.numCells * cellBytes;
        if (room < 0) return;
        this.ahead.add(`${body}/${next}`);
        this.slab(body, next);
      }
    }
  }

  /** The smallest and the largest number that are coloured in the slabs that are shown: speeds, or values of an attribute. */
  rangesOf(color) {
    const name = color.slice('attribute:'.length);
    return [...this.sections.values()].filter(({ slab }) => slab).map(({ slab }) => {
      if (color === 'speed') return slab.speeds;
      const found = slab.attributes.find((each) => each.name === name && each.components === 1);
      if (!found?.values || found.values instanceof Uint32Array) return null;
      found.range ??= rangeOfValues(found.values);
      return found.range;
    }).filter(Boolean);
  }

  /** What the GPU cuts, measured along the true axes of the hyperplane: of the first of the planes. */
  measureShown(plane) {
    const { axes, isReversed } = shownAxes(plane, 1);
    const total = { numTriangles: 0, volume: 0, area: 0 };
    for (const [key, mesh] of this.sections) {
      if (!key.startsWith('0/')) continue;
      const before = mesh.material.uniforms.axes.value.map((axis) => axis.toArray());
      mesh.setAxes(axes);
      mesh.material.uniforms.isReversed.value = isReversed;
      const { numTriangles, volume, area } = measureCorners(readBack(this.renderer, mesh));
      mesh.setAxes(before);
      total.numTriangles += numTriangles;
      total.volume += volume;
      total.area += area;
    }
    return total;
  }

  /** Minimum and maximum of x, y, z, t of all bodies. */
  bounds() {
    const { bodies } = this.info;
    const of = (pick, choose) => choose(...bodies.map(pick));
    const low = (value, other) => (Number.isFinite(value) ? value : other);
    return {
      min: [0, 1, 2].map((i) => low(of(({ min }) => min[i], Math.min), 0)).concat(of(({ begin }) => begin, Math.min)),
      max: [0, 1, 2].map((i) => low(of(({ max }) => max[i], Math.max), 0)).concat(of(({ end }) => end, Math.max)),
    };
  }

  dispose() {
    this.isClosed = true;
    this.endCut();
    for (const key of [...this.sections.keys()]) this.drop(key);
    for (const { body, number } of this.slabs.values()) this.file.release(body, number);
    this.file.close();
  }
}

const sum = (numbers) => numbers.reduce((all, each) => all + each, 0);

function rangeOfValues(values) {
  let low = Infinity;
  let high = -Infinity;
  for (const value of values) {
    if (!Number.isFinite(value)) continue;
    if (value < low) low = value;
    if (value > high) high = value;
  }
  return [low, high];
}
