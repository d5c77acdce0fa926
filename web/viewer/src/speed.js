// The speed of the page.
import { shown } from './common.js';
import { element, model, viewer } from './page.js';

/** The speeds in milliseconds. */
export const speeds = { firstPicture: null, gpu: null, cpu: null };
const clock = { opened: performance.now() };

/** A file is to be opened. */
export function startClock() {
  clock.opened = performance.now();
}

/** All is drawn, perhaps for the first time. */
export function noteFirstPicture() {
  if (speeds.firstPicture !== null) return;
  viewer.view.finish();
  speeds.firstPicture = performance.now() - clock.opened;
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
  const { drawing, view } = viewer;
  const key = model.sliderKey;
  const at = model.state[key];
  const [low, high] = model.sliderRange();
  const gpu = [];
  const cpu = [];
  try {
    for (let i = 0; i < count; ++i) {
      const value = low + (high - low) * (i + 0.37) / count;
      model.set({ [key]: value });
      await drawing.whole();
      // The slabs are there now; the frame of another value of the same slab.
      model.set({ [key]: value + (high - low) * 1e-4 });
      const begin = performance.now();
      drawing.update();
      drawing.draw();
      view.finish();
      gpu.push(performance.now() - begin);
      const answers = await Promise.all(model.panes.map((pane) => pane.slice(model.plane())));
      cpu.push(answers.reduce((sum, { milliseconds }) => sum + milliseconds, 0));
    }
  } finally {
    model.set({ [key]: at });
  }
  const median = (values) => values.sort((a, b) => a - b)[values.length >> 1];
  speeds.gpu = median(gpu);
  speeds.cpu = median(cpu);
  fillSpeeds();
  return { ...speeds };
}
