// USD in other software: three.js and tinyusdz read what `t4d flipbook` writes, and Chromium plays it.
import assert from 'node:assert/strict';
import { copyFileSync, mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import http from 'node:http';
import path from 'node:path';
import test from 'node:test';

import { chromium } from 'playwright-core';
import * as THREE from 'three';
import { USDAParser } from 'three/addons/loaders/usd/USDAParser.js';
import { USDLoader } from 'three/addons/loaders/USDLoader.js';

import { chromiumOptions } from './chromium.mjs';
import { makeFolder, root, t4d } from './t4d.mjs';

const folder = makeFolder('usd');
const at = (name) => path.join(folder, name);
const fixture = (name) => at(path.join('fixtures', name));

t4d('sweep', fixture('bolt.obj'), '--motion', fixture('screw-in.json'), '--up', 'z', '-o', at('bolt.t4d'));

const verticesOf = (file) => readFileSync(file, 'utf8').split('\n').filter((line) => line.startsWith('v '))
  .map((line) => line.slice(2).split(' ').map(Number));

/** The light slice at a time: its vertices, in the order of the mesh. */
function sliceAt(time) {
  t4d('slice', at('bolt.t4d'), '--time', time, '--light', '-o', at('slice.obj'));
  return verticesOf(at('slice.obj'));
}

function assertRounded(found, expected, what) {
  assert.equal(found.length, 3 * expected.length, what);
  expected.flat().forEach((number, i) =>
    assert.equal(Math.fround(found[i]), Math.fround(number), `${what}: number ${i}`));
}

function load(file) {
  const bytes = readFileSync(file);
  const buffer = bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength);
  return new USDLoader().parse(file.endsWith('.usdz') ? buffer : bytes.toString());
}

const meshOf = (scene) => scene.getObjectByProperty('isMesh', true);

test('three.js reads every sample', () => {
  t4d('flipbook', at('bolt.t4d'), '--frames', 5, '--velocity', '-o', at('bolt.usda'));
  const { specsByPath } = new USDAParser().parseData(readFileSync(at('bolt.usda'), 'utf8'));
  const { times, values } = specsByPath['/t4d/bolt.points'].fields.timeSamples;
  assert.deepEqual(times, [0, 1, 2, 3, 4]);
  times.forEach((frame) => assertRounded(values[frame], sliceAt(1.25 * frame), `frame ${frame}`));
  assert.equal(specsByPath['/t4d/bolt.velocities'].fields.timeSamples.values[2].length, values[2].length);
});

test('three.js shows the first frame, text or package, in metres with y up', () => {
  t4d('flipbook', at('bolt.t4d'), '--frames', 5, '-o', at('bolt.usdz'));
  const vertices = sliceAt(0);
  for (const name of ['bolt.usda', 'bolt.usdz']) {
    const scene = load(at(name));
    scene.updateMatrixWorld(true);
    const box = new THREE.Box3().setFromObject(scene);
    const axis = (k) => vertices.map((vertex) => vertex[k] / 1000);
    const close = (found, expected) => assert.ok(Math.abs(found - expected) < 1e-7, `${name}: ${found}, ${expected}`);
    close(box.min.x, Math.min(...axis(0)));
    close(box.max.y, Math.max(...axis(2)));
    close(box.max.z, -Math.min(...axis(1)));
  }
});

test('three.js plays poses', () => {
  t4d('flipbook', at('bolt.t4d'), '--frames', 48, '--rigid', '-o', at('rigid.usda'));
  const scene = load(at('rigid.usda'));
  const mixer = new THREE.AnimationMixer(scene);
  mixer.clipAction(scene.animations[0]).play();
  // The animation plays in real time.
  assert.ok(Math.abs(scene.animations[0].duration - 5) < 1e-6);
  for (const frame of [0, 10, 23.5, 47]) {
    mixer.setTime(Math.min(5 * frame / 47, 5 - 1e-6));
    scene.updateMatrixWorld(true);
    const found = new THREE.Box3().setFromObject(scene, true);
    const vertices = sliceAt(5 * frame / 47);
    const height = vertices.map((vertex) => vertex[2] / 1000);
    assert.ok(Math.abs(found.max.y - Math.max(...height)) < 1e-5, `${frame}: ${found.max.y}`);
    assert.ok(Math.abs(found.min.y - Math.min(...height)) < 1e-5, `${frame}: ${found.min.y}`);
  }
});

test('tinyusdz reads the same', async () => {
  // It is built for browsers, and looks which one it is in.
  const { type } = process;
  process.type = 'renderer';
  globalThis.window = globalThis;
  const built = (name) => path.join(root, 'tools/web/node_modules/tinyusdz', name);
  copyFileSync(built('tinyusdz.js'), at('tinyusdz.mjs'));  // which its package does not say that it is
  const { default: start } = await import(at('tinyusdz.mjs'));
  const wasmBinary = readFileSync(built('tinyusdz.wasm'));
  const library = await start({ wasmBinary });
  process.type = type;
  delete globalThis.window;
  t4d('frames', at('bolt.t4d'), '--frames', 5, '--light', '--format', 'usda', '-o', at('frames'));
  for (const [name, time] of [['bolt.usda', 0], ['bolt.usdz', 0], ['frames/frame_0002.usda', 2.5]]) {
    const loader = new library.TinyUSDZLoaderNative();
    assert.ok(loader.loadFromBinary(readFileSync(at(name)), name), `${name}: ${loader.error()}`);
    assert.equal(loader.numMeshes(), 1);
    const mesh = loader.getMesh(0);
    assertRounded(mesh.points, sliceAt(time), name);
    assert.equal(mesh.faceVertexIndices.length, 3 * 5388);
  }
});

/** Serves the packages, the pages of this folder and what the test has written. */
async function serve() {
  const folders = { '/three/': path.join(root, 'tools/web/node_modules/three'), '/usd/': folder };
  const server = http.createServer((request, response) => {
    const url = new URL(request.url, 'http://localhost').pathname;
    const mount = Object.keys(folders).find((prefix) => url.startsWith(prefix));
    if (!mount) return response.writeHead(404).end();
    response.setHeader('Content-Type', url.endsWith('.js') ? 'text/javascript' : url.endsWith('.html') ? 'text/html' : 'application/octet-stream');
    return response.end(readFileSync(path.join(folders[mount], url.slice(mount.length))));
  });
  await new Promise((resolve) => server.listen(0, '127.0.0.1', resolve));
  return server;
}

const page = `<!doctype html><style>body { margin: 0 }</style>
<script type="importmap">{ "imports": { "three": "/three/build/three.module.js", "three/addons/": "/three/examples/jsm/" } }</script>
<script type="module">
import * as THREE from 'three';
import { USDLoader } from 'three/addons/loaders/USDLoader.js';
const scene = new THREE.Scene();
scene.background = new THREE.Color('white');
scene.add(new THREE.HemisphereLight(0xffffff, 0x445566, 3));
const loaded = await new USDLoader().loadAsync('/usd/rigid.usda');
scene.add(loaded);
const mixer = new THREE.AnimationMixer(loaded);
mixer.clipAction(loaded.animations[0]).play();
const renderer = new THREE.WebGLRenderer({ antialias: true, preserveDrawingBuffer: true });
renderer.setSize(160, 320);
document.body.append(renderer.domElement);
const camera = new THREE.PerspectiveCamera(40, 0.5, 0.001, 1);
camera.position.set(0.03, 0, 0.11);
camera.lookAt(0, -0.02, 0);
window.show = (seconds) => {
  mixer.setTime(seconds);
  renderer.render(scene, camera);
  const pixels = new Uint8Array(160 * 320 * 4);
  renderer.getContext().readPixels(0, 0, 160, 320, 6408, 5121, pixels);
  let dark = 0, sum = 0;
  for (let i = 0; i < 160 * 320; ++i) if (pixels[4 * i] < 200) { ++dark; sum += Math.floor(i / 160); }
  return { dark, height: sum / dark };
};
window.ready = true;
</script>`;

test('Chromium plays it', async () => {
  mkdirSync(folder, { recursive: true });
  writeFileSync(at('play.html'), page);
  const server = await serve();
  const browser = await chromium.launch(chromiumOptions);
  try {
    const shown = await browser.newPage({ viewport: { width: 160, height: 320 } });
    shown.on('pageerror', (error) => console.error(error));
    await shown.goto(`http://127.0.0.1:${server.address().port}/usd/play.html`);
    await shown.waitForFunction('window.ready', null, { timeout: 60_000 });
    const first = await shown.evaluate('show(0)');
    const last = await shown.evaluate('show(1.95)');
    await shown.screenshot({ path: at('played.png') });
    // The bolt is seen, and has gone down.
    assert.ok(first.dark > 1000 && last.dark > 1000, JSON.stringify([first, last]));
    assert.ok(last.height < first.height - 5, JSON.stringify([first, last]));
  } finally {
    await browser.close();
    server.close();
  }
});
