// The tracks of a report of `t4d track --json`: which one a component is, and its colour.

const linearOf = (value) => (value <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4);
const goldenRatio = (Math.sqrt(5) - 1) / 2;

/** The linear colour of a track, that of the program's pictures; grey for 0, which is none. */
export function trackColor(id) {
  if (id === 0) return [0.5, 0.5, 0.5];
  const hue = 6 * (id * goldenRatio % 1);
  return [0, 1, 2].map((i) => {
    const from = Math.abs((hue + 6 - 2 * i) % 6 - 3);
    return linearOf(0.35 + 0.55 * Math.min(1, Math.max(0, from - 1)));
  });
}

const boxOf = ({ min, max }) => [...min, ...max];
const distance = (a, b) => Math.max(...a.map((value, i) => Math.abs(value - b[i])));
const isWithin = (inner, outer) =>
  inner.min.every((value, i) => outer.min[i] <= value) && inner.max.every((value, i) => value <= outer.max[i]);

/** The box of a track at a time, between those of its samples; null without samples. */
function boxAt({ samples }, time) {
  if (samples.length === 0) return null;
  const next = samples.findIndex((sample) => sample.time >= time);
  if (next <= 0) return boxOf(samples.at(next));
  const [before, after] = [samples[next - 1], samples[next]];
  const share = (time - before.time) / (after.time - before.time);
  const last = boxOf(after);
  return boxOf(before).map((value, i) => value + share * (last[i] - value));
}

export class Tracks {
  /** @throws {Error} if it is no such report */
  constructor(report) {
    const { tracks, events } = report ?? {};
    if (!Array.isArray(tracks) || !Array.isArray(events)) throw new Error('no report of t4d track --json');
    this.events = events;
    this.ofBodies = new Map();
    for (const track of tracks) {
      if (!this.ofBodies.has(track.body)) this.ofBodies.set(track.body, []);
      this.ofBodies.get(track.body).push(track);
    }
  }

  /**
   * The ids of the tracks of components of a body at a time: each has the box that is nearest to that of its track, and
   * no two have one track. A cavity has that of the smallest solid around it.
   */
  idsOf(body, components, time) {
    const ids = components.map(() => 0);
    const alive = (this.ofBodies.get(body) ?? []).filter(({ kind, begin, end }) =>
      kind === 'solid' && begin <= time && time <= end);
    const pairs = alive.flatMap(({ id, ...track }) => {
      const box = boxAt(track, time);
      return !box ? [] : components.flatMap((component, i) =>
        (component.volume < 0 ? [] : [{ id, i, apart: distance(box, boxOf(component)) }]));
    }).sort((a, b) => a.apart - b.apart);
    const taken = new Set();
    for (const { id, i } of pairs) {
      if (ids[i] !== 0 || taken.has(id)) continue;
      ids[i] = id;
      taken.add(id);
    }
    components.forEach((component, i) => {
      if (component.volume >= 0) return;
      const around = components.map((outer, k) => ({ outer, k }))
        .filter(({ outer }) => outer.volume >= 0 && isWithin(component, outer))
        .sort((a, b) => a.outer.volume - b.outer.volume);
      if (around.length > 0) ids[i] = ids[around[0].k];
    });
    return ids;
  }
}
