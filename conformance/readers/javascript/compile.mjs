// node compile.mjs FOLDER [t4d.ksy]: makes the reader in FOLDER, ready to be started there as
// FOLDER/t4d_reader.mjs: the parsers that the Kaitai compiler makes of the grammars, the rules that
// these check, the reader itself, and the two packages that it needs when it runs.
import { chmodSync, cpSync, mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import path from 'node:path';
import { fileURLToPath } from 'node:url';
import compiler from 'kaitai-struct-compiler';
import { load } from 'js-yaml';

const here = path.dirname(fileURLToPath(import.meta.url));
const [folder, grammar = path.join(here, '../../../formats/t4d/t4d.ksy')] = process.argv.slice(2);
if (!folder) {
  console.error('usage: node compile.mjs FOLDER [t4d.ksy]');
  process.exit(2);
}
mkdirSync(folder, { recursive: true });

/** Rules by the path that the parser's errors name, such as /types/chunk/seq/2. */
function rulesOf(spec) {
  const rules = {};
  for (const [type, { seq }] of Object.entries(spec.types)) {
    seq?.forEach((each, i) => {
      if (each['-rule']) rules[`/types/${type}/seq/${i}`] = each['-rule'];
    });
  }
  return rules;
}

for (const file of [grammar, path.join(here, 'zstd_frame.ksy')]) {
  const spec = load(readFileSync(file, 'utf8'));
  const compiled = await compiler.compile('javascript', spec, null, false);
  for (const [name, text] of Object.entries(compiled)) {
    writeFileSync(path.join(folder, name.replace(/\.js$/, '.cjs')), text);
  }
  if (file === grammar) {
    writeFileSync(path.join(folder, 'rules.json'), JSON.stringify(rulesOf(spec), null, 1));
  }
}
for (const name of ['kaitai-struct', 'zstddec']) {
  const target = path.join(folder, 'node_modules', name);
  cpSync(path.join(here, 'node_modules', name), target, { recursive: true });
}
const reader = path.join(folder, 't4d_reader.mjs');
cpSync(path.join(here, 't4d_reader.mjs'), reader);
cpSync(path.join(here, 'under_test.mjs'), path.join(folder, 'under_test.mjs'));
chmodSync(reader, 0o755);
