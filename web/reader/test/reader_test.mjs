// The conformance kit (conformance/readers/check) tests what is read; here: ranges, slices and servers.
import assert from 'node:assert/strict';
import { readFileSync, readdirSync } from 'node:fs';
import http from 'node:http';
import path from 'node:path';
import { after, test } from 'node:test';
import { fileURLToPath } from 'node:url';

import { crc32c, cut, hyperplane, Invalid, measure, open } from '../src/index.js';
import { fileSource } from '../src/node.js';

const corpus = path.resolve(path.dirname(fileURLToPath(import.meta.url)), '../../../conformance/corpus/files');
const valid = readdirSync(path.join(corpus, 'valid')).filter((name) => name.endsWith('.t4d'));
const bytesOf = (name) => new Uint8Array(readFileSync(path.join(corpus, name)));

/** A server of the corpus; `answer` may replace what it does. */
async function serve(answer) {
  const ranges = [];
  const server = http.createServer((request, response) => {
    const bytes = bytesOf(decodeURIComponent(request.url));
    const [, begin, end] = /^bytes=(\d*)-(\d*)$/.exec(request.headers.range) ?? [];
    const from = begin ? Number(begin) : Math.max(0, bytes.length - Number(end));
    const to = begin && end ? Number(end) + 1 : bytes.length;
    ranges.push(to - from);
    if (answer?.(request, response, bytes)) return;
    response.writeHead(206, { 'Content-Range': `bytes ${from}-${to - 1}/${bytes.length}`, ETag: '"one"' });
    response.end(bytes.subarray(from, to));
  });
  await new Promise((resolve) => server.listen(0, '127.0.0.1', resolve));
  after(() => server.close());
  return { url: (name) => `http://127.0.0.1:${server.address().port}/${name}`, ranges };
}

test('the checksum is that of the specification', () => {
  assert.equal(crc32c(new TextEncoder().encode('123456789')), 0xe3069283);
  assert.equal(crc32c(new Uint8Array(0)), 0);
  const bytes = Uint8Array.from({ length: 1000 }, (_, i) => i * i);
  for (let i = 0; i < 40; ++i) assert.equal(crc32c(bytes.subarray(i), crc32c(bytes.subarray(0, i))), crc32c(bytes));
});

test('a file is the same from bytes, a Blob, a disk and a server', async () => {
  const name = 'valid/cube-in-translation.t4d';
  const { url } = await serve();
  const source = fileSource(path.join(corpus, name));
  after(() => source.close());
  const answers = [];
  for (const from of [bytesOf(name), new Blob([bytesOf(name)]), source, url(name)]) {
    const file = await open(from);
    const [section] = await file.slice(2.5);
    answers.push({ bodies: file.bodies, measures: measure(section) });
  }
  for (const answer of answers) assert.deepEqual(answer, answers[0]);
  assert.ok(Math.abs(answers[0].measures.volume - 1) < 1e-12);
});

test('a server that knows no ranges sends the whole file', async () => {
  const { url } = await serve((request, response, bytes) => response.writeHead(200).end(bytes));
  assert.equal((await open(url('valid/one-simplex.t4d'))).bodies[0].name, 'simplex');
});

test('a file that changes on the server is an error that says so', async () => {
  let version = 1;
  const { url } = await serve((request, response, bytes) => {
    if (request.headers['if-match'] && request.headers['if-match'] !== `"${version}"`) {
      response.writeHead(412).end();
      return true;
    }
    const [, begin, end] = /^bytes=(\d*)-(\d*)$/.exec(request.headers.range);
    // A tail that is shorter than was asked for, so that there is something left to read.
    const [from, to] = begin ? [Number(begin), Number(end) + 1] : [bytes.length - 40, bytes.length];
    response.writeHead(206, { 'Content-Range': `bytes ${from}-${to - 1}/${bytes.length}`, ETag: `"${version}"` });
    response.end(bytes.subarray(from, to));
    return true;
  });
  const file = await open(url('valid/cube-in-translation.t4d'));
  assert.equal((await file.slabsAt(0.5)).length, 1);
  version = 2;
  await assert.rejects(file.slabsAt(3.5), /the file has changed on the server/);
});

test('a missing file is an error that says so', async () => {
  const { url } = await serve((request, response) => response.writeHead(404).end());
  await assert.rejects(open(url('valid/one-simplex.t4d')), /one-simplex.t4d: the server answers 404/);
});

test('damage says which byte and which rule', async () => {
  await assert.rejects(open(bytesOf('invalid/H1-png.t4d')), Invalid);
  const bytes = bytesOf('valid/one-simplex.t4d');
  await assert.rejects(open(bytes.subarray(0, 900)), (error) => error.rule === 'F1' && /cut off/.test(error.message));
  const file = await open(bytes);
  const { at } = file.bodies[0].slabs[0];
  bytes[at + 40] ^= 1;
  await assert.rejects(file.slice(0.5), (error) => error.rule === 'C5' && error.at === at + 24);
});

test('slabs of a slice are closed, whatever cuts them', async () => {
  // A seeded generator.
  let state = 1;
  const random = () => {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    return state / 2 ** 32;
  };
  for (const name of valid) {
    const file = await open(bytesOf(`valid/${name}`));
    for (let i = 0; i < 4; ++i) {
      const normal = [random() - 0.5, random() - 0.5, random() - 0.5, random() - 0.5];
      for (const { triangles } of await file.slice(hyperplane(normal, random() - 0.5))) {
        const edges = new Map();
        for (let k = 0; k < triangles.length; ++k) {
          const next = k % 3 === 2 ? k - 2 : k + 1;
          const [a, b] = [triangles[k], triangles[next]];
          const key = `${Math.min(a, b)} ${Math.max(a, b)}`;
          edges.set(key, (edges.get(key) ?? 0) + (a < b ? 1 : -1));
        }
        assert.ok([...edges.values()].every((sum) => sum === 0), `${name}: ${normal}`);
      }
    }
  }
});

test('slabs are cut one after another as the file does', async () => {
  const file = await open(bytesOf('valid/cube-in-translation.t4d'));
  const plane = hyperplane([1, 0, 0, 0.5], 0.25);
  const cutter = cut(plane);
  for (const record of file.bodies[0].slabs) cutter.add(await file.slab(record));
  const [section] = await file.slice(plane);
  assert.deepEqual(measure(cutter.finish()), measure(section));
});
