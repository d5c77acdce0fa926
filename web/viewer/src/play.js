// Moves the slider.

export class Player {
  /**
   * @param {import('./model.js').Model} model
   * @param {() => void} onChange called when play begins or ends
   */
  constructor(model, onChange) {
    Object.assign(this, { model, onChange, isPlaying: false });
    /** The direction in which the slider moved last: 1 or -1. Play moves it forward. */
    this.direction = 1;
  }

  setDirection(change) {
    this.direction = change < 0 ? -1 : 1;
  }

  /** Moves the slider by so many seconds of play. */
  advance(seconds) {
    const { model, model: { state, sliderKey: key } } = this;
    const [low, high] = model.sliderRange();
    const isRealTime = state.cut === 't' && model.unitOf('time_unit') === 's';
    const rate = (isRealTime ? 1 : (high - low) / 10) * state.speed;
    let value = state[key] + rate * seconds;
    if (value > high) {
      if (state.loop) {
        value = low + (value - low) % (high - low);
      } else {
        value = high;
        this.play(false);
      }
    }
    this.setDirection(1);
    model.set({ [key]: value });
  }

  /** Begins or ends. */
  play(on) {
    const { model, model: { state, sliderKey: key } } = this;
    const [low, high] = model.sliderRange();
    this.isPlaying = on && high > low;
    if (this.isPlaying && state[key] >= high) model.set({ [key]: low });
    this.onChange();
  }

  /** Moves the slider by steps, or to the next mark. */
  step(steps, byMarks) {
    const { model, model: { state, sliderKey: key } } = this;
    const [low, high] = model.sliderRange();
    let value = state[key] + steps * (high - low) / 200;
    if (byMarks && key === 't') {
      const times = model.marks();
      value = (steps > 0 ? times.find((time) => time > state.t) : times.findLast((time) => time < state.t)) ?? state.t;
    }
    this.setDirection(steps);
    model.slideTo(value);
  }
}
