import { existsSync } from 'node:fs';
import { fileURLToPath } from 'node:url';

const inPath = (process.env.PATH ?? '').split(':').map((folder) => `${folder}/chromium`);
// The program that tools/setup installs, where the system has no package.
const unpacked = fileURLToPath(new URL('../../tests/chromium/program/chromium', import.meta.url));

/** How playwright starts Chromium: without a GPU, and with nothing of the network but our own pages. */
export const chromiumOptions = {
  executablePath: process.env.CHROMIUM ?? [...inPath, unpacked].find(existsSync),
  args: [
    '--no-sandbox',  // not available to root; Chromium loads only our own page
    '--use-angle=swiftshader', '--enable-unsafe-swiftshader',  // WebGL without a GPU
    '--disable-background-networking', '--no-first-run', '--disable-sync', '--disable-component-update',
  ],
};
