// node bench.mjs FILE.t4d...: the numbers of README.md. Sizes of the package; and for each file, in Chromium without a GPU,
// the time to the first picture, of the page and of a second view of the file, and frames a second while it plays.
import { execFileSync } from 'node:child_process';
import { readFileSync } from 'node:fs';
import path from 'node:path';
import { fileURLToPath } from 'node:url';
import { gzipSync } from 'node:zlib';

import { launch, serve } from './browser.mjs';

const here = path.dirname(fileURLToPath(import.meta.url));
const script = path.join(here, 'dist/t4d-view.js');

/** Milliseconds until there is a picture, and frames a second in some seconds of play. */
async function speedsOf(browser, file) {
  const site = await serve({
    'mesh.t4d': file, 't4d-view.js': script,
    'index.html': Buffer.from(`<!doctype html><link rel="icon" href="data:,"><script defer src="t4d-view.js"></script>
<t4d-view src="mesh.t4d" style="height: 400px"></t4d-view>`),
  });
  const page = await browser.newPage({ viewport: { width: 640, height: 900 } });
  await page.goto(site.url);
  const speeds = await page.evaluate(async () => {
    const drawn = async (view) => {
      await view.drawn();
      view.viewer.view.finish();
      return performance.now();
    };
    const view = document.querySelector('t4d-view');
    const first = await drawn(view);
    const other = document.createElement('t4d-view');
    other.src = 'mesh.t4d';
    const begin = performance.now();
    document.body.append(other);
    const second = await drawn(other) - begin;
    other.remove();
    let frames = 0;
    view.addEventListener('t4d-draw', () => { ++frames; });
    view.play();
    const started = performance.now();
    await new Promise((resolve) => { setTimeout(resolve, 8000); });
    view.viewer.view.finish();
    const seconds = (performance.now() - started) / 1000;
    view.pause();
    const { triangles } = await view.measure();
    return { first, second, rate: frames / seconds, triangles };
  });
  await page.close();
  site.close();
  return speeds;
}

const [pack] = JSON.parse(execFileSync('npm', ['pack', '--dry-run', '--json'], { cwd: here, encoding: 'utf8' }));
const bytes = readFileSync(script);
console.log(`package: ${pack.size} bytes, ${pack.unpackedSize} unpacked; t4d-view.js: ${bytes.length} bytes, ${gzipSync(bytes).length} with gzip`);
const browser = await launch();
for (const file of process.argv.slice(2)) {
  const { first, second, rate, triangles } = await speedsOf(browser, file);
  console.log(`${path.basename(file)}: first picture ${Math.round(first)} ms, of a second view ${Math.round(second)} ms; `
    + `${rate.toFixed(1)} frames/s, with ${triangles} triangles at the end`);
}
await browser.close();
