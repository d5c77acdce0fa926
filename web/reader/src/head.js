import { check } from './invalid.js';

const knownFeatures = ['zstd', 'means', 'pose', 'grid'];

const utf8 = new TextDecoder('utf-8', { fatal: true, ignoreBOM: true });
const bytesIn = (value) => new TextEncoder().encode(value);

/** Text from UTF-8. */
export function textOf(bytes, at, rule) {
  try {
    return utf8.decode(bytes);
  } catch {
    return check(false, at, rule, 'not UTF-8');
  }
}

/** Whether the value is a name of a body or an attribute. Only well-formed text survives UTF-8 unchanged. */
export const isName = (value) => typeof value === 'string' && utf8.decode(bytesIn(value)) === value
  && bytesIn(value).length >= 1 && bytesIn(value).length <= 255
  && !/[\0-\x1f\x7f-\x9f/\u061c\u200e\u200f\u202a-\u202e\u2066-\u2069]/.test(value);

const isObject = (value) => typeof value === 'object' && value !== null && !Array.isArray(value);
const member = (object, name) => (Object.hasOwn(object, name) ? object[name] : undefined);

/** Checks the members of bodies beside their names (M11). */
function checkBodies(bodies, names, at) {
  const parents = new Map();
  bodies.forEach((body, i) => {
    const of = (key) => member(body, key);
    for (const key of ['material', 'parent']) {
      check(['string', 'undefined'].includes(typeof of(key)), at, 'M11', `type of ${key}`);
    }
    const color = of('color') === undefined ? [0, 0, 0] : of('color');
    check(Array.isArray(color) && [3, 4].includes(color.length)
      && color.every((part) => typeof part === 'number' && part >= 0 && part <= 1), at, 'M11', 'color');
    check(of('details') === undefined || isObject(of('details')), at, 'M11', 'type of details');
    if (of('parent') !== undefined) parents.set(names[i], of('parent'));
  });
  const known = new Set(names);
  const rooted = new Set(names.filter((name) => !parents.has(name)));
  for (const name of names) {
    const path = [name];
    while (!rooted.has(path.at(-1))) {
      path.push(parents.get(path.at(-1)));
      check(known.has(path.at(-1)) && path.length <= names.length, at, 'M11', `parent of ${name}`);
    }
    path.forEach((each) => rooted.add(each));
  }
}

/**
 * HEAD, checked.
 * @param {Uint8Array} bytes its payload
 * @param {number} at its offset
 * @returns {{features: string[], bodies: {name: string}[], grid?: {origin: number[], step: number}}} with
 *   the other members as they are
 */
export function parseHead(bytes, at) {
  check(bytes.length <= 16 << 20, at, 'M1', 'HEAD above 16 MiB');
  const json = textOf(bytes, at, 'M2');
  check(!json.startsWith('\ufeff'), at, 'M2', 'byte order mark');
  let head;
  try {
    head = JSON.parse(json);
  } catch (error) {
    check(false, at, 'M3', error.message);
  }
  check(isObject(head), at, 'M3', 'no JSON object');
  let level = [head];
  for (let depth = 1; level.length > 0; ++depth) {
    check(depth <= 64, at, 'M4', 'nested more than 64 deep');
    level = level.flatMap((each) => Object.values(each))
      .filter((value) => typeof value === 'object' && value !== null);
  }
  const features = member(head, 'features');
  check(Array.isArray(features) && features.every((each) => typeof each === 'string'), at, 'M5',
    'features is no array of strings');
  for (const each of features) {
    check(knownFeatures.includes(each), at, 'M6', `this reader does not know the feature ${each}`);
  }
  const bodies = member(head, 'bodies');
  check(Array.isArray(bodies) && bodies.every(isObject), at, 'M7', 'bodies is no array of objects');
  check(bodies.length >= 1 && bodies.length <= 65536, at, 'M7', `${bodies.length} bodies`);
  const names = bodies.map((body) => member(body, 'name'));
  for (const name of names) check(isName(name), at, 'M8', `name ${JSON.stringify(name)}`);
  check(new Set(names).size === names.length, at, 'M9', 'two bodies of one name');
  checkBodies(bodies, names, at);
  for (const name of ['generator', 'backend', 'length_unit', 'time_unit', 'up']) {
    check(['string', 'undefined'].includes(typeof member(head, name)), at, 'M10', `type of ${name}`);
  }
  check(['y', 'z', undefined].includes(member(head, 'up')), at, 'M10', 'up is neither y nor z');
  const details = member(head, 'details');
  check(details === undefined || isObject(details), at, 'M10', 'type of details');
  const grid = member(head, 'grid');
  if (grid !== undefined || features.includes('grid')) {
    const { origin, step } = grid ?? {};
    check(Array.isArray(origin) && origin.length === 3 && [...origin, step].every(Number.isFinite)
      && step > 0, at, 'M10', 'origin or step of the grid');
  }
  return { ...head, grid: features.includes('grid') ? grid : undefined };
}
