// The manifest of the file corpus, and the answers beside its files, match their schemas.
import assert from 'node:assert/strict';
import { createHash } from 'node:crypto';
import { readFileSync, readdirSync } from 'node:fs';
import path from 'node:path';
import test from 'node:test';

import { reportSchemas, schemaOf } from './schemas.mjs';
import { makeFolder, readJson, root, t4dRaw } from './t4d.mjs';

// Generated, as for users: the source tree does not have the largest file.
const corpus = path.join(makeFolder('corpus'), 'copy');
assert.equal(t4dRaw('conform', 'copy', corpus).status, 0);
const at = (name) => path.join(corpus, name);
const manifest = readJson(at('manifest.json'));
const { check } = schemaOf('conformance/corpus/files/manifest.schema.json');

test('the manifest is as its schema says', () => check(manifest, 'manifest.json'));

test('the manifest names every file, once and in order, with its sum', () => {
  const ids = manifest.files.map(({ id }) => id);
  assert.deepEqual(ids, [...new Set(ids)].sort());
  const named = manifest.files.flatMap(({ file, expected }) => [file, expected ?? []].flat());
  const there = ['valid', 'invalid', 'impl'].flatMap((folder) =>
    readdirSync(at('.')).includes(folder)
      ? readdirSync(at(folder)).map((name) => `${folder}/${name}`) : []);
  assert.deepEqual(named.sort(), there.sort());
  for (const { id, file, bytes, sha256 } of manifest.files) {
    assert.equal(file, `${id}.t4d`);
    const content = readFileSync(at(file));
    assert.equal(content.length, bytes, id);
    assert.equal(createHash('sha256').update(content).digest('hex'), sha256, id);
  }
});

test('the expected answers are as the schemas of answers say', () => {
  const describe = schemaOf('formats/t4d/reader_describe.schema.json');
  const slice = schemaOf('formats/t4d/reader_slice.schema.json');
  for (const { expected } of manifest.files.filter((file) => file.expected)) {
    const answers = readJson(at(expected));
    describe.check(answers.describe.answer, expected);
    for (const { time, answer } of answers.slices) slice.check(answer, `${expected} at ${time}`);
    for (const { by, answer } of answers.sections) slice.check(answer, `${expected} by ${by}`);
  }
});

test('the expected answers, and the list of damaged files, are as the schemas of the corpus say', () => {
  const answers = schemaOf('conformance/corpus/files/answers.schema.json');
  for (const { expected } of manifest.files.filter((file) => file.expected)) {
    answers.check(readJson(at(expected)), expected);
  }
  const damaged = readJson(at('damaged.json'));
  schemaOf('conformance/corpus/files/damaged.schema.json').check(damaged, 'damaged.json');
  assert.equal(damaged.corpus_version, manifest.corpus_version);
});

test('the meshes for writers are as their schema says', () => {
  const mesh = schemaOf('formats/t4d/writer_mesh.schema.json');
  const kept = path.join(makeFolder('writers'), 'kept');
  // A writer that always fails: all its inputs are kept.
  assert.equal(t4dRaw('conform', 'writer', '--writer', 'false', '--keep', kept).status, 1);
  const names = readdirSync(kept, { recursive: true }).filter((name) => name.endsWith('.json'));
  assert.ok(names.length > 40);
  for (const name of names) mesh.check(readJson(path.join(kept, name)), name);
});

test('clauses are rules of the specification', () => {
  const spec = readFileSync(path.join(root, 'formats/t4d/SPEC.md'), 'utf8');
  const rules = new Set([...spec.matchAll(/^\* \*\*([A-Z]+[0-9]+)\*\* /gm)].map(([, rule]) => rule));
  for (const { id, clause } of manifest.files.filter(({ result }) => result === 'invalid')) {
    assert.ok(rules.has(clause), id);
  }
});

test('what t4d validate and t4d info say of the files is as their schemas say', () => {
  const schemas = reportSchemas(JSON.parse(t4dRaw('help', '--json').stdout));
  const validate = schemas.get('validate');
  const info = schemas.get('info');
  // C++ tests run the reader on all of them; starting the program for each would take a minute.
  const some = manifest.files.filter(({ result }, i) => result !== 'invalid' || i % 8 === 0);
  for (const { id, file, result } of some) {
    const said = JSON.parse(t4dRaw('validate', at(file), '--json').stdout);
    validate.check(said, id);
    const damaged = said.issues.messages.some(({ code }) => code === 'file-damaged');
    if (result !== 'either') assert.equal(damaged, result === 'invalid', id);
    if (result === 'valid') info.check(JSON.parse(t4dRaw('info', at(file), '--json').stdout), id);
  }
});
