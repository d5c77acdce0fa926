// Shared by the tests: the program, its fixtures, and readers of its output.
import { execFileSync, spawnSync } from 'node:child_process';
import { mkdirSync, readFileSync, readdirSync, rmSync } from 'node:fs';
import path from 'node:path';
import { fileURLToPath } from 'node:url';

export const root = path.resolve(path.dirname(fileURLToPath(import.meta.url)), '../..');
export const build = process.env.T4D_BUILD ?? path.join(root, 'build/release');

/** An empty folder build/web-test/NAME, with the fixtures in NAME/fixtures. */
export function makeFolder(name) {
  const folder = path.join(root, 'build/web-test', name);
  rmSync(folder, { recursive: true, force: true });
  mkdirSync(folder, { recursive: true });
  execFileSync(path.join(build, 't4d-fixtures'), [path.join(folder, 'fixtures')]);
  return folder;
}

export const fixturesIn = (folder, extension) =>
  readdirSync(path.join(folder, 'fixtures'))
    .filter((name) => name.endsWith(extension))
    .map((name) => path.join(folder, 'fixtures', name));

export const readJson = (file) => JSON.parse(readFileSync(file, 'utf8'));

/** Runs `t4d ARGUMENTS --json`; returns its output, or throws its error message. */
export function t4d(...args) {
  const done = t4dRaw(...args, '--json');
  if (done.status !== 0) {
    throw new Error(`t4d ${args.join(' ')}: exit ${done.status}: ${done.stderr}`);
  }
  return JSON.parse(done.stdout);
}

export const t4dRaw = (...args) =>
  spawnSync(path.join(build, 't4d'), args.map(String), { encoding: 'utf8' });

/** The measures of an .obj file, in the numbers of the 4D mesh. */
export function measureObj(file) {
  const min = [Infinity, Infinity, Infinity];
  const max = [-Infinity, -Infinity, -Infinity];
  let vertices = 0;
  let triangles = 0;
  for (const line of readFileSync(file, 'utf8').split('\n')) {
    if (line.startsWith('v ')) {
      ++vertices;
      line.slice(2).split(' ').map(Number).forEach((value, axis) => {
        min[axis] = Math.min(min[axis], value);
        max[axis] = Math.max(max[axis], value);
      });
    } else if (line.startsWith('f ')) {
      ++triangles;
    }
  }
  return { vertices, triangles, min, max };
}
