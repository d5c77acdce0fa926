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
const read = (name) => readFileSync(path.join(valid, name));
const open = (name) => new T4d(new KaitaiStream(read(name)));

test('the corpus has valid files', () => assert(files.length > 0));

for (const name of files) {
  test(`${name}: the chunks from the front fill the file up to its footer`, () => {
    const file = open(name);
    const chunks = file.chunks;
    assert.equal(chunks[0].header.type.text, 'HEAD');
    const size = chunks.reduce((sum, { header }) => sum + header.lenChunk, 24);
    assert.equal(size + (file.header.hasIndex ? 40 : 0), file._io.size);
    const done = chunks.findIndex(({ header }) => header.type.text === 'DONE');
    assert.equal(chunks[done].fields.numChunks, done);
  });

  test(`${name}: the index has the headers and the slabs that are met from the front`, () => {
    const file = open(name);
    if (!file.header.hasIndex) {
      assert.equal(file.footer, undefined);
      return;
    }
    assert.equal(file.footer.lenFile, file._io.size);
    assert.equal(file.doneChunk.header.type.text, 'DONE');
    assert.equal(file.footer.indexChecksum, file.indexChunk.headerChecksum);
    const headers = [];
    const slabs = [];
    let offset = 24;
    for (const { header, fields } of file.chunks.slice(0, -1)) {
      headers.push(...read(name).subarray(offset, offset + 28));
      if (header.type.text === 'SLAB') slabs.push(fields);
      offset += header.lenChunk;
    }
    const index = file.indexChunk.fields;
    assert.equal(index.numSlabs, slabs.length);
    assert.equal(index.chunks.numRows * 28, headers.length);
    // A grammar alone cannot read compressed data.
    const isSame = (array, expected) => {
      const numbers = array.blocks.flatMap(({ raw }) => raw?.values ?? []);
      if (array.codec === T4d.Codec.RAW) assert.deepEqual(numbers, expected);
    };
    isSame(index.chunks, headers);
    isSame(index.times, slabs.flatMap(({ timeBegin, timeEnd }) => [timeBegin, timeEnd]));
    isSame(index.bodies, slabs.map(({ body }) => body));
    isSame(index.parts, slabs.flatMap(({ distanceConnectivity, distanceLower, distanceUpper }) =>
      [distanceConnectivity, distanceLower, distanceUpper]));
  });
}
