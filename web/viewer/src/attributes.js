// The attributes of an element that say what to show, as members of the state and back.
import { defaults, hashOf, stateOf } from './state.js';

const numbersOf = (text) => text.split(/[\s,]+/).map(Number);
const areFinite = (numbers) => numbers.every(Number.isFinite);

/** The names in a text, without a state: the names that the file has are known later. */
function namesOf(text) {
  if (!text.trim().startsWith('[')) return text.split(',').map((name) => name.trim()).filter(Boolean);
  try {
    return JSON.parse(text).map(String);
  } catch {
    return null;
  }
}

function cutOf(text) {
  if (/^(t|x|y|z)$/.test(text)) return { cut: text };
  if (text === 'motion') return { cut: 'solid' };
  const [, axis, value] = /^([xyz])\s*=\s*(\S+)$/.exec(text) ?? [];
  if (axis && Number.isFinite(Number(value))) return { cut: axis, [axis]: Number(value) };
  const [offset, ...normal] = numbersOf(text).reverse();
  const isPlane = normal.length === 4 && areFinite([...normal, offset]) && normal.some((each) => each !== 0);
  return isPlane ? { cut: 'any', normal: normal.reverse(), offset } : null;
}

/**
 * By their names: `state(text, model)` gives what a text asks for, null where it makes no sense, of which `expected` is
 * what does; `text(model)` gives what is shown, and `unset` what is if there is no such attribute any more.
 */
export const attributes = {
  view: {
    expected: 'what follows # in a link of the page of t4d view',
    state: (text) => stateOf(text),
    text: ({ state, base }) => hashOf(state, base),
    unset: {},
  },
  hyperplane: {
    expected: 't, x=V, y=V, z=V, motion, or the five numbers NX,NY,NZ,NT,OFFSET',
    state: cutOf,
    text: ({ state: { cut, normal, offset, ...at } }) =>
      (cut === 'any' ? [...normal, offset].join() : cut === 'solid' ? 'motion' : cut === 't' ? 't' : `${cut}=${at[cut]}`),
    unset: { cut: 't' },
  },
  time: {
    expected: 'a number',
    state: (text) => (text.trim() !== '' && Number.isFinite(Number(text)) ? { t: Number(text) } : null),
    text: ({ state: { t } }) => String(t),
    unset: {},
  },
  bodies: {
    expected: 'names of bodies with commas between, or a JSON array of them',
    state(text, model) {
      const names = namesOf(text);
      const all = model.bodies().map(({ name }) => name);
      const missing = names?.find((name) => !all.includes(name));
      if (missing !== undefined) throw new Error(`there is no body '${missing}', but ${all.map((name) => `'${name}'`).join(', ')}`);
      return names && { hidden: all.filter((name) => !names.includes(name)) };
    },
    text: (model) => JSON.stringify(shownBodies(model)),
    unset: { hidden: [] },
  },
  color: {
    expected: 'body, time, age, speed, track, distance, or attribute:NAME',
    state(text) {
      const { color } = stateOf(new URLSearchParams({ color: text }).toString());
      return color ? { color } : null;
    },
    text: ({ state: { color } }) => color,
    unset: { color: defaults.color },
  },
  camera: {
    expected: 'six numbers, the position of the camera and what it looks at',
    state(text) {
      const camera = numbersOf(text.trim());
      return camera.length === 6 && areFinite(camera) ? { camera } : null;
    },
    text: ({ state: { camera } }) => (camera ?? []).join(),
    unset: { camera: null },
  },
};

/** The names of the bodies that are shown. */
export const shownBodies = (model) =>
  [...new Set(model.bodies().map(({ name }) => name))].filter((name) => !model.state.hidden.includes(name));

/**
 * What an attribute asks for.
 * @param {string|null} text
 * @throws {Error} where it makes no sense, once all files are open
 */
export function askedBy(name, text, model) {
  const { state, unset, expected } = attributes[name];
  if (text === null) return unset;
  let asked;
  let why = `expected ${expected}`;
  try {
    asked = state(text, model);
  } catch (error) {
    why = error.message;
  }
  if (!asked && model.areAllOpen) throw new Error(`${name}="${text}": ${why}`);
  return asked ?? {};
}
