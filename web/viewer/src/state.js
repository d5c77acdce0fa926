// The state of the page, and its form in a link.

export const defaults = {
  cut: 't', // t, x, y, z, any, or solid
  t: 0, x: 0, y: 0, z: 0, // where it cuts
  normal: [1, 0, 0, 0], offset: 0, // of any hyperplane
  drop: 'z', // of the solid in space-time: the axis that time takes the place of
  timeScale: 1, // length that a unit of time is shown as
  color: 'body', // body, time, age, speed, track, distance (from the other file), or attribute:NAME
  wire: false,
  onion: 0, // slices before and after
  onionStep: 1,
  speed: 1,
  loop: true,
  hidden: [], // names of bodies
  camera: null, // position and target
};

/** The members that differ from the defaults, as the part of a link behind #. */
export function hashOf(state, base) {
  const params = new URLSearchParams();
  for (const [key, value] of Object.entries(defaults)) {
    const now = state[key];
    if (now === null || JSON.stringify(now) === JSON.stringify(base[key] ?? value)) continue;
    params.set(key, typeof now === 'string' ? now : JSON.stringify(now));
  }
  return params.toString();
}

/** The members that a link says, those that make sense. */
export function stateOf(hash) {
  const state = {};
  for (const [key, text] of new URLSearchParams(hash.replace(/^#/, ''))) {
    const like = defaults[key];
    if (like === undefined) continue;
    if (typeof like === 'string') {
      state[key] = text;
      continue;
    }
    let value;
    try {
      value = JSON.parse(text);
    } catch {
      continue;
    }
    const isNumbers = (list, length) => Array.isArray(list) && list.length === length && list.every(Number.isFinite);
    const isRight = {
      normal: () => isNumbers(value, 4) && value.some((each) => each !== 0),
      camera: () => isNumbers(value, 6),
      // These are the values of the select boxes.
      speed: () => [0.1, 0.25, 0.5, 1, 2, 4, 10].includes(value),
      onion: () => [0, 1, 2, 4].includes(value),
      onionStep: () => Number.isFinite(value) && value > 0,
      timeScale: () => Number.isFinite(value) && value > 0,
      hidden: () => Array.isArray(value) && value.every((each) => typeof each === 'string'),
    }[key] ?? (() => typeof value === typeof like && (typeof value !== 'number' || Number.isFinite(value)));
    if (isRight()) state[key] = value;
  }
  if (state.cut && !['t', 'x', 'y', 'z', 'any', 'solid'].includes(state.cut)) delete state.cut;
  if (state.drop && !['x', 'y', 'z'].includes(state.drop)) delete state.drop;
  if (state.color && !/^(body|time|age|speed|track|distance|attribute:.+)$/s.test(state.color)) delete state.color;
  return state;
}
