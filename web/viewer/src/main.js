import { fitOtherSpace, view } from './camera.js';
import { comparison } from './comparison.js';
import { drawChanges, invalidate, isWhole, onMove, whole } from './drawing.js';
import { openFile, openFirst } from './files.js';
import { listen } from './input.js';
import { linkLater } from './link.js';
import { fillFacts, measureLater } from './measures.js';
import { hideOldMessage } from './messages.js';
import { onChange, panes, set, state } from './page.js';
import { planeOf } from './pane.js';
import { fillColors, fillControls } from './panel.js';
import { advance, isPlaying } from './play.js';
import { sliceAsGlb } from './saving.js';
import { measureSpeed, noteFirstPicture, speeds } from './speed.js';
import { restoreTheme } from './theme.js';

onChange((before) => {
  fitOtherSpace(before);
  invalidate();
  hideOldMessage();
  fillControls();
  measureLater();
  linkLater();
});

view.controls.addEventListener('change', () => {
  onMove();
  linkLater();
});

let lastFrame = 0;

function frame(now) {
  requestAnimationFrame(frame);
  // A slice is waited for.
  if (isPlaying && isWhole && panes.length > 0) advance(Math.min(0.1, (now - lastFrame) / 1000));
  lastFrame = now;
  if (!drawChanges()) return;
  if (isWhole && panes.length > 0) noteFirstPicture();
  if (isWhole) fillColors();
  fillFacts();
}

async function start() {
  restoreTheme();
  fillControls();
  listen();
  requestAnimationFrame(frame);
  await openFirst();
}

// For tests, and for scripts in the console.
window.t4dViewer = {
  get state() { return { ...state }; },
  get panes() { return panes; },
  get camera() { return view.camera; },
  set, whole, measureSpeed, sliceAsGlb, speeds,
  measures: () => panes.map((pane) => pane.measureShown(planeOf(state))),
  largestDistance: () => comparison.largest,
  open: openFile,
};
window.t4dViewer.started = start();
