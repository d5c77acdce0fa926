// What the page shows, which all of its parts read. Whoever changes it calls one of the functions here.
import { Client } from './client.js';
import { defaults, stateOf } from './state.js';

/* global WORKER_CODE */
export const client = new Client(WORKER_CODE);

/** Of each file that is shown. */
export const panes = [];
export let state = { ...defaults };
/** The state in which the first file was opened, which a link leaves out. */
export let base = { ...defaults };
export let bounds = { min: [0, 0, 0, 0], max: [1, 1, 1, 1] };
/** Slabs on the GPU are relative to this. */
export let center = [0, 0, 0, 0];
/** Whether the files are open that the page was asked for. */
export let areAllOpen = false;

let listener = () => {};

/** Calls the listener after each change, with the state before. */
export function onChange(call) {
  listener = call;
}

/** The page follows what has changed. */
export function changed(before = state) {
  listener(before);
}

/** Changes the state. */
export function set(changes) {
  const before = state;
  state = { ...state, ...changes };
  changed(before);
}

/** Changes the state to that of the link. */
export function restore() {
  state = { ...base, ...stateOf(location.hash) };
  if (areAllOpen) clamp();
}

/** A slice of a file, by the worker. */
export async function sliceOf({ file, name }, { normal, offset }, meshes = false) {
  try {
    return await client.call('slice', { file, normal, offset, meshes });
  } catch (error) {
    error.message = `${name}: ${error.message}`;
    throw error;
  }
}

/** Whether the files have the same unit of this kind: `length_unit` or `time_unit`. */
const agreeOn = (kind) => panes.every(({ info }) => info.head[kind] === panes[0].info.head[kind]);
export const haveOneUnit = () => agreeOn('length_unit') && agreeOn('time_unit');

/** The unit of this kind that all files have, or ''. */
export const unitOf = (kind) => (agreeOn(kind) ? panes[0]?.info.head[kind] ?? '' : '');

/** The panes have changed. */
export function measureBounds() {
  const all = panes.map((pane) => pane.bounds());
  bounds = {
    min: all[0].min.map((_, i) => Math.min(...all.map(({ min }) => min[i]))),
    max: all[0].max.map((_, i) => Math.max(...all.map(({ max }) => max[i]))),
  };
}

/** Shows the only file: as the link says, or from its beginning if it replaces another. */
export function begin({ head }, isReplacing) {
  center = bounds.min.map((low, i) => (low + bounds.max[i]) / 2);
  const [width, depth, height, time] = bounds.max.map((high, i) => high - bounds.min[i]);
  const size = Math.max(width, depth, height);
  const timeScale = size > 0 && time > 0 ? Number((size / time).toPrecision(2)) : 1;
  const [x, y, z] = center;
  base = {
    ...defaults, t: bounds.min[3], x, y, z, offset: x, timeScale,
    onionStep: Number(((time || 1) / 20).toPrecision(2)), drop: head.up === 'z' ? 'y' : 'z',
  };
  state = { ...base };
  if (!isReplacing) restore();
}

export function setAllOpen() {
  areAllOpen = true;
  clamp();
}

/** The member of the state that the slider moves. */
export const sliderKey = () => (state.cut === 'any' ? 'offset' : state.cut === 'solid' ? 't' : state.cut);

/** The offsets of the hyperplanes of this normal that meet what is shown. */
function offsetRange(normal) {
  const terms = normal.map((n, i) => [n * bounds.min[i], n * bounds.max[i]].sort((a, b) => a - b));
  return [0, 1].map((k) => terms.reduce((sum, term) => sum + term[k], 0));
}

/** The values of x, y, z, t or offset that cut what is shown. */
function rangeOf(key) {
  if (key === 'offset') return offsetRange(state.normal);
  const axis = ['x', 'y', 'z', 't'].indexOf(key);
  return [bounds.min[axis], bounds.max[axis]];
}

/** The nearest value that cuts what is shown. */
function within(key, value) {
  const [low, high] = rangeOf(key);
  return Math.min(high, Math.max(low, value));
}

/** The values between which the slider moves. */
export const sliderRange = () => rangeOf(sliderKey());

/** Moves the slider to the value, or as far as it goes. */
export function slideTo(value) {
  set({ [sliderKey()]: within(sliderKey(), value) });
}

/** Keeps the state to what the files have. */
function clamp() {
  if (panes.length !== 2 && state.color === 'distance') state = { ...state, color: 'body' };
  for (const key of ['x', 'y', 'z', 't', 'offset']) state = { ...state, [key]: within(key, state[key]) };
}

/** The axes of the solid in space-time, time in the place of one, the others in order. */
export function facesAxes() {
  const dropped = ['x', 'y', 'z'].indexOf(state.drop);
  const kept = [0, 1, 2].filter((i) => i !== dropped);
  const unit = (i, length = 1) => [0, 1, 2, 3].map((k) => (k === i ? length : 0));
  return { axes: [unit(kept[0]), unit(kept[1]), unit(3, state.timeScale)], names: [...kept.map((i) => 'xyz'[i]), 't'] };
}

export const isSpace = () => state.cut === 't';

/** Of all bodies. */
export const longestLife = () => Math.max(...panes.flatMap(({ info }) => info.bodies.map(({ begin, end }) => end - begin)));

/** The times at which slabs begin or end. */
export const marks = () => [...new Set(panes.flatMap(({ info }) =>
  info.bodies.flatMap(({ slabs }) => slabs.flatMap(({ begin, end }) => [begin, end]))))].sort((a, b) => a - b);


/** Turns the hyperplane about the middle of what it cuts. */
export function turnTo(normal) {
  const [low, high] = offsetRange(state.normal);
  const share = high > low ? (state.offset - low) / (high - low) : 0.5;
  const [nextLow, nextHigh] = offsetRange(normal);
  set({ normal, offset: nextLow + share * (nextHigh - nextLow) });
}
