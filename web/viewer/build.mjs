// node build.mjs: dist/t4d-view.js, the element, which needs nothing else, and dist/viewer.html, the page around it.
import { mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import path from 'node:path';
import { fileURLToPath } from 'node:url';

import { build } from 'esbuild';

const here = path.dirname(fileURLToPath(import.meta.url));
const read = (name) => readFileSync(path.join(here, 'src', name), 'utf8');

/** A script without imports and exports: for <script>, with or without type="module", and for bundlers. */
async function bundle(entry, define = {}) {
  const { outputFiles } = await build({
    entryPoints: [path.join(here, 'src', entry)], bundle: true, minify: true, write: false, format: 'iife',
    target: 'es2022', define, legalComments: 'none', logLevel: 'warning', absWorkingDir: here,
    loader: { '.css': 'text', '.html': 'text' },
  });
  // A script must not end the element that it is written into.
  return outputFiles[0].text.replaceAll('</script', '<\\/script');
}

/** The script that defines <t4d-view>. */
export async function makeElement() {
  const worker = await bundle('worker.js');
  return `/*\n${read('licences.txt').trim()}\n*/\n${await bundle('element.js', { WORKER_CODE: JSON.stringify(worker) })}`;
}

/** The page of t4d view, with a place for the script of the element. */
export async function makePage() {
  const code = await bundle('main.js');
  // ASCII, as the code is: servers and editors may take the page for any encoding.
  const page = read('index.html').replace(/[^\0-\x7f]/gu, (letter) => `&#x${letter.codePointAt(0).toString(16)};`);
  return page.replace('/* style */', () => read('controls.css') + read('page.css')).replace('/* code */', () => code);
}

/** The page with the element in it, as the program has it. */
export const wholePage = (page, element) => page.replace('<!-- element -->', () => `<script>${element}</script>`);

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  mkdirSync(path.join(here, 'dist'), { recursive: true });
  for (const [name, text] of [['t4d-view.js', await makeElement()], ['viewer.html', await makePage()]]) {
    writeFileSync(path.join(here, 'dist', name), text);
    console.log(`dist/${name}: ${text.length} bytes`);
  }
}
