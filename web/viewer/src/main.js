// The page of t4d view: connects its controls with the view.
import { openFile, openFirst } from './files.js';
import { listen } from './input.js';
import { linkLater } from './link.js';
import { fillFacts, measureLater } from './measures.js';
import { model, viewer } from './page.js';
import { fillColors, fillControls, fillPanel } from './panel.js';
import { measureSpeed, noteFirstPicture, speeds } from './speed.js';
import { restoreTheme } from './theme.js';

const on = (type, ...calls) => calls.forEach((call) => viewer.addEventListener(type, call));
on('change', fillControls, measureLater, linkLater);
on('move', linkLater);
on('compared', measureLater);
on('files', fillPanel);
on('draw', () => {
  if (viewer.drawing.isWhole) {
    if (model.panes.length > 0) noteFirstPicture();
    fillColors();
  }
  fillFacts();
});

restoreTheme();
fillControls();
listen();

// For tests, and for scripts in the console.
window.t4dViewer = {
  get state() { return { ...model.state }; },
  get camera() { return viewer.view.camera; },
  panes: model.panes, find: viewer.find, measureSpeed, speeds,
  set: (changes) => model.set(changes),
  whole: () => viewer.drawing.whole(),
  sliceAsGlb: () => viewer.glbOf(model.panes[0]),
  measures: () => model.panes.map((pane) => pane.measureShown(model.plane())),
  largestDistance: () => viewer.comparison.largest,
  open: openFile,
  started: openFirst(),
};
