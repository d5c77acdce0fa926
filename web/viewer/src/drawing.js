// Draws what the model says.

/** If a picture takes longer, sketches are drawn while the camera moves, and while another is waited for. */
const slowMilliseconds = 100;

/** The camera rests after this many milliseconds without a move. */
const restMilliseconds = 250;

export class Drawing {
  /** @param {import('./viewer.js').Viewer} viewer */
  constructor(viewer) {
    Object.assign(this, {
      viewer,
      /** Whether the picture shows the whole state of the model. */
      isWhole: false,
      isDirty: true,
      hasArrivals: false,
      drawnAt: 0,
      /** What it takes to draw the picture, but for sketches in its place. */
      milliseconds: 0,
      /** Whether the camera moves, where the picture does not follow. */
      isMoving: false,
      restTimer: 0,
    });
  }

  get isSlow() {
    return this.milliseconds > slowMilliseconds;
  }

  invalidate() {
    this.isDirty = true;
  }

  /** The camera has moved. */
  onMove() {
    this.isDirty = true;
    this.isMoving = this.isSlow;
    clearTimeout(this.restTimer);
    if (!this.isMoving) return;
    this.restTimer = setTimeout(() => {
      this.isMoving = false;
      this.isDirty = true;
    }, restMilliseconds);
  }

  /** More of the same has come: drawn now and then, so that drawing does not hold up the rest, but a picture at once. */
  onArrival({ isPicture = false } = {}) {
    this.hasArrivals = true;
    this.isDirty ||= isPicture;
  }

  /** The numbers at the ends of the ramp of colours; null where colours are no numbers. */
  colorRange() {
    const { model, model: { panes, bounds, state: { color, cut } }, comparison } = this.viewer;
    // The solid in space-time has attributes of whole numbers only.
    if (panes.length === 0 || (cut === 'solid' && color.startsWith('attribute:'))) return null;
    if (color === 'time') return [bounds.min[3], bounds.max[3]];
    if (color === 'age') return [0, model.longestLife()];
    if (model.showsDistances()) return [0, comparison.largest];
    const ranges = panes.flatMap((pane) => pane.rangesOf(color));
    const [low, high] = [Math.min(...ranges.map(([least]) => least)), Math.max(...ranges.map(([, most]) => most))];
    return low <= high ? [low, high] : null;
  }

  lookOf(pane, colors) {
    const { model } = this.viewer;
    const { color, wire } = model.state;
    const [mode, name] = color.startsWith('attribute:') ? ['attribute', color.slice('attribute:'.length)] : [color];
    const begin = pane.center[3];
    // Times are relative to the middle; of bodies, age is time from their begin on.
    const rangeOfBody = (body) => {
      const origin = { time: -begin, age: body.begin - begin }[mode] ?? 0;
      return (colors ?? [0, 1]).map((value) => value + origin);
    };
    return { mode, name, rangeOfBody, wireframe: wire, tracks: model.tracks };
  }

  /** The planes that are shown: that of the state, then those of the onion skin. */
  planes() {
    const { model, model: { state, sliderKey: key } } = this.viewer;
    const planes = [{ plane: model.plane(), opacity: 1 }];
    if (state.cut === 'any') return planes;
    for (let i = 1; i <= state.onion; ++i) {
      for (const side of [-1, 1]) {
        planes.push({
          plane: model.plane({ ...state, [key]: state[key] + side * i * state.onionStep }),
          opacity: 0.35 * (1 - (i - 1) / (state.onion + 1)),
        });
      }
    }
    return planes;
  }

  /** Asks the panes for what the model says. */
  update() {
    const { model, model: { state }, comparison } = this.viewer;
    this.hasArrivals = false;
    const hidden = new Set(state.hidden);
    if (model.showsDistances()) {
      this.isWhole = comparison.update(hidden, () => {
        this.onArrival();
        this.viewer.emit('compared');
      });
    } else {
      comparison.shown = null;
      const before = this.colorRange();
      this.showPanes(hidden, before);
      // The slabs that are shown give the range of speeds and attributes.
      const range = this.colorRange();
      if (JSON.stringify(range) !== JSON.stringify(before)) this.showPanes(hidden, range);
    }
    this.viewer.find('busy').hidden = this.isWhole && this.viewer.numOpening === 0;
  }

  showPanes(hidden, range) {
    const { model, model: { state }, player } = this.viewer;
    this.isWhole = true;
    const faces = state.cut === 'solid' ? model.facesAxes() : null;
    const planes = faces ? [] : this.planes();
    for (const pane of model.panes) {
      const what = { planes, timeScale: state.timeScale, hidden, look: this.lookOf(pane, range), faces };
      const isThere = pane.show(what);
      this.isWhole = isThere && this.isWhole;
      if (isThere && state.cut === 't') pane.prefetch(planes[0].plane, player.direction);
    }
  }

  draw() {
    const { model: { panes }, view } = this.viewer;
    this.isDirty = false;
    const isRough = this.isSlow && (this.isMoving || !this.isWhole);
    for (const pane of panes) pane.setRough(isRough);
    view.render(panes);
    this.drawnAt = performance.now();
    const begin = this.drawnAt;
    if (!isRough) view.whenDrawn(() => { this.milliseconds = performance.now() - begin; });
  }

  /** Draws what has changed; whether it has. */
  drawChanges() {
    if (!this.isDirty && !this.hasArrivals) return false;
    const isNew = this.isDirty;
    this.update();
    // Data that arrives is drawn when it is whole, or after a while.
    if (!isNew && !this.isWhole && performance.now() - this.drawnAt <= 3 * this.milliseconds + 100) return false;
    this.draw();
    return true;
  }

  /** Resolves when all that the model says is drawn. */
  async whole() {
    do {
      await new Promise((resolve) => { requestAnimationFrame(resolve); });
    } while (!this.viewer.isEnded && (this.isDirty || this.hasArrivals || !this.isWhole || this.isMoving));
  }
}
