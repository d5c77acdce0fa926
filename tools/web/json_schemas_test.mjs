// The program's --json output matches the schemas of its reports in every member.
import assert from 'node:assert/strict';
import { readFileSync, readdirSync, writeFileSync } from 'node:fs';
import path from 'node:path';
import test from 'node:test';

import { objectsIn, reportSchemas, schemaOf, walkSchema } from './schemas.mjs';
import { build, makeFolder, root, t4dRaw } from './t4d.mjs';
import { chunksOf, exampleOfSpec, reseal } from './t4d_file.mjs';

const folder = makeFolder('schemas');
const at = (name) => path.join(folder, name);
const fixture = (name) => at(`fixtures/${name}`);

const help = JSON.parse(t4dRaw('help', '--json').stdout);
const schemas = reportSchemas(help);

const docs = path.join(root, 'docs');
const pages = readdirSync(docs).filter((name) => name.endsWith('.md'));

// Members that are present in some cases only, and those with arbitrary content.
const optional = ['vertex_links_ok', 'hypervolume_expected', 'hypervolume_error', 'convergence',
  'slab_list', 'folds', 'crossings', 'mend', 'mended'];
// Members that are present in some compared meshes only.
const optionalOfMeshes = ['voxel_size', 'frames'];
const isComparedMesh = (verb, where) =>
  verb === 'compare' && /^(#\/properties)?\/([ab]|convergence.*\/levels\/(items|\d+))$/.test(where);
const isOptional = (verb, where, key) => optional.includes(key) ||
  (verb === 'sweep' && ['chord_bound', 'half_turns', 'voxel_size'].includes(key)) ||
  // Parts have it; mill has none.
  (verb !== 'mill' && key === 'part') ||
  // Only several bodies have this.
  (['measure', 'compare'].includes(verb) && key === 'bodies') ||
  // They are present if they are asked for.
  (verb === 'measure' && ['wall_thickness', 'normal_speed'].includes(key)) ||
  // Only an animated glTF has these.
  (verb === 'sweep' && ((key === 'bodies' && !where.endsWith('mend')) || key === 'tolerance' || (key === 'body' && where.includes('first')))) ||
  (isComparedMesh(verb, where) && optionalOfMeshes.includes(key));
const free = ['details', 'part'];

/** All verbs with --json, including nested ones. */
function verbsWithJson({ verbs, options }, words = []) {
  const here = options.some(({ names }) => names.includes('--json'));
  return [...(here ? [words.join('-')] : []),
    ...verbs.flatMap((verb) => verbsWithJson(verb, [...words, verb.name]))];
}

/** The file of SPEC.md with its cells modified by `alter`. */
function writeAltered(name, alter) {
  const bytes = exampleOfSpec();
  const { blocks: [stored] } = chunksOf(bytes).find(({ type }) => type === 'CONN');
  const cells = Array.from({ length: 5 }, (_, row) =>
    Array.from({ length: 4 }, (_, i) => stored.readUInt32LE(16 * row + 4 * i)));
  alter(cells).flat().forEach((index, i) => stored.writeUInt32LE(index, 4 * i));
  writeFileSync(at(name), reseal(bytes));
}

const turned = ([a, b, c, d]) => [b, a, c, d];

/** A glTF of a tetrahedron whose morph target pulls a corner through the triangle of the others, so that prisms fold. */
function foldingTetrahedron() {
  const numbers = [0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 1, 1, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, -2];
  const bytes = Buffer.concat([Buffer.from(Float32Array.from(numbers).buffer),
    Buffer.from(Uint16Array.from([0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3]).buffer)]);
  const accessor = (byteOffset, componentType, count, type) =>
    ({ bufferView: 0, byteOffset, componentType, count, type });
  return JSON.stringify({
    asset: { version: '2.0' }, nodes: [{ mesh: 0 }],
    meshes: [{ primitives: [{ attributes: { POSITION: 0 }, indices: 1, targets: [{ POSITION: 3 }] }] }],
    // The weights are 0 and 1, as the times.
    animations: [{ samplers: [{ input: 2, output: 2 }],
      channels: [{ sampler: 0, target: { node: 0, path: 'weights' } }] }],
    accessors: [accessor(0, 5126, 4, 'VEC3'), accessor(104, 5123, 12, 'SCALAR'),
      accessor(48, 5126, 2, 'SCALAR'), accessor(56, 5126, 4, 'VEC3')],
    bufferViews: [{ buffer: 0, byteLength: bytes.length }],
    buffers: [{ byteLength: bytes.length,
      uri: `data:application/octet-stream;base64,${bytes.toString('base64')}` }],
  });
}

function writeInputs() {
  writeAltered('simplex.t4d', (cells) => cells);
  writeAltered('open.t4d', (cells) => [[0, 1, 2, 4], ...cells.slice(1)]);
  writeAltered('twisted.t4d', (cells) => [turned(cells[0]), ...cells.slice(1)]);
  writeAltered('inside-out.t4d', (cells) => cells.map(turned));
  const simplex = readFileSync(at('simplex.t4d'));
  writeFileSync(at('cut.t4d'), simplex.subarray(0, 0x150));
  writeFileSync(at('flipped.t4d'), simplex.map((byte, i) => (i === 0x100 ? byte ^ 1 : byte)));
  writeFileSync(at('empty.t4d'), '');
  writeFileSync(at('not.t4d'), '{"bodies": []}');
  for (const [name, x] of [['right', 1], ['mirrored', -1]]) {
    writeFileSync(at(`${name}.obj`),
      `v 0 0 0\nv ${x} 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n`);
  }
  writeFileSync(at('folding.gltf'), foldingTetrahedron());
  // The volume of this mesh overflows a double: its coordinates of 10 become 1e151.
  writeFileSync(at('three.json'), '{"segments": [{"duration": 3}]}');
  t4dRaw('sweep', fixture('cube.obj'), '--motion', at('three.json'), '--caps', 'cone', '--compression', 0,
    '-o', at('huge.t4d'));
  const huge = readFileSync(at('huge.t4d'));
  for (const { type, payload } of chunksOf(huge)) {
    if (!['LAYR', 'DONE', 'INDX'].includes(type)) continue;
    for (let i = 0; i + 8 <= payload.length; i += 8) {
      const number = payload.readDoubleLE(i);
      if (Math.abs(number) === 10) payload.writeDoubleLE(number * 1e150, i);
    }
  }
  writeFileSync(at('huge.t4d'), reseal(huge));
  t4dRaw('sweep', fixture('cube.obj'), '--motion', fixture('paper-screw.json'), '--steps', 5, '-o', at('swept.t4d'));
  const swept = readFileSync(at('swept.t4d'));
  const { payload } = chunksOf(swept).filter(({ type }) => type === 'SLAB')[3];
  const hit = payload.byteOffset - swept.byteOffset + 5;
  writeFileSync(at('swept-cut.t4d'), swept.subarray(0, hit));
  writeFileSync(at('swept-flipped.t4d'), swept.map((byte, i) => (i === hit ? byte ^ 1 : byte)));
}
writeInputs();

// [verb, arguments, exit code]; in this order, since later ones read files of earlier ones.
const sweep = (solid, motion, ...more) =>
  ['sweep', [fixture(`${solid}.obj`), '--motion', fixture(`${motion}.json`), ...more], 0];
const voxels = ['--voxel-size', 4, '--frames', 4];
const runs = [
  ['version', [], 0],
  sweep('cube', 'rest', '-o', at('rest.t4d')),
  sweep('torus', 'several-segments', '--caps', 'cone', '--rv-min', 0.9, '-o', at('torus.t4d')),
  sweep('cube', 'paper-screw', '--part', '1/2', '-o', at('first.t4d')),
  sweep('cube', 'paper-screw', '--part', '2/2', '-o', at('second.t4d')),
  ['join', [at('first.t4d'), at('second.t4d'), '-o', at('joined.t4d')], 0],
  ['join', [at('second.t4d'), at('first.t4d'), '-o', at('joined.t4d')], 4],
  ['merge', [at('first.t4d'), at('joined.t4d'), '-o', at('merged.t4d')], 0],
  ['sweep', [path.join(folder, 'fixtures/arm.json'), '--caps', 'cone', '-o', at('arm.t4d')], 0],
  ['mend', [fixture('crossing-balls.stl'), '-o', at('balls.ply')], 0],
  ['mend', [fixture('open-pebble.stl'), '-o', at('pebble.off')], 0],
  ['mend', [fixture('open-pebble.stl'), '--max-hole', 1, '-o', at('none.ply')], 4],
  ['mend', [fixture('cube.obj'), '-o', at('none.xyz')], 2],
  ['sweep', [fixture('open-pebble.stl'), '--motion', fixture('rest.json'), '--mend', '-o', at('pebble.t4d')], 0],
  ['transform', [at('first.t4d'), '--axes', 'y-xz', '--scale', '2', '--time-shift', '1', '-o', at('moved.t4d')], 0],
  ['transform', [at('first.t4d'), '--axes', 'xtz-y', '-o', at('moved.t4d')], 3],
  ['transform', [at('no such file'), '-o', at('moved.t4d')], 4],
  ['filter', [at('joined.t4d'), '--from', '0.7', '-o', at('filtered.t4d')], 0],
  ['filter', [at('joined.t4d'), '--from', '1000', '-o', at('none.t4d')], 4],
  ['simplify', [at('filtered.t4d'), '--ratio', '0.7', '-o', at('simplified.t4d')], 0],
  ['diff', [at('joined.t4d'), at('joined.t4d')], 0],
  ['diff', [at('joined.t4d'), at('filtered.t4d')], 1],
  ['compress', [at('filtered.t4d'), '--grid-step', '0.01', '-o', at('compressed.t4d')], 0],
  ['collide', [at('filtered.t4d'), at('torus.t4d'), '--clearance', 1, '--ignore-units'], 0],
  ['collide', [at('filtered.t4d'), at('swept.t4d'), '--fail-on-contact'], 1],
  ['collide', [at('rest.t4d'), at('simplex.t4d'), '--ignore-units'], 0],
  ['collide', [at('filtered.t4d')], 4],
  ['envelope', [at('filtered.t4d'), '--voxel-size', 1, '-o', at('envelope.glb')], 0],
  ['envelope', [at('filtered.t4d'), '--voxel-size', 2, '--each'], 0],
  ['envelope', [at('filtered.t4d'), '--voxel-size', 2, '--dwell', at('dwell.vdb')], 0],
  ['envelope', [at('filtered.t4d'), '--voxel-size', 2, '--dwell', at('dwell-1.vdb'), '--part', '1/2'], 0],
  ['envelope', [at('filtered.t4d'), '--voxel-size', 2, '--dwell', at('dwell-2.vdb'), '--part', '2/2'], 0],
  ['join', [at('dwell-1.vdb'), at('dwell-2.vdb'), '-o', at('joined.vdb')], 0],
  ['join', [at('dwell-2.vdb'), '-o', at('none.vdb')], 4],
  ['view', [at('filtered.t4d'), '-o', at('filtered.html')], 0],
  ['track', [at('filtered.t4d')], 0],
  ['track', [at('filtered.t4d'), '--surfaces', '--min-volume', 1, '-o', at('tracks.graphml'), '--events', at('events.csv')], 0],
  ['quality', [at('filtered.t4d')], 0],
  ['quality', [at('filtered.t4d'), '--worst', 0, '-o', at('shaped.t4d')], 0],
  ['transform', [at('rest.t4d'), '--move', '19.5', '1', '1', '-o', at('beside.t4d')], 0],
  ['resolve', [at('beside.t4d'), at('rest.t4d'), '-o', at('resolved.t4d')], 0],
  ['resolve', [at('beside.t4d'), at('resolved.t4d'), '--clearance', '0.01', '-o', at('apart.t4d')], 0],
  ['resolve', [at('rest.t4d'), at('beside.t4d'), '--max-move', '0.1', '-o', at('none.t4d')], 1],
  ['du', [at('filtered.t4d')], 0],
  ['convert', [fixture('24-cell.off'), at('24-cell.t4d')], 0],
  ['convert', [at('24-cell.t4d'), at('24-cell.mesh')], 3],
  ['convert', [at('24-cell.t4d'), at('24-cell.4do'), '--accept-loss'], 0],
  ['convert', [fixture('16-cell.off'), at('16-cell.nothing')], 2],
  ['formats', [], 0],
  sweep('paper-cube', 'paper-screw', '--steps', 3, '--prism', 3, '-o', at('screw.t4d')),
  sweep('paper-cube', 'paper-voxel', '--backend', 'voxel4d', ...voxels, '-o', at('voxels.t4d')),
  ['sweep', [fixture('bending_0.obj'), fixture('bending.pc2'), '--union', '--voxel-size', 2, '-n', 3, '-o', at('union.t4d')], 0],
  ['sweep', [fixture('bending_0.obj'), fixture('bending.pc2'), '-o', at('bending.t4d')], 0],
  ['sweep', [at('folding.gltf'), '--caps', 'cone', '-o', at('folding.t4d')], 0],
  ['sweep', [at('right.obj'), at('mirrored.obj'), '--frame-time', 1, '--caps', 'cone', '-o', at('folds.t4d')], 0],
  ['sweep', [at('none.obj'), '--motion', fixture('rest.json'), '-o', at('none.t4d')], 4],
  ['sweep', [fixture('cube.obj')], 2],
  ['voxelize', [fixture('torus.obj'), '--motion', fixture('rest.json'), '--voxel-size', 1,
    '--frames', 2, '-o', at('level-sets')], 0],
  ['voxelize', [fixture('paper-cube.obj'), '--motion', fixture('paper-voxel.json'), ...voxels,
    '--mask', '-o', at('masks')], 0],
  ['voxelize', [fixture('touching-cubes.stl'), '--motion', fixture('rest.json'), '--voxel-size', 2,
    '--frames', 2, '--mend', '-o', at('mended')], 0],
  // No lattice point lies inside.
  ['voxelize', [fixture('cube.obj'), '--motion', fixture('rest.json'), '--voxel-size', 1000,
    '--frames', 2, '--mask', '-o', at('none')], 0],
  ['weave', [at('level-sets'), '-o', at('woven.t4d')], 0],
  ['weave', [at('masks'), '--caps', 'half-step', '--precision', 'float32', '-o', at('masks.t4d')], 0],
  ['weave', [fixture('labels.nrrd'), '--label', '1', '-o', at('labels.t4d')], 0],
  ['weave', [fixture('bending_0.obj'), fixture('bending_1.obj'), '--voxel-size', 1, '-o', at('bent.t4d')], 0],
  ['weave', [at('no such folder'), '-o', at('none.t4d')], 4],
  ['rasterize', [at('screw.t4d'), ...voxels, '-o', at('rasterized')], 0],
  ['rasterize', [at('voxels.t4d'), '--voxel-size', 2, '--frame-time', 1, '--mask', '-o', at('rasterized')], 0],
  ['rasterize', [at('cut.t4d'), ...voxels, '-o', at('none')], 4],
  ['mill', [fixture('cube.obj'), '--tool', 'flat:d=6,l=25', '--holder', 'd=20,l=9', '--gcode', fixture('parting.nc'),
    '--voxel-size', 2, '--frames', 4, '-o', at('milled.t4d')], 0],
  ['mill', [fixture('cube.obj'), '--tool', '1=flat:d=6,l=25', '--tool', '2=drill:d=4,l=20', '--holder', '2=d=20,l=9',
    '--gcode', fixture('plate.nc'), '--voxel-size', 2, '--frames', 4, '-o', at('plate.t4d')], 0],
  ['mill', [fixture('open-pebble.stl'), '--tool', 'flat:d=6,l=9', '--gcode', fixture('parting.nc'), '--voxel-size', 2,
    '-o', at('none.t4d')], 4],
  ['slice', [at('simplex.t4d'), '--time', 0.5], 0],
  ['slice', [at('torus.t4d'), '--x', 0.5, '--coplanar', 'merge'], 0],
  ['slice', [at('torus.t4d'), '--x', 0], 0],
  ['slice', [at('torus.t4d'), '--time', 1.3, '--light'], 0],
  ['slice', [at('voxels.t4d'), '--time', 1.3, '--light'], 0],
  ['slice', [at('torus.t4d'), '--x', 0, '--light'], 2],
  ['slice', [at('torus.t4d'), '--hyperplane', '1,-2,0.5,0.25,3', '-o', at('plane.ply')], 0],
  ['slice', [at('simplex.t4d'), '--z', 1000], 0],
  ['slice', [at('open.t4d'), '--time', 0.5], 0],
  ['slice', [at('inside-out.t4d'), '--time', 0.5], 0],
  ['slice', [at('huge.t4d'), '--time', 0.5], 0],
  ['slice', [at('screw.t4d'), '--time', 1, '--attributes', '-o', at('lossy.stl')], 3],
  ['slice', [at('simplex.t4d'), '--time', 2], 4],
  ['flipbook', [at('screw.t4d'), '--frames', 3, '-o', at('screw.glb')], 0],
  ['flipbook', [at('torus.t4d'), '--frames', 3, '--rigid', '-o', at('rigid.glb')], 0],
  ['flipbook', [at('torus.t4d'), '--frames', 3, '--morph', '-o', at('morph.glb')], 0],
  ['flipbook', [at('torus.t4d'), '--frames', 3, '--color', 'attribute:kind', '--quantize', 12, '-o', at('q.glb')], 0],
  ['flipbook', [at('voxels.t4d'), '--frames', 3, '--morph', '-o', at('morph.glb')], 4],
  ['flipbook', [at('voxels.t4d'), '--frames', 3, '--rigid', '-o', at('rigid.glb')], 4],
  ['flipbook', [at('torus.t4d'), '--frames', 3, '--exact', '-o', at('torus.glb')], 0],
  ['flipbook', [at('screw.t4d'), '--times', '1:2:1', '--fps', 0.5, '-o', at('screw.gltf')], 0],
  ['flipbook', [at('cut.t4d'), '--frames', 3, '-o', at('none.glb')], 4],
  ['frames', [at('screw.t4d'), '--count', 3, '-o', at('frames')], 0],
  ['frames', [at('torus.t4d'), '--count', 2, '--format', 'vdb', '--voxel-size', 0.5, '-o', at('grid-frames')], 0],
  ['frames', [at('torus.t4d'), '--times', '1:2:2', '--light', '-o', at('frames_%d.vtp')], 0],
  ['frames', [at('torus.t4d'), '--count', 2, '--attributes', '--format', 'stl', '-o', at('lossy')], 3],
  ['frames', [at('cut.t4d'), '--count', 3, '-o', at('none')], 4],
  ['measure', [at('voxels.t4d'), '--frames', 3, '-o', at('volumes.csv')], 0],
  ['measure', [at('arm.t4d'), '--frames', 2], 0],
  ['measure', [at('arm.t4d'), '--frames', 2, '--thickness', '--normal-speed'], 0],
  ['measure', [at('voxels.t4d'), '--at-frames'], 0],
  // A simplex is a corner at its last time.
  ['measure', [at('simplex.t4d'), '--frames', 2], 0],
  ['measure', [at('screw.t4d'), '--times', '0:1000:2'], 4],
  ['measure', [at('cut.t4d')], 4],
  ['info', [at('simplex.t4d')], 0],
  ['info', [at('torus.t4d')], 0],
  ['info', [at('torus.t4d'), '--slabs'], 0],
  ['info', [at('masks.t4d')], 0],
  ['info', [at('huge.t4d')], 0],
  ['info', [at('cut.t4d')], 4],
  ['validate', [at('simplex.t4d')], 0],
  ['validate', [at('screw.t4d'), '--deep'], 0],
  ['validate', [at('torus.t4d'), '--deep'], 0, ['cap-vertex-link']],
  ['validate', [at('open.t4d')], 4, ['facet-not-shared-by-two']],
  ['validate', [at('twisted.t4d')], 4, ['facet-orientation']],
  ['validate', [at('inside-out.t4d'), '--deep'], 4, ['inside-out']],
  ['validate', [at('huge.t4d')], 0],
  ['validate', [at('cut.t4d'), '--deep'], 4, ['file-damaged']],
  ['validate', [at('flipped.t4d')], 4, ['file-damaged']],
  ['validate', [at('empty.t4d')], 4, ['file-damaged']],
  ['validate', [at('not.t4d')], 4, ['file-damaged']],
  ['validate', [at('no such file.t4d')], 4],
  ['recover', [at('simplex.t4d'), '-o', at('same.t4d')], 0],
  ['recover', [at('swept-cut.t4d'), '-o', at('swept-saved.t4d')], 3],
  ['recover', [at('swept-flipped.t4d'), '-o', at('swept-saved.t4d')], 3],
  ['recover', [at('open.t4d'), '-o', at('open-saved.t4d')], 1],
  ['recover', [at('cut.t4d'), '-o', at('none.t4d')], 4],
  ['recover', [at('not.t4d'), '-o', at('none.t4d')], 4],
  ['recover', [at('simplex.t4d'), '-o', at('simplex.t4d')], 2],
  ['compare', [fixture('paper-cube.obj'), '--motion', fixture('paper-voxel.json'), ...voxels,
    '--slices', 3], 0],
  ['compare', [at('screw.t4d'), at('voxels.t4d'), '--times', '0:1:2'], 0],
  ['compare', [at('arm.t4d'), at('arm.t4d'), '--slices', 2, '--each-body'], 0],
  // Only one of them exists at the last time.
  ['compare', [at('simplex.t4d'), at('rest.t4d'), '--times', '0:10:3'], 0],
  ['compare', [at('huge.t4d'), at('huge.t4d'), '--slices', 1], 0],
  ['compare', [at('cut.t4d'), at('voxels.t4d')], 4],
  ['compare', [fixture('cube.obj')], 2],
  ['conform-backends', ['--case', 'cube-at-rest', '--case', 'growing-sphere', '--quick'], 0],
  ['conform-backends', ['--case', 'cube-at-rest', '--backend-program', 'false'], 1],
  ['conform-backends', ['--case', 'no such'], 2],
  ['conform-list', [], 0],
  ['conform-list', ['--only', 'no such'], 2],
  ['conform-reader', ['--reader', path.join(build, 't4d-reader'), '--only', 'valid', '--skip', '*zstd*'], 0],
  ['conform-reader', ['--reader', 'false'], 1],
  ['conform-reader', ['--reader', './no-such'], 2],
  ['conform-writer', ['--writer', path.join(root, 'conformance/writers/python/t4d_writer.py'), '--only', 'cube-*'], 0],
  ['conform-writer', ['--writer', 'false', '--only', 'cube-*'], 1],
  ['conform-writer', ['--writer', './no-such'], 2],
];

/** Whether a verb prints JSON even if it fails. */
const answersOfFailure = (verb, args, status) =>
  verb === 'validate' ? !args[0].includes('no such') :
  verb === 'recover' ? args[0].includes('open') || args[0].includes('cut') :
  (['collide', 'diff'].includes(verb) || verb.startsWith('conform')) && status === 1;

for (const [verb, args, status, codes] of runs) {
  const words = args.map((arg) => String(arg).replace(`${folder}/`, ''));
  test(`t4d ${verb} ${words.join(' ')}: exit ${status}`, () => {
    const done = t4dRaw(...verb.split('-'), ...args, '--json');
    assert.equal(done.status, status, done.stderr);
    const answers = status === 0 || status === 3 || answersOfFailure(verb, args, status);
    if (!answers) {
      assert.equal(done.stdout, '');
      assert.notEqual(done.stderr, '');
      return;
    }
    const said = JSON.parse(done.stdout);
    const { check, accepts } = schemas.get(verb);
    check(said, done.stdout);
    if (codes) assert.deepEqual([...new Set(said.issues.messages.map(({ code }) => code))], codes);

    for (const { object, where } of objectsIn(said, free)) {
      object['not in the schema'] = 0;
      assert.ok(!accepts(said), `${where}: a member more`);
      delete object['not in the schema'];
      for (const [key, value] of Object.entries(object)) {
        if (isOptional(verb, where, key)) continue;
        delete object[key];
        assert.ok(!accepts(said), `${where}/${key} left out`);
        object[key] = value;
      }
    }
    check(said, 'unchanged again');
  });
}

test('the manifest of frames is as its schema says', () => {
  const { check, schema } = schemaOf('convert/frames_manifest.schema.json');
  for (const name of ['frames/manifest.json', 'frames.manifest.json', 'lossy/manifest.json',
    'grid-frames/manifest.json']) {
    check(JSON.parse(readFileSync(at(name), 'utf8')), name);
  }
  const page = readFileSync(path.join(docs, 'frames.md'), 'utf8');
  check(JSON.parse(/^```\n(\{\n[^]*?)^```$/m.exec(page)[1]), 'frames.md');
  walkSchema(schema, (part) => Object.values(part.properties ?? {}).forEach((member) =>
    assert.ok(member.description)));
});

test('help as JSON is as its schema says', () => {
  const { check } = schemaOf('docs/schemas/help.json');
  check(help, 'help');
  const slice = help.verbs.find(({ name }) => name === 'slice');
  assert.deepEqual(JSON.parse(t4dRaw('slice', '--help', '--json').stdout), slice);
  const { value, choices } = slice.options.find(({ names }) => names.includes('--coplanar'));
  assert.deepEqual([value, choices], ['TEXT', ['keep', 'merge']]);
});

test('every verb with --json has a schema, and runs here', () => {
  const verbs = verbsWithJson(help);
  assert.ok(verbs.includes('validate'));
  assert.deepEqual([...schemas.keys()].sort(), [...verbs].sort());
  const done = new Set(runs.filter(([, , status]) => status === 0).map(([verb]) => verb));
  assert.deepEqual([...done].sort(), [...verbs].sort());
});

for (const [verb, { schema }] of schemas) {
  test(`the schema of ${verb} describes every member and leaves none open`, () => {
    assert.equal(schema.$schema, 'https://json-schema.org/draft/2020-12/schema');
    assert.equal(schema.title, `t4d ${verb.replaceAll('-', ' ')} --json`);
    assert.ok(schema.description);
    walkSchema(schema, (part, where) => {
      if (part.type !== 'object' || !part.properties) return;
      assert.equal(part.additionalProperties, false, where);
      const members = Object.keys(part.properties);
      assert.deepEqual(part.required, members.filter((name) => !isOptional(verb, where, name)), where);
      for (const name of members) {
        assert.match(part.properties[name].description, /./, `${where}/${name}`);
      }
    });
  });
}

test('info: a body without vertices, first or last, does not count for the bounds of all', () => {
  const bytes = readFileSync(path.join(root, 'conformance/corpus/files/valid/body-without-vertices.t4d'));
  const swapped = Buffer.from(bytes);
  for (const { type, payload, fields, blocks } of chunksOf(swapped)) {
    const swap = (numbers, at) => numbers.writeUInt32LE(1 - numbers.readUInt32LE(at), at);
    if (type === 'SLAB') swap(fields, 40);
    if (type === 'INDX') for (let at = 0; at < blocks[4].length; at += 4) swap(blocks[4], at);
    const summary = 88;
    if (type === 'DONE') payload.set([...payload.subarray(16 + summary), ...payload.subarray(16, 16 + summary)], 16);
  }
  writeFileSync(at('empty-first.t4d'), bytes);
  writeFileSync(at('empty-last.t4d'), reseal(swapped));
  for (const name of ['empty-first.t4d', 'empty-last.t4d']) {
    const done = t4dRaw('info', at(name), '--json');
    assert.equal(done.status, 0, done.stderr);
    const info = JSON.parse(done.stdout);
    schemas.get('info').check(info, name);
    assert.deepEqual([info.bounds_min, info.bounds_max], [[0, 0, 0], [1, 1, 1]], name);
  }
});

test('the issue codes of docs/validate.md are those of the schema, with their severities', () => {
  const page = readFileSync(path.join(root, 'docs/validate.md'), 'utf8');
  const table = [...page.matchAll(/^\| `([a-z-]+)` \| (error|warning|information|hint) \|/gm)];
  const { code, severity } = schemas.get('validate').schema.properties.issues.properties.messages.items.properties;
  assert.deepEqual(table.map(([, name]) => name).sort(), [...code.enum].sort());
  const warnings = /1 warning \(([^)]*)\)/.exec(severity.description)[1].split(', ');
  assert.deepEqual(table.filter(([, , word]) => word === 'warning').map(([, name]) => name), warnings);
  assert.ok(table.every(([, , word]) => word === 'warning' || word === 'error'));
});

test('the page of a verb names all members of its report', () => {
  const pageOf = { voxelize: 'weave', rasterize: 'weave', version: 'json' };
  for (const [verb, { schema }] of schemas) {
    const name = `${pageOf[verb] ?? verb.split('-')[0]}.md`;
    const page = readFileSync(path.join(docs, name), 'utf8');
    const words = new Set(page.match(/\w+/g));
    walkSchema(schema, (part, where) => Object.keys(part.properties ?? {}).forEach((member) =>
      assert.ok(words.has(member), `${name}: ${verb} ${where}/${member}`)));
  }
});

test('JSON in the pages is as the schemas say', () => {
  let found = 0;
  for (const name of pages) {
    const page = readFileSync(path.join(docs, name), 'utf8');
    const examples = [
      ...[...page.matchAll(/^```json\n([^]*?)^```$/gm)].map(([, json]) => [path.parse(name).name, json]),
      ...[...page.matchAll(/^\$ t4d (\S+) .*--json\n(\{\n[^]*?^\})$/gm)].map(([, ...both]) => both),
    ];
    for (const [verb, json] of examples.filter(([verb]) => schemas.has(verb))) {
      ++found;
      schemas.get(verb).check(JSON.parse(json), name);
    }
  }
  assert.ok(found >= 2);
});
