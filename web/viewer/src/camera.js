// The camera, which follows the space that is shown.
import { element } from './common.js';
import { bounds, facesAxes, isSpace, panes, state } from './page.js';
import { planeOf, shownAxes } from './pane.js';
import { View } from './view.js';

export const view = new View(element('canvas'), element('gizmo'), () => {
  state.camera = [...view.camera.position.toArray(), ...view.controls.target.toArray()];
});

const cutNames = {
  t: ['x', 'y', 'z'], x: ['y', 'z', 't'], y: ['x', 'z', 't'], z: ['x', 'y', 't'], any: ['u', 'v', 'w'],
};

export function fitCamera() {
  if (panes.length === 0) return;
  const { up } = panes[0].info.head;
  view.setUp(isSpace() ? up ?? 'y' : 'z');
  const axes = state.cut === 'solid' ? facesAxes().axes : shownAxes(planeOf(state), state.timeScale).axes;
  view.labels = state.cut === 'solid' ? facesAxes().names : cutNames[state.cut];
  const half = bounds.max.map((high, i) => (high - bounds.min[i]) / 2);
  const lengths = axes.map((axis) => axis.reduce((sum, part, i) => sum + Math.abs(part) * half[i], 0));
  view.fit(Math.hypot(...lengths));
}

export function placeCamera(camera) {
  view.camera.position.set(...camera.slice(0, 3));
  view.controls.target.set(...camera.slice(3));
  view.controls.update();
}

/** Places the camera as the state says, or else fits the picture. */
export function restoreCamera() {
  const { camera } = state;
  fitCamera();
  if (camera) placeCamera(camera);
}

/** Fits the picture if the axes are others than before. */
export function fitOtherSpace(before) {
  if (['cut', 'drop', 'timeScale'].some((key) => state[key] !== before[key])) fitCamera();
}
