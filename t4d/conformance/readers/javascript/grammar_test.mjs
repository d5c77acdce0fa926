// The grammar as others use it: a whole file through the root type, from the front and by index.
import assert from 'node:assert';
import { execFileSync } from 'node:child_process';
import { mkdtempSync, readFileSync, readdirSync, rmSync } from 'node:fs';
import { createRequire } from 'node:module';
import os from 'node:os';
import path from 'node:path';
import { after, test } from 'node:test';
import { fileURLToPath } from 'node:url';

const here = path.dirname(fileURLToPath(import.meta.url));
const folder = mkdtempSync(path.join(os.tmpdir(), 't4d-reader-'));
execFileSync(process.execPath, [path.join(here, 'compile.mjs'), folder]);
after(() => rmSync(folder, { recursive: true }));

const require = createRequire(path.join(folder, 'reader.cjs'));
const KaitaiStream = require('kaitai-struct/KaitaiStream');
const { T4d } = require('./T4d.cjs');

const valid = path.join(here, '../../corpus/files/valid');
const files = readdirSync(valid).filter((name) => name.endsWith('.t4d'));
const open = (name) => new T4d(new KaitaiStream(readFileSync(path.join(valid, name))));

test('the corpus has valid files', () => assert(files.length > 0));

for (const name of files) {
  test(`${name}: the chunks from the front fill the file up to its footer`, () => {
    const file = open(name);
    const chunks = file.chunks;
    assert.equal(chunks[0].header.type.text, 'HEAD');
    const size = chunks.reduce((sum, { header }) => sum + header.lenChunk, 24);
    assert.equal(size + (file.header.hasIndex ? 40 : 0), file._io.size);
    const done = chunks.findIndex(({ header }) => header.type.text === 'DONE');
    assert.equal(chunks[done].payload.numChunks, done);
  });

  test(`${name}: the index has the slabs that are met from the front`, () => {
    const file = open(name);
    if (!file.header.hasIndex) {
      assert.equal(file.footer, undefined);
      return;
    }
    assert.equal(file.footer.lenFile, file._io.size);
    assert.equal(file.doneChunk.header.type.text, 'DONE');
    const met = [];
    let offset = 24;
    for (const { header, payload } of file.chunks) {
      if (header.type.text === 'SLAB') met.push([offset, header.lenChunk, payload.timeBegin]);
      offset += header.lenChunk;
    }
    const { slabs } = file.indexChunk.payload;
    assert.deepEqual(slabs.map((each) => [each.ofsSlab, each.lenSlab, each.timeBegin]), met);
  });
}
