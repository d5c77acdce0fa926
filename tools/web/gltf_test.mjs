// glTF in other software: the Khronos validator finds no problems, and three.js loads the slices.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import path from 'node:path';
import test from 'node:test';

import validator from 'gltf-validator';
import * as THREE from 'three';
import { MeshoptDecoder } from 'three/addons/libs/meshopt_decoder.module.js';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';

import { makeFolder, measureObj, t4d } from './t4d.mjs';

// three.js reads the data URI of a .gltf with an API that browsers have and node does not.
globalThis.ProgressEvent ??= class ProgressEvent extends Event {};

const folder = makeFolder('gltf');
const at = (name) => path.join(folder, name);

// One solid of each kind, each with a motion that is difficult in its own way.
const sweeps = [
  { model: 'cube', motion: 'rest', up: 'y', metres: 1 },
  { model: 'paper-cube', motion: 'paper-screw', up: 'y', metres: 1 },
  { model: 'hollow-cube', motion: 'several-segments', up: 'z', metres: 1e-3 },
  { model: 'two-boxes', motion: 'poses', up: 'y', metres: 1e-3 },
  { model: 'torus', motion: 'skew-axis', up: 'z', metres: 1e-3 },
  { model: 'bolt', motion: 'screw-in', up: 'z', metres: 1e-3 },
];

async function validate(file) {
  const report = await validator.validateBytes(new Uint8Array(readFileSync(file)), {
    uri: path.basename(file),
  });
  // The validator does not know all extensions, nor that one of them uses a buffer, and says so for
  // information only.
  const { messages } = report.issues;
  const unknown = messages.filter(({ code }) =>
    ['UNSUPPORTED_EXTENSION', 'INCOMPLETE_EXTENSION_SUPPORT'].includes(code));
  const unused = messages.filter(({ code, pointer }) =>
    unknown.length > 0 && code === 'UNUSED_OBJECT' && pointer === '/buffers/0');
  const known = messages.filter((message) => ![...unknown, ...unused].includes(message));
  assert.deepEqual(known, [], file);
  return report.info;
}

function load(file) {
  const bytes = readFileSync(file);
  const buffer = bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength);
  return new Promise((resolve, reject) => new GLTFLoader()
    .setMeshoptDecoder(MeshoptDecoder).parse(buffer, '', resolve, reject));
}

function meshesOf(scene) {
  const meshes = [];
  scene.traverse((object) => object.isMesh && meshes.push(object));
  return meshes;
}

/** Bounds in the scene: metres, y up. */
function boundsOf(objects) {
  const box = new THREE.Box3();
  for (const object of objects) box.expandByObject(object, true);
  return box;
}

/** Converts `measured` from the mesh's own units and axes to those of the scene. */
function expectedBounds(measured, up, metres) {
  const box = new THREE.Box3(new THREE.Vector3(...measured.min), new THREE.Vector3(...measured.max));
  const place = new THREE.Matrix4();
  // z up: (x, y, z) -> (x, z, -y)
  if (up === 'z') place.set(1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1);
  return box.applyMatrix4(place.premultiply(new THREE.Matrix4().makeScale(metres, metres, metres)));
}

/** Equal up to float32 and a rotation by quaternion. */
function assertSameBox(found, expected, what) {
  const size = expected.getSize(new THREE.Vector3()).length() +
    Math.max(...expected.min.toArray().map(Math.abs), ...expected.max.toArray().map(Math.abs));
  for (const end of ['min', 'max']) {
    const distance = found[end].distanceTo(expected[end]);
    assert.ok(distance <= 1e-6 * size,
      `${what}: ${end} is ${found[end].toArray()}, expected ${expected[end].toArray()}`);
  }
}

const countOf = (meshes, count) => meshes.reduce((sum, mesh) => sum + count(mesh.geometry), 0);

async function checkSlice(input, option, value, name, up, metres) {
  const obj = at(`${name}.obj`);
  const said = t4d('slice', input, option, value, '-o', obj);
  const measured = measureObj(obj);
  assert.equal(measured.vertices, said.vertices);
  assert.equal(measured.triangles, said.triangles);
  assert.ok(said.triangles > 0);
  assert.equal(said.closed, true);
  for (const extension of ['glb', 'gltf']) {
    const file = at(`${name}.${extension}`);
    const again = t4d('slice', input, option, value, '-o', file);
    assert.deepEqual(again, said);
    const info = await validate(file);
    assert.equal(info.totalVertexCount, said.vertices);
    assert.equal(info.totalTriangleCount, said.triangles);
    const meshes = meshesOf((await load(file)).scene);
    assert.equal(countOf(meshes, (g) => g.attributes.position.count), said.vertices);
    assert.equal(countOf(meshes, (g) => g.index.count / 3), said.triangles);
    assertSameBox(boundsOf(meshes), expectedBounds(measured, up, metres), file);
  }
}

/** The frames' nodes: children of the root. */
const framesOf = (gltf) => gltf.scene.children[0].children;

/** The volume that meshes enclose in the mesh's own units. */
function volumeOf(meshes) {
  const corner = [0, 1, 2].map(() => new THREE.Vector3());
  return meshes.reduce((sum, { geometry: { index, attributes: { position } } }) => {
    for (let i = 0; i < index.count; i += 3) {
      corner.forEach((point, k) => point.fromBufferAttribute(position, index.getX(i + k)));
      sum += corner[0].dot(corner[1].clone().cross(corner[2])) / 6;
    }
    return sum;
  }, 0);
}

async function checkFlipbook(input, frames, fps, name, ...options) {
  const file = at(name);
  const said = t4d('flipbook', input, '--frames', frames, '--fps', fps, '-o', file, ...options);
  const info = await validate(file);
  assert.equal(info.totalTriangleCount, said.triangles);
  const gltf = await load(file);
  const nodes = framesOf(gltf);
  assert.equal(nodes.length, frames);
  const shownNow = () => nodes.flatMap((node, i) => {
    const scale = node.scale.toArray();
    assert.ok(scale.every((s) => s === 0) || scale.every((s) => s === 1), `scale ${scale}`);
    return scale[0] === 1 ? [i] : [];
  });
  assert.deepEqual(shownNow(), [0], 'the rest pose');

  assert.equal(gltf.animations.length, 1);
  const clip = gltf.animations[0];
  assert.ok(Math.abs(clip.duration - frames / fps) < 1e-5 * clip.duration);
  const mixer = new THREE.AnimationMixer(gltf.scene);
  mixer.clipAction(clip).play();
  for (let frame = 0; frame < frames; ++frame) {
    for (const within of [0.02, 0.5, 0.98]) {
      mixer.setTime((frame + within) / fps);
      assert.deepEqual(shownNow(), [frame], `frame ${frame} + ${within}`);
    }
  }

  const times = nodes.map((node) => node.userData.time);
  assert.equal(times[0], said.time_begin);
  assert.equal(times[frames - 1], frames > 1 ? said.time_end : said.time_begin);
  assert.ok(times.every((time, i) => i === 0 || time > times[i - 1]));

  if (options.includes('--color')) {
    const colors = nodes.map((node) => meshesOf(node)[0].material.color.getHex());
    if (frames > 1) assert.equal(new Set(colors).size, frames, 'a colour for each time');
    for (const { geometry: { attributes: { normal, position } } } of nodes.flatMap(meshesOf)) {
      assert.equal(normal.count, position.count);
    }
  }

  // Each frame is the solid at its time: it has the volume of the exact slice.
  assert.equal(said.light, !options.includes('--exact'));
  for (const node of nodes.filter((_, i) => i % 7 === 0)) {
    const { volume, area } = t4d('slice', input, '--time', node.userData.time);
    // Quantized coordinates are counted in steps.
    const error = said.quantization_error ?? 0;
    const found = volumeOf(meshesOf(node)) * (error > 0 ? (2 * error) ** 3 : 1);
    const bound = 1e-5 * area ** 1.5 + 2 * area * error;
    assert.ok(Math.abs(found - volume) < bound, `volume at ${node.userData.time}`);
  }
}

/** The vertices of an .obj file. */
const verticesOf = (file) => readFileSync(file, 'utf8').split('\n')
  .filter((line) => line.startsWith('v '))
  .map((line) => new THREE.Vector3(...line.slice(2).split(' ').map(Number)));

/** One mesh, moved: at each time every vertex is where the light slice has it, within the bound. */
async function checkRigid(input, frames, fps, name) {
  const file = at(name);
  const said = t4d('flipbook', input, '--frames', frames, '--fps', fps, '--rigid', '-o', file);
  await validate(file);
  assert.equal(said.rigid, true);
  const gltf = await load(file);
  const [mesh, ...others] = meshesOf(gltf.scene);
  assert.deepEqual(others, []);
  const { position } = mesh.geometry.attributes;
  const [clip] = gltf.animations;
  assert.ok(Math.abs(clip.duration - frames / fps) < 1e-5 * clip.duration);
  const mixer = new THREE.AnimationMixer(gltf.scene);
  mixer.clipAction(clip).play();
  for (let frame = 0; frame < frames; frame += 1 + Math.floor(frames / 7)) {
    const time = said.time_begin + frame / Math.max(frames - 1, 1) * (said.time_end - said.time_begin);
    mixer.setTime(frame / fps);
    mesh.updateMatrix();
    const obj = at(`${name}.obj`);
    t4d('slice', input, '--time', time, '--light', '-o', obj);
    const expected = verticesOf(obj);
    assert.equal(position.count, expected.length);
    const found = new THREE.Vector3();
    for (let i = 0; i < position.count; ++i) {
      found.fromBufferAttribute(position, i).applyMatrix4(mesh.matrix);
      assert.ok(found.distanceTo(expected[i]) <= said.distance + 1e-5 * (1 + expected[i].length()),
        `vertex ${i} at ${time}: ${found.toArray()}, expected ${expected[i].toArray()}`);
    }
  }
}

/** One mesh with morph targets: at any time every vertex is where the light slice has it. */
async function checkMorph(input, frames, fps, name, ...options) {
  const file = at(name);
  const said = t4d('flipbook', input, '--frames', frames, '--fps', fps, '--morph', '-o', file, ...options);
  await validate(file);
  assert.equal(said.morph, true);
  const gltf = await load(file);
  const meshes = meshesOf(gltf.scene);
  const clips = gltf.animations;
  const seconds = frames / fps;
  if (frames > 1) assert.ok(Math.abs(clips[0].duration - seconds) < 1e-5 * seconds);
  const mixer = new THREE.AnimationMixer(gltf.scene);
  for (const clip of clips) mixer.clipAction(clip).play();
  const found = new THREE.Vector3();
  for (const fraction of frames > 1 ? [0, 0.013, 0.21, 0.5, 0.777, 1] : [0]) {
    const time = said.time_begin + fraction * (said.time_end - said.time_begin);
    mixer.setTime(fraction * (frames - 1) / fps);
    const obj = at(`${name}.obj`);
    t4d('slice', input, '--time', time, '--light', '-o', obj);
    const expected = verticesOf(obj);
    const size = Math.max(...expected.map((place) => place.length()));
    let index = 0;
    for (const mesh of meshes) {
      const { position, normal } = mesh.geometry.attributes;
      if (options.length > 0) {
        // Vertices are repeated; the surface is the same.
        assert.equal(normal.count, position.count);
        const { volume, area } = t4d('slice', input, '--time', time);
        const moved = Array.from({ length: position.count }, (_, i) =>
          mesh.getVertexPosition(i, new THREE.Vector3()).toArray()).flat();
        const geometry = { index: mesh.geometry.index,
          attributes: { position: new THREE.Float32BufferAttribute(moved, 3) } };
        assert.ok(Math.abs(volumeOf([{ geometry }]) - volume) < 1e-5 * area ** 1.5, `volume at ${time}`);
        continue;
      }
      for (let i = 0; i < position.count; ++i, ++index) {
        mesh.getVertexPosition(i, found);
        assert.ok(found.distanceTo(expected[index]) <= 1e-6 * size,
          `vertex ${i} at ${time}: ${found.toArray()}, expected ${expected[index].toArray()}`);
      }
    }
    if (options.length === 0) assert.equal(index, expected.length);
  }
}

/** Each vertex of slices with colours by triangle has the colour of its triangles. */
async function checkColors(input, time, name) {
  const file = at(name);
  const said = t4d('slice', input, '--time', time, '--color', 'triangle', '-o', file);
  assert.equal(said.color_range, null);
  await validate(file);
  const meshes = meshesOf((await load(file)).scene);
  const seen = new Set();
  for (const { material, geometry: { index, attributes: { color } } } of meshes) {
    assert.equal(material.vertexColors, true);
    const corner = (i) => [0, 1, 2, 3].map((k) => color.getComponent(index.getX(i), k)).join();
    for (let i = 0; i < index.count; i += 3) {
      assert.equal(corner(i), corner(i + 1));
      assert.equal(corner(i), corner(i + 2));
      seen.add(corner(i));
    }
  }
  const { triangles } = t4d('slice', input, '--time', time, '--light');
  assert.equal(seen.size, triangles, 'a colour for each triangle of the solid');
}

/** Positions of the vertices in the scene. */
function placesOf(objects) {
  return objects.flatMap((mesh) => {
    mesh.updateWorldMatrix(true, false);
    return Array.from({ length: mesh.geometry.attributes.position.count }, (_, i) =>
      mesh.getVertexPosition(i, new THREE.Vector3()).applyMatrix4(mesh.matrixWorld));
  });
}

/** Encoded as the options say, the scene is the same, up to the stated error. */
async function checkEncoded(input, metres, name, verb, ...options) {
  const plain = at(`plain-${name}`);
  const file = at(name);
  t4d(...verb, '-o', plain);
  const said = t4d(...verb, '-o', file, ...options);
  await validate(file);
  const found = placesOf(meshesOf((await load(file)).scene));
  const expected = placesOf(meshesOf((await load(plain)).scene));
  assert.equal(found.length, expected.length);
  const bound = metres * Math.sqrt(3) * (said.quantization_error ?? 0);
  for (const [i, place] of expected.entries()) {
    assert.ok(found[i].distanceTo(place) <= bound + 1e-6 * (1e-3 + place.length()), `vertex ${i} of ${name}`);
  }
  return said;
}

// three.js does not play it: what the file says is checked here and in gltf_writer_test.cpp.
test('flipbook by visibility', async () => {
  const input = at('visibility.t4d');
  const file = at('visibility.glb');
  t4d('sweep', at('fixtures/cube.obj'), '--motion', at('fixtures/skew-axis.json'), '-o', input);
  t4d('flipbook', input, '--frames', 5, '--visibility', '-o', file);
  await validate(file);
  const bytes = readFileSync(file);
  const document = JSON.parse(bytes.subarray(20, 20 + bytes.readUInt32LE(12)).toString());
  const frames = document.nodes.slice(1);
  assert.deepEqual(frames.map((node) => node.extensions.KHR_node_visibility.visible),
    [true, false, false, false, false]);
  assert.deepEqual(document.animations[0].channels.map(({ target }) =>
    target.extensions.KHR_animation_pointer.pointer),
  frames.map((_, i) => `/nodes/${i + 1}/extensions/KHR_node_visibility/visible`));
});

for (const { model, motion, up, metres } of sweeps) {
  const name = `${model}-${motion}`;
  const input = at(`${name}.t4d`);
  test(name, async (t) => {
    t4d('sweep', at(`fixtures/${model}.obj`), '--motion', at(`fixtures/${motion}.json`), '--up', up,
      '--rv-min', 0.95, '-o', input);
    const info = t4d('info', input);
    const between = (low, high, fraction) => low + fraction * (high - low);
    const times = [0, 0.31, 0.5, 1].map((f) => between(info.time_begin, info.time_end, f));
    for (const time of times) {
      await t.test(`slice at t = ${time}`, () =>
        checkSlice(input, '--time', time, `${name}-t${time}`, up, metres));
    }
    await t.test('envelope', async () => {
      const file = at(`${name}-envelope.glb`);
      const said = t4d('envelope', input, '-o', file);
      assert.equal(said.closed, true);
      assert.equal(said.self_intersections, 0);
      const report = await validate(file);
      assert.equal(report.totalTriangleCount, said.triangles);
      assert.ok(said.volume <= said.visits_volume * 1.02);
    });
    await t.test('slice with colours', () => checkColors(input, times[1], `${name}-colors.glb`));
    for (const [what, ...options] of [
      ['quantized', '--quantize', 12], ['meshopt', '--meshopt'],
      ['both', '--quantize', 15, '--meshopt'],
    ]) {
      await t.test(`slice, ${what}`, () => checkEncoded(input, metres, `${name}-${what}.glb`,
        ['slice', input, '--time', times[1]], ...options));
      await t.test(`morph flipbook, ${what}`, () => checkEncoded(input, metres,
        `${name}-morph-${what}.gltf`, ['flipbook', input, '-n', 5, '--morph'], ...options));
      await t.test(`flipbook, ${what}`, () =>
        checkFlipbook(input, 5, 24, `${name}-book-${what}.glb`, '--normals', 'flat', ...options));
    }
    // These have time as an axis: no units, and no up axis.
    for (const [axis, option] of ['--x', '--y', '--z'].entries()) {
      const value = between(info.bounds_min[axis], info.bounds_max[axis], 0.52);
      await t.test(`slice ${option} ${value}`, () =>
        checkSlice(input, option, value, `${name}${option}`, 'y', 1));
    }
    await t.test('slice by a hyperplane', () => {
      const middle = [0, 1, 2].map((i) => between(info.bounds_min[i], info.bounds_max[i], 0.5));
      const normal = [1, -2, 0.5, 0.25];
      const offset = normal[0] * middle[0] + normal[1] * middle[1] + normal[2] * middle[2] +
        normal[3] * between(info.time_begin, info.time_end, 0.5);
      return checkSlice(input, '--hyperplane', [...normal, offset].join(), `${name}-plane`, 'y', 1);
    });
    for (const [frames, fps, file] of [
      [1, 24, `${name}-1.glb`], [2, 1, `${name}-2.gltf`], [25, 24, `${name}-25.glb`],
    ]) {
      await t.test(`flipbook of ${frames}`, () => checkFlipbook(input, frames, fps, file));
      await t.test(`rigid flipbook of ${frames}`, () =>
        checkRigid(input, frames, fps, `rigid-${file}`));
      await t.test(`morph flipbook of ${frames}`, () =>
        checkMorph(input, frames, fps, `morph-${file}`));
      await t.test(`morph flipbook of ${frames} with normals`, () =>
        checkMorph(input, frames, fps, `morph-normals-${file}`, '--normals', 'crease:40'));
      await t.test(`exact flipbook of ${frames}`, () =>
        checkFlipbook(input, frames, fps, `exact-${file}`, '--exact'));
      await t.test(`flipbook of ${frames} with normals and colours`, () =>
        checkFlipbook(input, frames, fps, `normals-${file}`, '--normals', 'crease:40', '--color', 'time'));
    }
  });
}

test('collide: both solids at the first contact', async () => {
  for (const [name, model, motion] of [
    ['moving', 'paper-cube', 'paper-translation'], ['ring', 'torus', 'rest'],
  ]) {
    t4d('sweep', at(`fixtures/${model}.obj`), '--motion', at(`fixtures/${motion}.json`),
      '-o', at(`${name}.t4d`));
  }
  t4d('transform', at('ring.t4d'), '--move', 20, 0, 22, '-o', at('moved-ring.t4d'));
  const { pairs } = t4d('collide', at('moving.t4d'), at('moved-ring.t4d'), '-o', at('contacts.glb'));
  assert.equal(pairs[0].first_contact.time, 8);
  await validate(at('contacts.glb'));
  const { scene } = await load(at('contacts.glb'));
  assert.ok(meshesOf(scene).length > 0);
});
