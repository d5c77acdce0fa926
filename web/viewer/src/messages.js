// The box for what went wrong.

export class Messages {
  /**
   * @param {HTMLElement} box
   * @param {import('./model.js').Model} model
   */
  constructor(box, model) {
    /** `of`: what was shown when the message came. */
    Object.assign(this, { box, model, of: '' });
  }

  /** What is shown, but for the camera and the looks that no message is about. */
  get key() {
    const { state, sliderKey } = this.model;
    return JSON.stringify([state.cut, state[sliderKey], state.normal, state.hidden, state.color, state.drop]);
  }

  say(...lines) {
    const { box } = this;
    box.replaceChildren(...lines.map((line) => Object.assign(document.createElement('p'), { textContent: line })));
    const close = Object.assign(document.createElement('button'), { textContent: 'Close' });
    close.onclick = () => this.hide();
    box.append(close);
    box.hidden = false;
    this.of = this.key;
  }

  hide() {
    this.box.hidden = true;
  }

  /** Whether there was a message about what is shown, also if it was closed. */
  get wasSaid() {
    return this.of === this.key;
  }

  hideOld() {
    if (!this.wasSaid) this.hide();
  }
}
