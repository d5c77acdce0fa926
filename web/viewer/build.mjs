// node build.mjs [OUT.html]: the viewer as one page that needs nothing else.
import { mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import path from 'node:path';
import { fileURLToPath } from 'node:url';

import { build } from 'esbuild';

const here = path.dirname(fileURLToPath(import.meta.url));

async function bundle(entry, define = {}) {
  const { outputFiles } = await build({
    entryPoints: [path.join(here, 'src', entry)], bundle: true, minify: true, write: false, format: 'iife',
    target: 'es2022', define, legalComments: 'none', logLevel: 'warning', absWorkingDir: here,
  });
  // What would end the element that it is written into.
  return outputFiles[0].text.replaceAll('</script', '<\\/script');
}

/** The text of the page. */
export async function makePage() {
  const worker = await bundle('worker.js');
  const code = await bundle('main.js', { WORKER_CODE: JSON.stringify(worker) });
  const style = readFileSync(path.join(here, 'src/style.css'), 'utf8');
  const licences = readFileSync(path.join(here, 'src/licences.txt'), 'utf8').trim();
  const page = readFileSync(path.join(here, 'src/index.html'), 'utf8')
    .replace('<!-- licences -->', () => `<!--\n${licences}\n-->`)
    // ASCII, as the code is: servers and editors may take the page for any encoding.
    .replace(/[^\0-\x7f]/gu, (letter) => `&#x${letter.codePointAt(0).toString(16)};`);
  return page.replace('/* style */', () => style).replace('/* code */', () => code);
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const out = process.argv[2] ?? path.join(here, 'dist/viewer.html');
  mkdirSync(path.dirname(out), { recursive: true });
  const page = await makePage();
  writeFileSync(out, page);
  console.log(`${out}: ${page.length} bytes`);
}
