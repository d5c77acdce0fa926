// node make.mjs BUILD: heart.t4d, a ball whose waist and poles beat in turn, and heart.js, which has it as text.
import { execFileSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { fileURLToPath } from 'node:url';

const build = path.resolve(process.argv[2]);
const here = path.dirname(fileURLToPath(import.meta.url));
const folder = mkdtempSync(path.join(tmpdir(), 'heart-'));
const run = (program, ...args) => execFileSync(path.join(build, program), args.map(String), { cwd: folder });

const numKeys = 8;

/** A ball at a part of its beat. */
const beating = (ball, part) => ball.replaceAll(/^v (\S+) (\S+) (\S+)$/gm, (_, ...numbers) => {
  const [x, y, z] = numbers.slice(0, 3).map(Number);
  const size = 1 + 0.3 * Math.sin(2 * Math.PI * part + 2 * z / Math.hypot(x, y, z));
  return `v ${[x, y, z].map((value) => value * size).join(' ')}`;
});

run('t4d-fixtures', '.');
const ball = readFileSync(path.join(folder, 'pebble.obj'), 'utf8');
for (let key = 0; key <= numKeys; ++key) {
  writeFileSync(path.join(folder, `heart_${key}.obj`), beating(ball, key / numKeys));
}
const keys = Array.from({ length: numKeys + 1 }, (_, key) => `heart_${key}.obj`);
run('t4d', 'sweep', ...keys, '--times', '0:1', '--grid-step', 0.01, '--compression', 19, '-o', path.join(here, 'heart.t4d'));
const base64 = readFileSync(path.join(here, 'heart.t4d')).toString('base64');
writeFileSync(path.join(here, 'heart.js'), `// heart.t4d once more: browsers do not let a page that is opened from a folder read other files.
if (location.protocol === 'file:') {
  for (const view of document.querySelectorAll('t4d-view')) {
    view.setAttribute('src', 'data:model/vnd.t4d;name=heart.t4d;base64,${base64}');
  }
}
`);
rmSync(folder, { recursive: true });
