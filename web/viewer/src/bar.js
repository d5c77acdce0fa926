// The time bar: play, the slider with the marks of slabs, its value, speed and loop.

export class Bar {
  /** @param {import('./viewer.js').Viewer} viewer */
  constructor(viewer) {
    this.viewer = viewer;
    this.listen();
  }

  listen() {
    const { model, player, find } = this.viewer;
    find('slider').oninput = () => {
      const value = find('slider').valueAsNumber;
      player.setDirection(value - model.state[model.sliderKey]);
      model.set({ [model.sliderKey]: value });
    };
    find('value').onchange = () => {
      const input = find('value');
      if (Number.isFinite(input.valueAsNumber)) model.slideTo(input.valueAsNumber);
      // The text is set even while the input is focused.
      input.value = Number(model.state[model.sliderKey].toPrecision(9));
    };
    find('speed').onchange = () => model.set({ speed: Number(find('speed').value) });
    find('loop').onchange = () => model.set({ loop: find('loop').checked });
    find('play').onclick = () => player.play(!player.isPlaying);
  }

  /** Shows the state of the model. */
  fill() {
    const { model, model: { state, sliderKey: key }, player, find, root } = this.viewer;
    const isEmpty = model.panes.length === 0;
    for (const control of root.querySelectorAll('#time :is(button, input, select)')) control.disabled = isEmpty;
    find('play').textContent = player.isPlaying ? '❚❚' : '▶';
    find('play').setAttribute('aria-pressed', player.isPlaying);
    find('speed').value = String(state.speed);
    find('loop').checked = state.loop;
    const [low, high] = model.sliderRange();
    const slider = find('slider');
    slider.min = low;
    slider.max = high;
    slider.value = state[key];
    slider.disabled = isEmpty || state.cut === 'solid';
    const value = find('value');
    if (root.activeElement !== value) value.value = Number(state[key].toPrecision(9));
    find('axisName').textContent = state.cut === 'any' ? 'offset' : key;
    find('unit').textContent = model.unitOf({ t: 'time_unit', x: 'length_unit', y: 'length_unit', z: 'length_unit' }[key]);
    this.drawMarks();
  }

  /** Marks the begin and the end of the slabs on the time line. */
  drawMarks() {
    const { model, find } = this.viewer;
    const canvas = find('marks');
    const width = canvas.clientWidth * devicePixelRatio;
    const style = getComputedStyle(canvas).color;
    const key = JSON.stringify([model.sliderKey, width, style, model.panes.map(({ info }) => info.file)]);
    if (canvas.dataset.key === key) return;
    canvas.dataset.key = key;
    canvas.width = width;
    canvas.height = canvas.clientHeight * devicePixelRatio;
    if (model.sliderKey !== 't') return;
    const context = canvas.getContext('2d');
    const [low, high] = model.sliderRange();
    context.fillStyle = style;
    context.globalAlpha = 0.5;
    // The thumb of a slider keeps this far from its ends.
    const margin = 8 * devicePixelRatio;
    const times = model.marks();
    const height = times.length > width / 4 ? 0.35 : 0.7;
    for (const time of times) {
      const x = margin + (width - 2 * margin) * (time - low) / (high - low || 1);
      context.fillRect(x, canvas.height * (1 - height), 1, canvas.height * height);
    }
  }
}
