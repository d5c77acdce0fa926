// Two solids coloured by their distance from each other.

export class Comparison {
  /**
   * @param {import('./model.js').Model} model
   * @param {(error: Error) => void} onError
   */
  constructor(model, onError) {
    /** The distances of the two solids at a time that are shown, or asked for. */
    Object.assign(this, { model, onError, asked: null, shown: null, largest: 0 });
  }

  /**
   * Colours two solids by their distance from each other; whether that is there. The one before stays meanwhile, and
   * onDone is called when it has come.
   */
  update(hidden, onDone) {
    const { model, model: { panes, state } } = this;
    const plane = model.plane();
    const files = panes.map(({ info }) => info.file);
    const key = JSON.stringify([plane.offset, state.hidden, files]);
    if (this.shown === key) return true;
    if (this.asked !== null) return false;
    this.asked = key;
    const { normal, offset } = plane;
    panes[0].file.client.call('distances', { files, normal, offset, hidden: state.hidden }).then((sections) => {
      if (!model.showsDistances()) return;
      const all = sections.flat().map(({ distances }) => distances ?? []);
      this.largest = all.reduce((most, each) => each.reduce((a, b) => Math.max(a, b || 0), most), 0);
      const look = { mode: 'distance', rangeOfBody: () => [0, this.largest] };
      panes.forEach((pane, i) => pane.showSections(sections[i], plane, state.timeScale, hidden, look));
      this.shown = key;
    }).catch((error) => {
      this.onError(error);
      this.shown = key;
    }).finally(() => {
      this.asked = null;
      onDone();
    });
    return false;
  }
}
