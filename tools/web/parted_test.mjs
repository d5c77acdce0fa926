// Files in parts (.t4dm): the manifest, and web/reader, which opens one like a single .t4d.
import assert from 'node:assert/strict';
import { File } from 'node:buffer';  // not global before Node 20
import { once } from 'node:events';
import { readFileSync, renameSync, writeFileSync } from 'node:fs';
import http from 'node:http';
import path from 'node:path';
import test from 'node:test';

import { hyperplane, measure, open } from '../../web/reader/src/index.js';
import { fileSource } from '../../web/reader/src/node.js';
import { schemaOf } from './schemas.mjs';
import { makeFolder, t4d } from './t4d.mjs';

const folder = makeFolder('t4d-parts');
const at = (name) => path.join(folder, name);
const numParts = 5;
const parts = Array.from({ length: numParts }, (_, k) => at(`part${k + 1}.t4d`));
parts.forEach((part, k) => t4d('sweep', at('fixtures/torus.obj'), '--motion', at('fixtures/several-segments.json'),
  '--part', `${k + 1}/${numParts}`, '-o', part));
t4d('join', ...parts, '--manifest', '-o', at('torus.t4dm'));
t4d('join', at('torus.t4dm'), '-o', at('torus.t4d'));
const manifest = () => JSON.parse(readFileSync(at('torus.t4dm'), 'utf8'));

test('the manifest is of its schema', () => {
  const schema = schemaOf('formats/t4d/manifest.schema.json');
  schema.check(manifest(), 'torus.t4dm');
  for (const name of schema.schema.required) assert.ok(!schema.accepts({ ...manifest(), [name]: undefined }), name);
  schemaOf('formats/t4d/head.schema.json').check(manifest().head, 'head');
});

/** A server of the folder, with ranges. */
async function serve() {
  const asked = new Set();
  const server = http.createServer((request, response) => {
    const bytes = readFileSync(at(request.url));
    asked.add(path.basename(request.url));
    const [, begin, end] = /^bytes=(\d*)-(\d*)$/.exec(request.headers.range);
    const from = begin ? Number(begin) : Math.max(0, bytes.length - Number(end));
    const to = begin ? Number(end) + 1 : bytes.length;
    response.writeHead(206, { 'Content-Range': `bytes ${from}-${to - 1}/${bytes.length}` });
    response.end(bytes.subarray(from, to));
  }).listen(0, '127.0.0.1');
  await once(server, 'listening');
  return { url: (name) => `http://127.0.0.1:${server.address().port}/${name}`, asked, close: () => server.close() };
}

test('web/reader reads the parts as it reads one file', async () => {
  const source = fileSource(at('torus.t4d'));
  const one = await open(source);
  const all = await open(fileSource(at('torus.t4dm')));
  const { slabs, ...body } = one.bodies[0];
  assert.deepEqual(all.bodies, [{ ...body, numSlabs: slabs.length }]);
  const { begin, end } = body;
  const times = [begin, end, ...manifest().parts.map((part) => part.end), (begin + end) / 3, begin - 1, end + 1];
  const planes = [...times, hyperplane([1, 0, 0, 0], 0.1), hyperplane([0, 0, 1, 0.5], 0.3)];
  for (const plane of planes) assert.deepEqual(await all.slice(plane), await one.slice(plane));
  assert.deepEqual((await all.slabsAt(end / 2)).map(({ cells }) => cells), (await one.slabsAt(end / 2)).map(({ cells }) => cells));
  source.close();
});

test('only the parts that have the time are fetched', async () => {
  const server = await serve();
  const file = await open(server.url('torus.t4dm'));
  assert.deepEqual([...server.asked], ['torus.t4dm']);
  const { parts: said } = manifest();
  const [section] = await file.slice((said[2].begin + said[2].end) / 2);
  assert.ok(measure(section).volume > 0);
  assert.deepEqual([...server.asked], ['torus.t4dm', 'part3.t4d']);
  assert.equal(file.requests >= 2, true);
  server.close();
});

test('a part that is missing or exchanged is named', async () => {
  const { parts: said } = manifest();
  const time = (said[1].begin + said[1].end) / 2;
  renameSync(parts[1], at('away'));
  await assert.rejects(async () => (await open(fileSource(at('torus.t4dm')))).slice(time), /part2\.t4d/);
  renameSync(parts[2], parts[1]);
  await assert.rejects(async () => (await open(fileSource(at('torus.t4dm')))).slice(time),
    /part2\.t4d: is not the part that torus\.t4dm describes/);
  renameSync(parts[1], parts[2]);
  renameSync(at('away'), parts[1]);
  await assert.rejects(open(new File([readFileSync(at('torus.t4dm'))], 'torus.t4dm')), /open it by its URL/);
});

test('a manifest that is wrong is refused', async () => {
  const refuses = async (change, why) => {
    const json = manifest();
    change(json);
    writeFileSync(at('wrong.t4dm'), JSON.stringify(json));
    await assert.rejects(open(fileSource(at('wrong.t4dm'))), why);
  };
  for (const leaving of ['../a.t4d', '/a.t4d', 'a/../../b.t4d', '', 'ftp://host/a.t4d', 'file:///a.t4d']) {
    await refuses((json) => { json.parts[0].path = leaving; }, /without '\.\.'/);
  }
  await refuses((json) => { json.parts.splice(1, 1); }, /part before ends at/);
  await refuses((json) => { json.parts = []; }, /names no part/);
  await refuses((json) => { json.t4dm = 2; }, /version 2/);
  await refuses((json) => { delete json.head; }, /no head/);
  await refuses((json) => { json.parts[0].bodies[0].slabs = 1e300; }, /not described/);
});
