// Moves the slider.
import { element } from './common.js';
import { marks, set, sliderKey, sliderRange, slideTo, state, unitOf } from './page.js';

export let isPlaying = false;
/** Where the slider moved last: 1 or -1. Play moves it forward. */
export let direction = 1;

export function setDirection(change) {
  direction = change < 0 ? -1 : 1;
}

/** Moves the slider by so many seconds of play. */
export function advance(seconds) {
  const key = sliderKey();
  const [low, high] = sliderRange();
  const isRealTime = state.cut === 't' && unitOf('time_unit') === 's';
  const rate = (isRealTime ? 1 : (high - low) / 10) * state.speed;
  let value = state[key] + rate * seconds;
  if (value > high) {
    if (state.loop) {
      value = low + (value - low) % (high - low);
    } else {
      value = high;
      play(false);
    }
  }
  setDirection(1);
  set({ [key]: value });
}

/** Begins or ends. */
export function play(on) {
  const [low, high] = sliderRange();
  isPlaying = on && high > low;
  if (isPlaying && state[sliderKey()] >= high) set({ [sliderKey()]: low });
  element('play').textContent = isPlaying ? '❚❚' : '▶';
  element('play').setAttribute('aria-pressed', isPlaying);
}

/** Moves the slider by steps, or to the next mark. */
export function step(steps, byMarks) {
  const key = sliderKey();
  const [low, high] = sliderRange();
  let value = state[key] + steps * (high - low) / 200;
  if (byMarks && key === 't') {
    const times = marks();
    value = (steps > 0 ? times.find((time) => time > state.t) : times.findLast((time) => time < state.t)) ?? state.t;
  }
  setDirection(steps);
  slideTo(value);
}
