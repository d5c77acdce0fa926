// What one view shows: the files, and how. Everything that draws, or has controls, reads it here.
import { hyperplane } from 't4d-reader';

import { units4 } from './common.js';
import { defaults } from './state.js';

export class Model {
  /** @param {(before: object) => void} onChange called after each change, with the state before */
  constructor(onChange) {
    Object.assign(this, {
      onChange,
      /** The panes: one for each file that is shown. */
      panes: [],
      state: { ...defaults },
      /** The state in which the first file was opened, which a link leaves out. */
      base: { ...defaults },
      bounds: { min: [0, 0, 0, 0], max: [1, 1, 1, 1] },
      /** The middle of the first file, which is that of the picture. */
      center: [0, 0, 0, 0],
      /** The tracks of the first file, or null. */
      tracks: null,
      /** Whether all files that were asked for are open. */
      areAllOpen: false,
    });
  }

  /** Lets everything that shows the model follow a change. */
  changed(before = this.state) {
    this.onChange(before);
  }

  /** Changes the state. */
  set(changes) {
    const before = this.state;
    this.state = { ...before, ...changes };
    this.changed(before);
  }

  /** Changes the state to what is asked for, as far as the files have it. */
  ask(changes) {
    const before = this.state;
    this.state = { ...before, ...changes };
    this.clamp();
    this.changed(before);
  }

  /** Shows what is asked for, and else what a file shows at first. */
  restore(asked) {
    this.state = { ...this.base, ...asked };
    if (this.areAllOpen) this.clamp();
  }

  /** Whether the files have the same unit of this kind: `length_unit` or `time_unit`. */
  agreeOn(kind) {
    return this.panes.every(({ info }) => info.head[kind] === this.panes[0].info.head[kind]);
  }

  haveOneUnit() {
    return this.agreeOn('length_unit') && this.agreeOn('time_unit');
  }

  /** The unit of this kind that all files have, or ''. */
  unitOf(kind) {
    return this.agreeOn(kind) ? this.panes[0]?.info.head[kind] ?? '' : '';
  }

  /** The panes have changed. */
  measureBounds() {
    const all = this.panes.map((pane) => pane.bounds());
    this.bounds = {
      min: all[0].min.map((_, i) => Math.min(...all.map(({ min }) => min[i]))),
      max: all[0].max.map((_, i) => Math.max(...all.map(({ max }) => max[i]))),
    };
  }

  /** Shows the only file: as is asked for, and else from its beginning. */
  begin({ center, info: { head } }, asked) {
    this.center = center;
    const { min, max } = this.bounds;
    const [width, depth, height, time] = max.map((high, i) => high - min[i]);
    const size = Math.max(width, depth, height);
    const timeScale = size > 0 && time > 0 ? Number((size / time).toPrecision(2)) : 1;
    const [x, y, z] = center;
    this.base = {
      ...defaults, t: min[3], x, y, z, offset: x, timeScale,
      color: this.tracks ? 'track' : defaults.color,
      onionStep: Number(((time || 1) / 20).toPrecision(2)), drop: head.up === 'z' ? 'y' : 'z',
    };
    this.restore(asked);
  }

  /** The hyperplane that a state says; the solid in space-time has that of its time. */
  plane({ cut, t, x, y, z, normal, offset } = this.state) {
    if (cut === 'any') return hyperplane(normal, offset);
    const axis = Math.max(0, ['t', 'x', 'y', 'z'].indexOf(cut));
    return hyperplane(units4[(axis + 3) % 4], [t, x, y, z][axis]);
  }

  /** The member of the state that the slider moves. */
  get sliderKey() {
    const { cut } = this.state;
    return cut === 'any' ? 'offset' : cut === 'solid' ? 't' : cut;
  }

  /** The offsets of the hyperplanes of this normal that meet what is shown. */
  offsetRange(normal) {
    const { min, max } = this.bounds;
    const terms = normal.map((n, i) => [n * min[i], n * max[i]].sort((a, b) => a - b));
    return [0, 1].map((k) => terms.reduce((sum, term) => sum + term[k], 0));
  }

  /** The values of x, y, z, t or offset that cut what is shown. */
  rangeOf(key) {
    if (key === 'offset') return this.offsetRange(this.state.normal);
    const axis = ['x', 'y', 'z', 't'].indexOf(key);
    return [this.bounds.min[axis], this.bounds.max[axis]];
  }

  /** The nearest value that cuts what is shown. */
  within(key, value) {
    const [low, high] = this.rangeOf(key);
    return Math.min(high, Math.max(low, value));
  }

  /** The values between which the slider moves. */
  sliderRange() {
    return this.rangeOf(this.sliderKey);
  }

  /** Moves the slider to the value, or as far as it goes. */
  slideTo(value) {
    const key = this.sliderKey;
    this.set({ [key]: this.within(key, value) });
  }

  /** Keeps the state to what the files have. */
  clamp() {
    const { color } = this.state;
    const isMissing = (color === 'distance' && this.panes.length !== 2) || (color === 'track' && !this.tracks);
    if (isMissing) this.state = { ...this.state, color: 'body' };
    for (const key of ['x', 'y', 'z', 't', 'offset']) {
      this.state = { ...this.state, [key]: this.within(key, this.state[key]) };
    }
  }

  /** The axes of the solid in space-time, time in the place of one, the others in order. */
  facesAxes() {
    const dropped = ['x', 'y', 'z'].indexOf(this.state.drop);
    const kept = [0, 1, 2].filter((i) => i !== dropped);
    const unit = (i, length = 1) => [0, 1, 2, 3].map((k) => (k === i ? length : 0));
    return {
      axes: [unit(kept[0]), unit(kept[1]), unit(3, this.state.timeScale)],
      names: [...kept.map((i) => 'xyz'[i]), 't'],
    };
  }

  /** Whether two solids are coloured by their distance from each other. */
  showsDistances() {
    return this.state.color === 'distance' && this.state.cut === 't' && this.panes.length === 2;
  }

  bodies() {
    return this.panes.flatMap(({ info }) => info.bodies);
  }

  longestLife() {
    return Math.max(...this.bodies().map(({ begin, end }) => end - begin));
  }

  /** The times at which slabs begin or end. */
  marks() {
    const times = this.bodies().flatMap(({ slabs }) => slabs.flatMap(({ begin, end }) => [begin, end]));
    return [...new Set(times)].sort((a, b) => a - b);
  }

  /** Turns the hyperplane about the middle of what it cuts. */
  turnTo(normal) {
    const [low, high] = this.offsetRange(this.state.normal);
    const share = high > low ? (this.state.offset - low) / (high - low) : 0.5;
    const [nextLow, nextHigh] = this.offsetRange(normal);
    this.set({ normal, offset: nextLow + share * (nextHigh - nextLow) });
  }
}
