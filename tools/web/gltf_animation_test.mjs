// Animated glTF as a motion: the layers of what `t4d sweep` makes are the vertices that three.js
// computes at their times. The models are made here, like those of Khronos whose names they have.
import assert from 'node:assert/strict';
import { readFileSync, writeFileSync } from 'node:fs';
import path from 'node:path';
import test from 'node:test';

import validator from 'gltf-validator';
import * as THREE from 'three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';

import { makeFolder, t4d, t4dRaw } from './t4d.mjs';

globalThis.ProgressEvent ??= class ProgressEvent extends Event {};

const folder = makeFolder('gltf-animation');
const at = (name) => path.join(folder, name);
const widths = { SCALAR: 1, VEC3: 3, VEC4: 4, MAT4: 16 };

/** A glTF document with a buffer that grows. */
class Document {
  constructor(nodes, roots) {
    this.bytes = Buffer.alloc(0);
    this.json = {
      asset: { version: '2.0' }, scene: 0, scenes: [{ nodes: roots }], nodes,
      meshes: [], accessors: [], bufferViews: [], animations: [{ samplers: [], channels: [] }],
    };
  }
  accessor(type, values, array = Float32Array) {
    const numbers = array.from(values.flat());
    const rows = numbers.length / widths[type];
    const data = Buffer.from(numbers.buffer);
    this.json.bufferViews.push({ buffer: 0, byteOffset: this.bytes.length, byteLength: data.length });
    const made = { bufferView: this.json.bufferViews.length - 1, type, count: rows,
      componentType: { Float32Array: 5126, Uint16Array: 5123, Uint8Array: 5121 }[array.name] };
    if (type === 'VEC3' || (type === 'SCALAR' && array === Float32Array)) {
      const column = (k) => numbers.filter((_, i) => i % widths[type] === k);
      const axes = [...Array(widths[type]).keys()];
      made.min = axes.map((k) => Math.min(...column(k)));
      made.max = axes.map((k) => Math.max(...column(k)));
    }
    this.json.accessors.push(made);
    this.bytes = Buffer.concat([this.bytes, data, Buffer.alloc((4 - data.length % 4) % 4)]);
    return this.json.accessors.length - 1;
  }
  mesh({ positions, triangles }, more = {}) {
    this.json.meshes.push({ primitives: [{
      attributes: { POSITION: this.accessor('VEC3', positions), ...more.attributes },
      indices: this.accessor('SCALAR', triangles, Uint16Array),
      ...(more.targets && { targets: more.targets }),
    }], ...(more.weights && { weights: more.weights }) });
    return this.json.meshes.length - 1;
  }
  animate(node, property, interpolation, times, values, type) {
    const { samplers, channels } = this.json.animations[0];
    samplers.push({ input: this.accessor('SCALAR', times), interpolation,
      output: this.accessor(type, values) });
    channels.push({ sampler: samplers.length - 1, target: { node, path: property } });
  }
  write(name) {
    const uri = `data:application/octet-stream;base64,${this.bytes.toString('base64')}`;
    this.json.buffers = [{ byteLength: this.bytes.length, uri }];
    writeFileSync(at(name), JSON.stringify(this.json));
    return at(name);
  }
}

const turn = (axis, degrees) =>
  new THREE.Quaternion().setFromAxisAngle(new THREE.Vector3(...axis).normalize(), degrees * Math.PI / 180).toArray();

/** A box of 24 points, as those with normals have. */
function box(x, y, z) {
  const faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
  const corner = (i) => [(i & 1) * 2 * x - x, (i >> 1 & 1) * 2 * y - y, (i >> 2) * 2 * z - z];
  return { positions: faces.flat().map(corner),
    triangles: faces.flatMap((_, i) => [0, 1, 2, 0, 2, 3].map((k) => 4 * i + k)) };
}

function tube(rings, around, height) {
  const positions = [];
  const triangles = [];
  for (let i = 0; i <= rings; ++i) {
    for (let j = 0; j < around; ++j) {
      const angle = 2 * Math.PI * j / around;
      positions.push([Math.cos(angle) / 2, height * i / rings, Math.sin(angle) / 2]);
    }
  }
  const point = (i, j) => i * around + j % around;
  for (let i = 0; i < rings; ++i) {
    for (let j = 0; j < around; ++j) {
      triangles.push(point(i, j), point(i + 1, j), point(i, j + 1),
        point(i, j + 1), point(i + 1, j), point(i + 1, j + 1));
    }
  }
  for (let j = 1; j + 1 < around; ++j) {
    triangles.push(point(0, 0), point(0, j), point(0, j + 1),
      point(rings, 0), point(rings, j + 1), point(rings, j));
  }
  return { positions, triangles };
}

/** A hierarchy: the outer box turns and grows, the inner one slides in it; both are of one mesh, one
 * instance is mirrored. Every interpolation. */
function boxAnimated() {
  const made = new Document([
    { name: 'turning', translation: [0.5, 0, -0.25], children: [1, 2] },
    { name: 'outer', mesh: 0, scale: [1, 1.5, 2] },
    { name: 'inner', mesh: 0, translation: [3, 0, 0], rotation: turn([0, 1, 0], 30), children: [3] },
    { name: 'mirrored', mesh: 0, translation: [0, 3, 0], scale: [-1, 1, 1] },
    { name: 'still', mesh: 0, matrix: [0.5, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0, 7, 8, 9, 1] },
  ], [0, 4]);
  made.mesh(box(1, 0.5, 0.75));
  made.animate(0, 'rotation', 'LINEAR', [0, 1.25, 2.5], [turn([1, 2, 3], 0), turn([1, 2, 3], 120), turn([0, 1, 0], 200)], 'VEC4');
  made.animate(1, 'scale', 'LINEAR', [0.5, 2], [[1, 1.5, 2], [2, 1, 1]], 'VEC3');
  made.animate(2, 'translation', 'CUBICSPLINE', [0, 1, 2.5], [
    [0, 0, 0], [3, 0, 0], [0, 2, 0], [1, 0, 0], [3, 1, 1], [1, 0, -1], [0, 0, 3], [4, 0, 0], [0, 0, 0]], 'VEC3');
  made.animate(3, 'rotation', 'CUBICSPLINE', [0.25, 2], [
    [0, 0, 0, 0], turn([0, 0, 1], 0), [0.1, 0.2, 0.3, 0], [0, 0.5, 0, 0.1], turn([1, 0, 1], 100), [0, 0, 0, 0]], 'VEC4');
  return made.write('BoxAnimated.gltf');
}

/** A tube that bends about two joints. */
function riggedSimple() {
  const made = new Document([
    { name: 'armature', rotation: turn([1, 0, 0], -90), children: [1, 3] },
    { name: 'root', children: [2] },
    { name: 'tip', translation: [0, 2, 0] },
    { name: 'tube', mesh: 0, skin: 0, translation: [100, 0, 0] },
  ], [0]);
  const shape = tube(8, 10, 4);
  const bend = shape.positions.map(([, y]) => Math.min(1, Math.max(0, (y - 1) / 2)));
  const weights = made.accessor('VEC4', bend.map((w) => [1 - w, w, 0, 0]));
  const joints = made.accessor('VEC4', bend.map(() => [0, 1, 0, 0]), Uint8Array);
  made.mesh(shape, { attributes: { JOINTS_0: joints, WEIGHTS_0: weights } });
  const moved = (y) => [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, y, 0, 1];
  made.json.skins = [{ joints: [1, 2], inverseBindMatrices: made.accessor('MAT4', [moved(0), moved(-2)]) }];
  made.animate(2, 'rotation', 'LINEAR', [0, 1, 2], [turn([0, 0, 1], 0), turn([0, 0, 1], 60), turn([1, 0, 0], 40)], 'VEC4');
  made.animate(1, 'translation', 'LINEAR', [0, 2], [[0, 0, 0], [0, 0, 1]], 'VEC3');
  return made.write('RiggedSimple.gltf');
}

/** A box with two morph targets. */
function animatedMorphCube() {
  const made = new Document([{ name: 'cube', mesh: 0, rotation: turn([0, 0, 1], 20) }], [0]);
  const shape = box(1, 1, 1);
  const targets = [(p) => [0.3 * p[1], 0, 0.2], (p) => [p[0] > 0 ? 1 : 0, 0.5 * p[2], 0]]
    .map((displace) => ({ POSITION: made.accessor('VEC3', shape.positions.map(displace)) }));
  made.mesh(shape, { targets, weights: [0, 0] });
  made.animate(0, 'weights', 'LINEAR', [0, 1, 3], [0, 0.25, 1, 0, 0.5, 1], 'SCALAR');
  made.animate(0, 'rotation', 'LINEAR', [0, 3], [turn([0, 0, 1], 20), turn([0, 0, 1], 110)], 'VEC4');
  return made.write('AnimatedMorphCube.gltf');
}

/** A box that jumps, and one that is hidden for a while. */
function stepping() {
  const made = new Document([{ name: 'jumper', mesh: 0 }, { name: 'hider', mesh: 0, translation: [5, 0, 0] }], [0, 1]);
  made.mesh(box(1, 1, 1));
  made.animate(0, 'translation', 'STEP', [0, 1, 2], [[0, 0, 0], [0, 3, 0], [0, 3, 0]], 'VEC3');
  made.animate(1, 'scale', 'STEP', [0, 0.5, 1.5], [[1, 1, 1], [0, 0, 0], [1, 1, 1]], 'VEC3');
  return made.write('Stepping.gltf');
}

async function evaluator(file) {
  const bytes = readFileSync(file);
  const gltf = await new Promise((resolve, reject) =>
    new GLTFLoader().parse(bytes.toString(), '', resolve, reject));
  const mixer = new THREE.AnimationMixer(gltf.scene);
  const action = mixer.clipAction(gltf.animations[0]);
  action.setLoop(THREE.LoopOnce);
  action.clampWhenFinished = true;
  action.play();
  return (name, time) => {
    action.reset(); // it rests where it has come to its end
    mixer.setTime(time);
    gltf.scene.updateMatrixWorld(true);
    const mesh = gltf.scene.getObjectByName(name);
    mesh.skeleton?.update();
    return [...Array(mesh.geometry.attributes.position.count).keys()].map((i) =>
      mesh.getVertexPosition(i, new THREE.Vector3()).applyMatrix4(mesh.matrixWorld).toArray());
  };
}

const verticesOf = (file) => readFileSync(file, 'utf8').split('\n').filter((line) => line.startsWith('v '))
  .map((line) => line.slice(2).split(' ').map(Number));

/** The largest distance of a point of `a` from the nearest one of `b`. */
const farthest = (a, b) => Math.max(...a.map((p) => Math.min(...b.map((q) => Math.hypot(...p.map((x, k) => x - q[k]))))));

for (const [make, bodies] of [
  [boxAnimated, ['outer', 'inner', 'mirrored', 'still']],
  [riggedSimple, ['tube']],
  [animatedMorphCube, ['cube']],
]) {
  test(`${make.name}: the layers are what three.js computes`, async () => {
    const file = make();
    const { issues } = await validator.validateBytes(new Uint8Array(readFileSync(file)));
    assert.equal(issues.numErrors, 0, JSON.stringify(issues.messages));
    const evaluate = await evaluator(file);
    const out = file.replace('.gltf', '.t4d');
    const swept = t4d('sweep', file, '--tolerance', 0.05, '-o', out);
    assert.deepEqual(swept.bodies.map(({ name }) => name).sort(), [...bodies].sort());
    assert.equal(t4d('validate', out).valid, true);
    const { bodies: listed } = t4d('info', out, '--slabs');
    let layers = 0;
    for (const name of bodies) {
      const { slab_list: slabs } = listed.find((body) => body.name === name);
      const times = [...new Set(slabs.map(({ end }) => end))];
      assert.equal(times.length, swept.bodies.find((body) => body.name === name).steps + 1);
      for (const time of times) {
        t4d('slice', out, '--body', name, '--time', time, '-o', at('layer.obj'));
        const found = verticesOf(at('layer.obj'));
        const expected = evaluate(name, time);
        assert.ok(farthest(found, expected) < 1e-6, `${name} at ${time}: ${farthest(found, expected)}`);
        assert.ok(farthest(expected, found) < 1e-6, `${name} at ${time}`);
        ++layers;
      }
    }
    assert.ok(layers > 6, `${layers} layers`);
  });
}

test('a STEP curve ends a body and begins it anew', () => {
  const out = at('stepping.t4d');
  const swept = t4d('sweep', stepping(), '-o', out);
  assert.deepEqual(swept.bodies.map(({ name, steps, runs }) => ({ name, steps, runs })),
    [{ name: 'jumper', steps: 2, runs: 2 }, { name: 'hider', steps: 2, runs: 2 }]);
  const { valid, hypervolume } = t4d('validate', out);
  assert.ok(valid);
  assert.ok(Math.abs(hypervolume - (16 + 8)) < 1e-12, hypervolume);
  const volume = (body, time) => t4d('slice', out, '--body', body, '--time', time).volume;
  assert.equal(volume('hider', 1), 0);
  assert.ok(Math.abs(volume('hider', 1.75) - 8) < 1e-12);
  t4d('slice', out, '--body', 'jumper', '--time', 1, '-o', at('jumped.obj'));
  assert.equal(Math.min(...verticesOf(at('jumped.obj')).map(([, y]) => y)), 2);
});

test('what is no animation is refused', () => {
  const file = boxAnimated();
  const json = JSON.parse(readFileSync(file));
  const refused = (change, message) => {
    const changed = structuredClone(json);
    change(changed);
    writeFileSync(at('changed.gltf'), JSON.stringify(changed));
    const done = t4dRaw('sweep', at('changed.gltf'), '-o', at('changed.t4d'));
    assert.equal(done.status, 4, done.stderr);
    assert.match(done.stderr, message);
  };
  refused((g) => delete g.animations, /has no animation/);
  refused((g) => { g.animations[0].samplers[0].interpolation = 'QUINTIC'; }, /interpolation 'QUINTIC'/);
  refused((g) => { g.animations[0].samplers[0].input = 0; }, /accessors\[0\]: elements of 3 numbers/);
  refused((g) => { g.animations[0].samplers[0].output = g.animations[0].samplers[1].output; }, /elements of 3 numbers, expected 4/);
  refused((g) => { g.animations[0].channels[1].target = g.animations[0].channels[0].target; g.animations[0].channels[1].sampler = 0; }, /as another channel does/);
  refused((g) => { g.animations[0].samplers.forEach((s) => { g.accessors[s.input].count = 1; }); }, /numbers in all, expected/);
  const done = t4dRaw('sweep', file, '--animation', 'walk', '-o', at('none.t4d'));
  assert.match(done.stderr, /has no animation 'walk'; it has 0/);
});
