// The custom element <t4d-view>, which shows a .t4d file.
import { askedBy, attributes, shownBodies } from './attributes.js';
import style from './view.css';
import controls from './controls.css';
import template from './view.html';
import { Tracks } from './tracks.js';
import { Viewer } from './viewer.js';

/** The name of a mesh that has no address: one of its own, or that in data:...;name=NAME;base64,... */
function nameOf(from) {
  if (typeof from !== 'string') return from.name ?? 'mesh.t4d';
  if (!from.startsWith('data:')) return undefined;
  return decodeURIComponent(/^data:[^,]*;name=([^;,]*)/.exec(from)?.[1] ?? 'mesh.t4d');
}

/** A file as it can be opened: an address in full, a Blob, or bytes. */
function sourceOf(from) {
  const name = nameOf(from);
  if (from instanceof ArrayBuffer) return { from: new Uint8Array(from), name };
  if (typeof from !== 'string' && !(from instanceof URL)) return { from, name };
  // The worker refuses what is not an address.
  return { from: URL.canParse(from, document.baseURI) ? new URL(from, document.baseURI).href : from, name };
}

/** A hint that may help. */
function hintOf({ rule }) {
  if (rule) return 'The file is damaged or is no .t4d file; `t4d recover` saves what is whole of a damaged one.';
  return location.protocol === 'file:'
    ? 'Browsers do not let a page that is opened from a folder read other files: use a web server, or src="data:...".' : '';
}

export class T4dView extends HTMLElement {
  static observedAttributes = ['src', 'compare', 'tracks', ...Object.keys(attributes)];

  #viewer = null;
  /** What was given to load(), in place of the attributes src and compare. */
  #loaded = null;
  #opening = Promise.resolve();

  constructor() {
    super();
    this.attachShadow({ mode: 'open' });
  }

  connectedCallback() {
    if (this.#viewer) return; // it was only moved
    // Properties may have been set before the script of the element came.
    for (const name of [...T4dView.observedAttributes, 'controls', 'autoplay'].filter((each) => Object.hasOwn(this, each))) {
      const value = this[name];
      delete this[name];
      this[name] = value;
    }
    this.shadowRoot.innerHTML = `<style>${controls}${style}</style>${template}`;
    try {
      this.#viewer = new Viewer(this.shadowRoot);
    } catch {
      this.shadowRoot.textContent = 'This browser has no WebGL 2, without which 4D meshes cannot be shown.';
      this.#emit('error', { message: this.shadowRoot.textContent, error: new Error(this.shadowRoot.textContent) });
      return;
    }
    this.#listen();
    this.#open().catch(() => {});
  }

  disconnectedCallback() {
    // Nothing is lost if it is moved to another place.
    queueMicrotask(() => {
      if (this.isConnected || !this.#viewer) return;
      this.#viewer.dispose();
      this.#viewer = null;
      this.shadowRoot.replaceChildren();
    });
  }

  attributeChangedCallback(name) {
    if (!this.#viewer) return;
    if (['src', 'compare', 'tracks'].includes(name)) {
      if (name !== 'tracks') this.#loaded = null;
      this.#open().catch(() => {});
    } else if (this.#viewer.model.panes.length > 0) {
      const asked = this.#askedBy(name);
      if (name === 'view' && this.hasAttribute('view')) this.#viewer.quietly(() => this.#viewer.restore(asked));
      else this.#viewer.ask(asked);
    }
  }

  #emit(type, detail) {
    this.dispatchEvent(new CustomEvent(`t4d-${type}`, { detail, bubbles: true, composed: true }));
  }

  #listen() {
    const viewer = this.#viewer;
    const { model } = viewer;
    const byPerson = (type, call) => viewer.addEventListener(type, (event) => viewer.isQuiet || call(event));
    byPerson('change', ({ detail: before }) => {
      const keys = ['cut', 'x', 'y', 'z', 'normal', 'offset'];
      if (model.state.t !== before.t) this.#emit('time', { time: this.time });
      if (keys.some((key) => model.state[key] !== before[key])) this.#emit('hyperplane', { hyperplane: this.hyperplane });
    });
    byPerson('move', () => this.#emit('camera', { camera: this.camera }));
    viewer.addEventListener('error', ({ detail: error }) => this.#emit('error', { message: error.message, error }));
    viewer.addEventListener('draw', () => {
      if (viewer.drawing.isWhole && model.panes.length > 0 && viewer.numOpening === 0) this.#emit('draw', {});
    });
  }

  /** What an attribute asks for; if it makes no sense, the element says so. */
  #askedBy(name) {
    try {
      return askedBy(name, this.getAttribute(name), this.#viewer.model);
    } catch (error) {
      this.#viewer.showError(error);
      return {};
    }
  }

  /** Opens what load() was given, or what the attributes name. */
  #open() {
    const named = ['src', 'compare'].map((name) => this.getAttribute(name)).filter(Boolean).map(sourceOf);
    this.#opening = this.#load(this.#loaded ?? named);
    return this.#opening;
  }

  async #load(sources) {
    const viewer = this.#viewer;
    // Later ones say more than earlier ones.
    const asked = () => Object.assign({}, ...Object.keys(attributes).filter((name) => this.hasAttribute(name))
      .map((name) => this.#askedBy(name)));
    viewer.messages.hide();
    if (sources.length === 0) viewer.clear();
    const turn = ++viewer.turn;
    const tracks = await this.#readTracks();
    if (viewer.turn !== turn) return;
    viewer.model.tracks = tracks.value;
    const errors = await viewer.open(sources, asked);
    if (viewer.turn !== turn + 1) return;
    const isOpen = errors.length < sources.length;
    if (tracks.error) errors.push(tracks.error);
    for (const error of errors) viewer.showError(error, hintOf(error));
    const files = viewer.model.panes.map(({ info }) => info);
    if (isOpen) {
      this.#emit('load', {
        names: files.map(({ name }) => name), bodies: this.bodies, begin: this.begin, end: this.end,
      });
      if (this.hasAttribute('autoplay')) this.play();
    }
    if (errors.length > 0) throw errors[0];
  }

  /** The report that the attribute `tracks` names: { value, error }. */
  async #readTracks() {
    const address = this.getAttribute('tracks');
    if (!address) return { value: null };
    try {
      const answer = await fetch(new URL(address, document.baseURI));
      if (!answer.ok) throw new Error(`the server answers ${answer.status}`);
      return { value: new Tracks(await answer.json()) };
    } catch ({ message }) {
      return { value: null, error: new Error(`${address}: ${message}`) };
    }
  }

  /** The parts of the element, for the page of t4d view; they may change with any version. */
  get viewer() { return this.#viewer; }

  /**
   * Shows a file, or two beside each other, instead of those of the attributes.
   * @param {...(string|URL|Blob|ArrayBuffer|Uint8Array)} files
   * @returns {Promise<void>} rejected if one cannot be opened, which the element shows, too
   */
  async load(...files) {
    this.#loaded = files.map(sourceOf);
    if (this.#viewer) await this.#open();
  }

  /** Resolves when all that is to be shown is drawn. */
  async drawn() {
    await this.#opening.catch(() => {});
    await this.#viewer?.drawing.whole();
  }

  play() { this.#viewer?.player.play(true); }
  pause() { this.#viewer?.player.play(false); }
  get paused() { return !this.#viewer?.player.isPlaying; }

  /** Moves the camera so that all is seen. */
  fit() { this.#viewer?.fitCamera(); }

  /** The file, and a hyperplane: that of a time, of a text as the attribute has it, or the one that is shown. */
  async #section(at) {
    await this.#opening;
    const { state, panes: [pane] } = this.#viewer?.model ?? { panes: [] };
    if (!pane) throw new Error('no file is open');
    const asked = at === undefined ? {} : typeof at === 'number' ? { cut: 't', t: at } : attributes.hyperplane.state(at);
    if (!asked) throw new Error(`'${at}': expected a time, or ${attributes.hyperplane.expected}`);
    return [pane, this.#viewer.model.plane({ ...state, ...asked })];
  }

  /**
   * The section of each body that is shown, as a triangle mesh with its measures, in double precision.
   * @param {number|string} [at] a time, or a hyperplane as its attribute has it; by default what is shown
   */
  async slice(at) {
    return this.#viewer.sectionsOf(...await this.#section(at), true);
  }

  /** The measures of slice(), all bodies together: { triangles, vertices, volume, area }. */
  async measure(at) {
    const sections = await this.#viewer.sectionsOf(...await this.#section(at), false);
    const sum = (key) => sections.reduce((total, section) => total + section[key], 0);
    return { triangles: sum('numTriangles'), vertices: sum('numPoints'), volume: sum('volume'), area: sum('area') };
  }

  /** The section as a .glb, in float32; null of an empty one. */
  async toGlb(at) {
    const bytes = await this.#viewer.glbOf(...await this.#section(at));
    return bytes && new Blob([bytes], { type: 'model/gltf-binary' });
  }

  /** The picture, by default as PNG. */
  async toBlob(type, quality) {
    await this.drawn();
    this.#viewer.drawing.draw();
    return new Promise((resolve) => { this.#viewer.find('canvas').toBlob(resolve, type, quality); });
  }

  /** The first and the last time of what is shown. */
  get begin() { return this.#bound('min'); }
  get end() { return this.#bound('max'); }
  #bound(which) {
    const { panes, bounds } = this.#viewer?.model ?? { panes: [] };
    return panes.length > 0 ? bounds[which][3] : NaN;
  }

  /** What is shown, as a text; while nothing is, what the attribute says. */
  #text(name) {
    const { model } = this.#viewer ?? {};
    return model?.panes.length > 0 ? attributes[name].text(model) : this.getAttribute(name);
  }

  #put(name, text) {
    if (text === null || text === undefined) this.removeAttribute(name);
    else this.setAttribute(name, text);
  }

  get time() { return Number(this.#text('time') ?? NaN); }
  set time(time) { this.#put('time', time); }
  get hyperplane() { return this.#text('hyperplane') ?? 't'; }
  set hyperplane(text) { this.#put('hyperplane', text); }
  get color() { return this.#text('color') ?? 'body'; }
  set color(text) { this.#put('color', text); }
  get view() { return this.#text('view') ?? ''; }
  set view(text) { this.#put('view', text); }
  get camera() {
    const { model } = this.#viewer ?? {};
    return model?.state.camera ?? null;
  }
  set camera(numbers) { this.#put('camera', numbers && Array.from(numbers).join()); }
  get bodies() { return this.#viewer ? shownBodies(this.#viewer.model) : []; }
  set bodies(names) { this.#put('bodies', names && JSON.stringify(names)); }
  get src() { return this.getAttribute('src'); }
  set src(address) { this.#put('src', address); }
  get compare() { return this.getAttribute('compare'); }
  set compare(address) { this.#put('compare', address); }
  get tracks() { return this.getAttribute('tracks'); }
  set tracks(address) { this.#put('tracks', address); }
  get controls() { return this.hasAttribute('controls'); }
  set controls(on) { this.toggleAttribute('controls', on); }
  get autoplay() { return this.hasAttribute('autoplay'); }
  set autoplay(on) { this.toggleAttribute('autoplay', on); }
}

// A page may have the script twice.
if (!customElements.get('t4d-view')) customElements.define('t4d-view', T4dView);
