// The JSON Schemas beside the specification of .t4d: HEAD, and the answers of a reader under test.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { readFileSync, writeFileSync } from 'node:fs';
import path from 'node:path';
import test from 'node:test';

import { schemaOf } from './schemas.mjs';
import { build, makeFolder, root, t4d, t4dRaw } from './t4d.mjs';
import { exampleOfSpec, headOf, withHead } from './t4d_file.mjs';

const folder = makeFolder('t4d-schemas');
const at = (name) => path.join(folder, name);
const spec = readFileSync(path.join(root, 'formats/t4d/SPEC.md'), 'utf8');
const head = schemaOf('formats/t4d/head.schema.json');
const describe = schemaOf('formats/t4d/reader_describe.schema.json');
const slice = schemaOf('formats/t4d/reader_slice.schema.json');

test('HEAD: the members are those of the specification', () => {
  const section = spec.split('\n## HEAD\n')[1].split('\n### ')[0];
  const rows = [...section.matchAll(/^\| `(\w+)` \|([^|]+)\|([^|]*)\|/gm)];
  assert.deepEqual(rows.map(([, name]) => name), Object.keys(head.schema.properties));
  assert.deepEqual(rows.filter(([, , , is]) => is.trim() === 'required').map(([, name]) => name),
    head.schema.required);
  for (const [, name, type] of rows) {
    const member = head.schema.properties[name];
    assert.equal(type.trim().split(' ')[0], member.type ?? typeof member.enum[0], name);
    assert.ok(member.description, name);
  }
});

const fixture = (name) => at(`fixtures/${name}`);
const motion = ['--motion', fixture('paper-voxel.json')];
const voxels = ['--voxel-size', 4, '--frames', 2];
const written = {
  swept: () => t4d('sweep', fixture('paper-cube.obj'), ...motion, '-o', at('swept.t4d')),
  'swept with all that it can say': () => t4d('sweep', fixture('bolt.obj'), '--motion',
    fixture('screw-in.json'), '--rv-min', 0.5, '--caps', 'cone', '--prism', 3, '--precision',
    'float32', '--compression', 0, '--up', 'z', '--body', 'Schraube \u00e4 \u{1F529}', '-o',
    at('swept with all that it can say.t4d')),
  'swept by voxels': () => t4d('sweep', fixture('paper-cube.obj'), ...motion, '--backend',
    'voxel4d', ...voxels, '-o', at('swept by voxels.t4d')),
  woven: () => {
    t4d('voxelize', fixture('paper-cube.obj'), ...motion, ...voxels, '-o', at('frames'));
    t4d('weave', at('frames'), '--length-unit', 'mm', '-o', at('woven.t4d'));
  },
};
for (const [name, write] of Object.entries(written)) {
  test(`HEAD of a file that was ${name}`, () => {
    write();
    head.check(headOf(readFileSync(at(`${name}.t4d`))), name);
  });
}

/** Whether the program opens the specification's file with this HEAD. */
function programAccepts(text) {
  writeFileSync(at('head.t4d'), withHead(exampleOfSpec(), text));
  const done = t4dRaw('info', at('head.t4d'), '--json');
  assert.ok(done.status === 0 || done.status === 4, done.stderr);
  return done.status === 0;
}

const least = { features: ['means'], bodies: [{ name: 'simplex' }] };
const accepted = {
  'of the specification': headOf(exampleOfSpec()),
  'the least': least,
  'no features': { ...least, features: [] },
  'all features': { ...least, features: ['zstd', 'means', 'pose', 'grid'],
    grid: { origin: [0, 0.5, -1], step: 1e-3 } },
  'a name of 255 bytes': { ...least, bodies: [{ name: '\u00e4'.repeat(127) + 'x' }] },
  'every member': { ...least, generator: 'g 1', backend: 'by hand', length_unit: 'in',
    time_unit: 'min', up: 'z', details: { a: [1, { b: null }] } },
  'empty texts': { ...least, generator: '', backend: '', length_unit: '', time_unit: '' },
  'an unknown member': { ...least, 'of a later version': [1] },
};
for (const [name, value] of Object.entries(accepted)) {
  test(`HEAD accepted: ${name}`, () => {
    head.check(value, name);
    assert.ok(programAccepts(JSON.stringify(value)));
  });
}

const { features, bodies } = least;
const refused = {
  'not an object': [least],
  'M5 no features': { bodies },
  'M5 features no array': { features: 'means', bodies },
  'M5 features no strings': { features: [1], bodies },
  'M6 an unknown feature': { features: ['means', 'wavelets'], bodies },
  'M7 no bodies': { features },
  'M7 bodies no array': { features, bodies: { simplex: 1 } },
  'M7 bodies no objects': { features, bodies: ['simplex'] },
  'M7 bodies none': { features, bodies: [] },
  'M7 bodies too many': { features, bodies: Array.from({ length: 65537 }, (_, i) => ({ name: `${i}` })) },
  'M8 no name': { features, bodies: [{}] },
  'M8 a name of no bytes': { features, bodies: [{ name: '' }] },
  'M8 a name of 256 bytes': { features, bodies: [{ name: 'x'.repeat(256) }] },
  'M11 a colour of two': { features, bodies: [{ name: 'a', color: [0, 1] }] },
  'M11 a colour above 1': { features, bodies: [{ name: 'a', color: [0, 1, 2] }] },
  'M11 a material that is a number': { features, bodies: [{ name: 'a', material: 1 }] },
  'M11 a parent that is a number': { features, bodies: [{ name: 'a', parent: 0 }] },
  'M10 generator': { ...least, generator: 1 },
  'M10 backend': { ...least, backend: ['mesh4d'] },
  'M10 length_unit': { ...least, length_unit: null },
  'M10 time_unit': { ...least, time_unit: { s: 1 } },
  'M10 up no string': { ...least, up: 2 },
  'M10 up another axis': { ...least, up: 'x' },
  'M10 details': { ...least, details: [] },
  'M10 no grid': { ...least, features: ['means', 'grid'] },
  'M10 a grid of step 0': { ...least, grid: { origin: [0, 0, 0], step: 0 } },
};
for (const [name, value] of Object.entries(refused)) {
  test(`HEAD refused: ${name}`, () => {
    assert.ok(!head.accepts(value));
    assert.ok(!programAccepts(JSON.stringify(value)));
  });
}

const slab = { begin: '0x0p+0', end: '1', vertices: '5', lower: '0', upper: '0', means: '0',
  cells: '5', min: ['0', '0', '0', '0'], max: ['1', '0x1p0', '1e0', '1.0'], attributes: [] };
const body = { name: 'simplex', vertices: '5', cells: '5', begin: '0', end: '1',
  min: ['0', '-0x0p+0', '0.0'], max: ['1', '1', '0x1.8p-1'], hypervolume: '0x1.5555555555555p-5',
  vertices_checksum: 'd9ee7a69', cells_checksum: '807c9fb7', slabs: [slab] };
const attribute = { domain: 'cell', name: 'kind', type: '1', components: '1', checksum: '00c0ffee' };
const answer = (inBody = {}, inSlab = {}) =>
  ({ version: '1.0', features: [], bodies: [{ ...body, slabs: [{ ...slab, ...inSlab }], ...inBody }] });
const piece = { name: 'simplex', points: '4', triangles: '4', volume: '0x1.5555555555555p-6',
  area: '5.9150635094610965e-01', min: ['0', '0', '0'], max: ['0.5', '0.5', '0.5'] };
const cut = (more) => ({ bodies: [{ ...piece, ...more }] });
const huge = '18446744073709551615';

test('answers of readers that are in order', () => {
  describe.check(answer(), 'the simplex');
  describe.check({ ...answer(), version: '1.12', 'a further member': 1 }, 'later minor version');
  describe.check(answer({}, { attributes: [attribute, { ...attribute, domain: 'vertex' }] }), 'attributes');
  describe.check(answer({ vertices: '0', min: null, max: null }, { min: null, max: null }), 'no vertex');
  describe.check(answer({ vertices: huge, hypervolume: '-inf' }), 'very large');
  describe.check(answer({ hypervolume: 'nan' }), 'overflow of differences');
  slice.check(cut(), 'the simplex');
  slice.check(cut({ points: '0', triangles: '0', volume: '0', area: '0x0p+0', min: null, max: null }), 'empty');
});

test('answers of readers that are not', () => {
  const wrongNumbers = ['', ' 1', '1 ', 'x', '0x', '1e', '--1', '1,5', 1, null];
  for (const value of [...wrongNumbers, '01', '-1', '0x5', '5.0', '1e3']) {
    assert.ok(!describe.accepts(answer({ cells: value })), `a count: ${value}`);
    assert.ok(!slice.accepts(cut({ points: value })), `a count: ${value}`);
  }
  for (const value of wrongNumbers) {
    assert.ok(!describe.accepts(answer({ hypervolume: value })), `a double: ${value}`);
    assert.ok(!slice.accepts(cut({ area: value })), `a double: ${value}`);
  }
  assert.ok(!describe.accepts(answer({ begin: 'inf' })));
  assert.ok(!describe.accepts(answer({ min: ['0', '0'] })));
  assert.ok(!describe.accepts(answer({ vertices_checksum: 'c0ffee' })));
  assert.ok(!describe.accepts(answer({ cells_checksum: '0x807c9fb7' })));
  assert.ok(!describe.accepts(answer({}, { min: ['0', '0', '0'] })));
  assert.ok(!describe.accepts(answer({}, { attributes: [{ ...attribute, checksum: 'c0ffee' }] })));
  assert.ok(!describe.accepts(answer({}, { attributes: [{ ...attribute, checksum: '00C0FFEE' }] })));
  assert.ok(!describe.accepts(answer({}, { attributes: [{ ...attribute, type: '11' }] })));
  assert.ok(!describe.accepts(answer({}, { attributes: [{ ...attribute, components: '256' }] })));
  assert.ok(!describe.accepts({ ...answer(), version: '2.0' }));
  assert.ok(!slice.accepts({}));
  for (const key of Object.keys(answer())) {
    assert.ok(!describe.accepts({ ...answer(), [key]: undefined }), key);
  }
  for (const key of Object.keys(body)) assert.ok(!describe.accepts(answer({ [key]: undefined })), key);
  for (const key of Object.keys(slab)) assert.ok(!describe.accepts(answer({}, { [key]: undefined })), key);
  // Bounds may be missing where the reader chooses the axes.
  for (const key of Object.keys(piece).filter((each) => each !== 'min' && each !== 'max')) {
    assert.ok(!slice.accepts(cut({ [key]: undefined })), key);
  }
});

test('the answers in the specification', () => {
  const appendix = spec.split('\n## Appendix: a reader under test\n')[1];
  const [first, second] = [...appendix.matchAll(/^```json\n([^]*?)^```$/gm)]
    .map(([, json]) => JSON.parse(json));
  describe.check(first, 'describe');
  slice.check(second, 'slice 0.5');
});

test('the answers of our reader', () => {
  const ask = (file, ...question) => {
    const done = spawnSync(path.join(build, 't4d-reader'), [file, ...question.map(String)],
      { encoding: 'utf8' });
    assert.equal(done.status, 0, done.stderr);
    return JSON.parse(done.stdout);
  };
  for (const name of Object.keys(written)) {
    const file = at(`${name}.t4d`);
    describe.check(ask(file, 'describe'), `describe ${name}`);
    const { time_begin: begin, time_end: end } = t4d('info', file);
    for (const time of [begin - 1, begin, 0.3 * begin + 0.7 * end, end]) {
      slice.check(ask(file, 'slice', time), `slice ${time} of ${name}`);
    }
  }
});
