// What a view is made of: the model, the picture, the time bar and the box for errors, in a shadow root.
import { Bar } from './bar.js';
import { colorsOf } from './colors.js';
import { shown } from './common.js';
import { Comparison } from './comparison.js';
import { Drawing } from './drawing.js';
import { EventList } from './events.js';
import { glbOf } from './glb.js';
import { fillLegend } from './legend.js';
import { Messages } from './messages.js';
import { Model } from './model.js';
import { Pane, shownAxes } from './pane.js';
import { Player } from './play.js';
import { openShared } from './shared.js';
import { listenToPointer } from './turning.js';
import { View } from './view.js';

const cutNames = {
  t: ['x', 'y', 'z'], x: ['y', 'z', 't'], y: ['x', 'z', 't'], z: ['x', 'y', 't'], any: ['u', 'v', 'w'],
};

/** An error that says which file it is of. */
const ofFile = (name, error) => Object.assign(new Error(`${name}: ${error.message}`), error);

/**
 * Events: `change` (detail: the state before), `move` (the camera), `files`, `draw`, `compared`, and `error` (detail: the
 * error).
 */
export class Viewer extends EventTarget {
  /** @param {ShadowRoot} root with the elements of view.html */
  constructor(root) {
    super();
    this.root = root;
    this.find = (id) => root.getElementById(id);
    this.model = new Model((before) => this.follow(before));
    this.messages = new Messages(this.find('message'), this.model);
    this.view = new View(this.find('canvas'), this.find('gizmo'), () => this.onMove());
    this.player = new Player(this.model, () => this.bar.fill());
    this.comparison = new Comparison(this.model, (error) => this.showError(error));
    this.drawing = new Drawing(this);
    this.bar = new Bar(this);
    this.events = new EventList(this);
    /** Whether a program changes the model, and not the person in front of it. */
    this.isQuiet = false;
    /** Counts what was to be opened: what comes after the next is too late. */
    this.turn = 0;
    this.numOpening = 0;
    this.isEnded = false;
    this.lastFrame = 0;
    listenToPointer(this);
    this.find('canvas').addEventListener('webglcontextlost', () => this.isEnded || this.showError(new Error(
      'The browser took this picture away. It does so if a page has more than about 16, or if the GPU was reset.')));
    this.find('canvas').addEventListener('webglcontextrestored', () => {
      this.messages.hide();
      this.drawing.invalidate();
    });
    this.resizes = new ResizeObserver(() => {
      this.bar.drawMarks();
      this.drawing.invalidate();
    });
    this.resizes.observe(this.find('canvas'));
    this.bar.fill();
    requestAnimationFrame((now) => this.frame(now));
  }

  emit(type, detail) {
    this.dispatchEvent(new CustomEvent(type, { detail }));
  }

  /** Changes the model for a program. */
  quietly(change) {
    const { isQuiet } = this;
    this.isQuiet = true;
    try {
      change();
    } finally {
      this.isQuiet = isQuiet;
    }
  }

  /** The model has changed. */
  follow(before) {
    const { state } = this.model;
    // When the axes change, all is shown.
    if (['cut', 'drop', 'timeScale'].some((key) => state[key] !== before[key])) this.fitCamera();
    this.drawing.invalidate();
    this.messages.hideOld();
    this.bar.fill();
    this.emit('change', before);
  }

  onMove() {
    this.model.state.camera = this.view.place;
    this.drawing.onMove();
    this.emit('move');
  }

  frame(now) {
    if (this.isEnded) return;
    requestAnimationFrame((next) => this.frame(next));
    const { player, drawing, model } = this;
    // A slice is waited for.
    if (player.isPlaying && drawing.isWhole && model.panes.length > 0) {
      player.advance(Math.min(0.1, (now - this.lastFrame) / 1000));
    }
    this.lastFrame = now;
    if (!drawing.drawChanges()) return;
    if (drawing.isWhole) fillLegend(this, drawing.colorRange());
    this.emit('draw');
  }

  fitCamera() {
    const { model, model: { state, bounds, panes }, view } = this;
    if (panes.length === 0) return;
    const isSolid = state.cut === 'solid';
    view.setUp(state.cut === 't' ? panes[0].info.head.up ?? 'y' : 'z');
    const axes = isSolid ? model.facesAxes().axes : shownAxes(model.plane(), state.timeScale).axes;
    view.labels = isSolid ? model.facesAxes().names : cutNames[state.cut];
    const half = bounds.max.map((high, i) => (high - bounds.min[i]) / 2);
    const lengths = axes.map((axis) => axis.reduce((sum, part, i) => sum + Math.abs(part) * half[i], 0));
    view.fit(Math.hypot(...lengths));
  }

  /** Shows the time of an event of tracks, and looks at its place. */
  showEvent({ time, place }) {
    this.player.play(false);
    this.model.set({ cut: 't', t: this.model.within('t', time) });
    this.view.lookAt(place.map((value, i) => value - this.model.center[i]));
  }

  /** Shows what a program asks for, as far as the files have it. */
  ask(asked) {
    this.quietly(() => {
      this.model.ask(asked);
      if (asked.camera) this.view.place = asked.camera;
      if (asked.camera === null) this.fitCamera();
    });
  }

  /** Shows what is asked for, and else what the files show at first; places the camera, or fits the picture. */
  restore(asked) {
    this.model.restore(asked);
    this.restoreCamera();
    this.model.changed();
  }

  restoreCamera() {
    const { camera } = this.model.state;
    this.fitCamera();
    if (camera) this.view.place = camera;
  }

  /** Shows and tells what went wrong. */
  showError(error, detail = '') {
    this.messages.say(...[error.message, detail].filter(Boolean));
    if (error.isKnown === false || error.workerStack) console.error(error.workerStack ?? error);
    this.emit('error', error);
  }

  /**
   * Opens files beside one another, instead of those that are shown.
   * @param {{from: string|Blob|Uint8Array, name?: string}[]} sources
   * @param {() => object} asked members of the state that are asked for, once the first is open
   * @returns {Promise<Error[]>} why some could not be opened
   */
  async open(sources, asked) {
    const turn = ++this.turn;
    const errors = [];
    let isFirst = true;
    this.model.areAllOpen = false;
    for (const source of sources) {
      try {
        if (await this.add(source, !isFirst, asked, turn)) isFirst = false;
      } catch (error) {
        errors.push(error);
      }
      if (turn !== this.turn) return [];
    }
    this.model.areAllOpen = true;
    this.ask(asked());
    return errors;
  }

  /**
   * Opens a file beside those that are there, or instead of them.
   * @returns {Promise<boolean>} false if another was to be opened meanwhile
   */
  async add({ from, name, ...rest }, isBeside, asked = () => ({}), turn = this.turn) {
    ++this.numOpening;
    this.find('busy').hidden = false;
    let file;
    try {
      file = await openShared(from, name);
    } catch (error) {
      if (turn !== this.turn) return false;
      throw ofFile(name ?? from.name ?? from, error);
    } finally {
      --this.numOpening;
      this.drawing.invalidate();
    }
    if (turn !== this.turn) {
      file.close();
      return false;
    }
    this.quietly(() => this.show(file, isBeside, asked, { from, ...rest }));
    return true;
  }

  /** Shows a file that is open. */
  show(file, isBeside, asked, source) {
    const { model, model: { panes } } = this;
    if (!isBeside) this.closeAll();
    const isFirst = panes.length === 0;
    const { info } = file;
    const colors = colorsOf(info.bodies, panes.flatMap((each) => each.namedColors()));
    const pane = new Pane(this.view.renderer, file, colors, (what) => this.drawing.onArrival(what), (error, body, slab) => {
      // Said once of what is shown.
      if (body && this.messages.wasSaid) return;
      this.showError(ofFile(info.name, error),
        body && `Of '${body.name}' the time from ${shown(slab.begin)} to ${shown(slab.end)} cannot be shown; the rest can.`);
    });
    pane.source = source;
    panes.push(pane);
    model.measureBounds();
    if (isFirst) model.begin(pane, asked());
    pane.origin = model.center;
    this.find('names').replaceChildren(...(panes.length < 2 ? [] : panes)
      .map((each) => Object.assign(document.createElement('span'), { textContent: each.info.name })));
    if (isFirst) this.restoreCamera();
    else this.fitCamera();
    this.emit('files');
    model.changed();
  }

  /** The section of each body of a file that is shown, with its colour. */
  async sectionsOf(pane, plane, meshes) {
    const { sections } = await pane.slice(plane, meshes);
    return sections.map((section, i) => ({ ...section, color: pane.bodyColors[i].toArray() }))
      .filter(({ name }) => !this.model.state.hidden.includes(name));
  }

  /** The section of a file as .glb, with its exact points; null of an empty one. */
  async glbOf(pane, plane = this.model.plane()) {
    return glbOf(await this.sectionsOf(pane, plane, true), { isZUp: plane.isTime && pane.info.head.up === 'z' });
  }

  /** Shows no file. */
  clear() {
    this.closeAll();
    this.emit('files');
    this.quietly(() => this.model.changed());
  }

  closeAll() {
    for (const pane of this.model.panes.splice(0)) pane.dispose();
  }

  /** Ends all that it has: files, pictures, and what waits for them. */
  dispose() {
    this.isEnded = true;
    ++this.turn;
    this.resizes.disconnect();
    this.closeAll();
    this.view.dispose();
  }
}
