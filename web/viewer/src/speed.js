// How fast the page is.
import { view } from './camera.js';
import { element, shown } from './common.js';
import { draw, update, whole } from './drawing.js';
import { panes, set, sliceOf, sliderKey, sliderRange, state } from './page.js';
import { planeOf } from './pane.js';

/** Milliseconds. */
export const speeds = { firstPicture: null, gpu: null, cpu: null };
let opened = performance.now();

/** A file is to be opened. */
export function startClock() {
  opened = performance.now();
}

export function forgetFirstPicture() {
  speeds.firstPicture = null;
}

/** All is drawn, perhaps for the first time. */
export function noteFirstPicture() {
  if (speeds.firstPicture !== null) return;
  view.finish();
  speeds.firstPicture = performance.now() - opened;
  fillSpeeds();
}

function fillSpeeds() {
  const lines = [];
  const ms = (value) => (value < 1000 ? `${value.toPrecision(3)} ms` : `${shown(value / 1000, 3)} s`);
  if (speeds.firstPicture !== null) lines.push(`first picture after ${ms(speeds.firstPicture)}`);
  if (speeds.gpu !== null) {
    lines.push(`a frame: ${ms(speeds.gpu)}`);
    lines.push(`cutting on the CPU: ${ms(speeds.cpu)}, ${(speeds.cpu / speeds.gpu).toPrecision(2)} times a frame`);
  }
  element('speeds').textContent = lines.join('\n');
}

/**
 * Milliseconds of a frame while the slider moves, the GPU waited for, and of cutting the same slices on the CPU:
 * medians over times within one slab, which are there.
 */
export async function measureSpeed(count = 11) {
  const key = sliderKey();
  const at = state[key];
  const [low, high] = sliderRange();
  const gpu = [];
  const cpu = [];
  try {
    for (let i = 0; i < count; ++i) {
      const value = low + (high - low) * (i + 0.37) / count;
      set({ [key]: value });
      await whole();
      // The slabs are there now; the frame of another value of the same slab.
      set({ [key]: value + (high - low) * 1e-4 });
      const begin = performance.now();
      update();
      draw();
      view.finish();
      gpu.push(performance.now() - begin);
      const plane = planeOf(state);
      const answers = await Promise.all(panes.map(({ info }) => sliceOf(info, plane)));
      cpu.push(answers.reduce((sum, { milliseconds }) => sum + milliseconds, 0));
    }
  } finally {
    set({ [key]: at });
  }
  const median = (values) => values.sort((a, b) => a - b)[values.length >> 1];
  speeds.gpu = median(gpu);
  speeds.cpu = median(cpu);
  fillSpeeds();
  return { ...speeds };
}
