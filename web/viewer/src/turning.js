// Actions of the pointer besides moving the camera.
import { shownAxes } from './pane.js';

/** Whether the page that the view is in can be scrolled. */
const canScroll = ({ scrollHeight, clientHeight }) => scrollHeight > clientHeight;

/** @param {import('./viewer.js').Viewer} viewer */
export function listenToPointer({ find, root, model }) {
  const canvas = find('canvas');
  // In a page that scrolls, the wheel is the page's until the view is clicked.
  canvas.addEventListener('wheel', (event) => {
    if (root.activeElement !== canvas && canScroll(document.scrollingElement)) event.stopImmediatePropagation();
  }, { capture: true });
  // Shift turns the hyperplane: across about its first axis and time, up and down about its second.
  let turning = null;
  canvas.addEventListener('pointerdown', (event) => {
    if (model.state.cut !== 'any' || !event.shiftKey) return;
    event.stopImmediatePropagation();
    canvas.setPointerCapture(event.pointerId);
    turning = [event.clientX, event.clientY];
  }, { capture: true });
  canvas.addEventListener('pointermove', (event) => {
    if (!turning) return;
    const { axes } = shownAxes(model.plane(), 1);
    const [dx, dy] = [(event.clientX - turning[0]) / 200, (turning[1] - event.clientY) / 200];
    turning = [event.clientX, event.clientY];
    const { normal } = model.state;
    const length = Math.hypot(...normal);
    model.turnTo(normal.map((n, i) => n / length + dx * axes[0][i] + dy * axes[1][i]));
  }, { capture: true });
  for (const type of ['pointerup', 'pointercancel']) {
    canvas.addEventListener(type, () => { turning = null; }, { capture: true });
  }
}
