// Left: five moments of the bolt, slices t = const. Right: its slice x = 0, with the same five
// moments drawn on it. Everything in the mesh's own millimetres, z up.
import * as THREE from 'three';
import { RoomEnvironment } from 'three/addons/environments/RoomEnvironment.js';
import { LineMaterial } from 'three/addons/lines/LineMaterial.js';
import { LineSegments2 } from 'three/addons/lines/LineSegments2.js';
import { LineSegmentsGeometry } from 'three/addons/lines/LineSegmentsGeometry.js';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';

const WIDTH = 1600;
const HEIGHT = 700;
const SPLIT = 985;  // width of the left part in pixels
const TIMES = [0, 1.3, 2.6, 3.9, 5];
const TIME_SCALE = 11;  // mm per second
const SPACING = 23.2;
const BLOCK_TOP = -7.5;  // where the head comes to rest
const BLOCK_BOTTOM = -53;

const ACCENTS = ['#1f5fae', '#2a8a8a', '#5c9a3c', '#d08a1d', '#c2402e'];

const renderer = new THREE.WebGLRenderer({
  canvas: document.querySelector('canvas'), antialias: true, alpha: true,
});
renderer.setPixelRatio(2);
renderer.setSize(WIDTH, HEIGHT, false);
renderer.shadowMap.enabled = true;
renderer.shadowMap.type = THREE.PCFShadowMap;
renderer.toneMapping = THREE.NeutralToneMapping;
renderer.autoClear = false;
const environment = new THREE.PMREMGenerator(renderer)
  .fromScene(new RoomEnvironment(), 0.03).texture;

/** The geometry of the only mesh in a file, in the mesh's own units and axes. */
async function geometryOf(file) {
  const gltf = await new GLTFLoader().loadAsync(`/demo/${file}`);
  let geometry;
  gltf.scene.traverse((object) => { geometry ??= object.geometry; });
  return geometry;
}

/** A scene lit from around `lightFrom` by several weak lights, for soft shadows. */
function makeScene(target, lightFrom, reach) {
  const LIGHTS = 10;  // with the environment, the number of textures that WebGL guarantees
  const SPREAD = 22;
  const scene = new THREE.Scene();
  scene.environment = environment;
  scene.environmentRotation.set(Math.PI / 2, 0, 0);  // the environment has y up
  scene.environmentIntensity = 0.68;
  for (let i = 0; i < LIGHTS; ++i) {
    const light = new THREE.DirectionalLight('#fffaf2', 2.1 / LIGHTS);
    const angle = i * Math.PI * (3 - Math.sqrt(5));  // the golden angle
    const radius = SPREAD * Math.sqrt((i + 0.5) / LIGHTS);
    light.target.position.set(...target);
    light.position.set(...lightFrom).add(light.target.position)
      .add(new THREE.Vector3(Math.cos(angle), Math.sin(angle), 0).multiplyScalar(radius));
    light.castShadow = true;
    light.shadow.mapSize.set(2048, 2048);
    Object.assign(light.shadow.camera,
      { left: -reach, right: reach, top: reach, bottom: -reach, near: 1, far: 600 });
    light.shadow.bias = -0.0008;
    light.shadow.normalBias = 0.1;
    light.shadow.radius = 3;
    scene.add(light, light.target);
  }
  return scene;
}

function add(scene, geometry, material) {
  const mesh = new THREE.Mesh(geometry, material);
  mesh.castShadow = true;
  mesh.receiveShadow = true;
  scene.add(mesh);
  return mesh;
}

/** An orthographic camera that looks at `target` along `direction` and shows `height` mm. */
function makeCamera(target, direction, height, aspect) {
  const camera = new THREE.OrthographicCamera(
    -height * aspect / 2, height * aspect / 2, height / 2, -height / 2, 1, 1000);
  camera.up.set(0, 0, 1);
  camera.position.copy(target).addScaledVector(direction.normalize(), -300);
  camera.lookAt(target);
  camera.updateMatrixWorld();
  return camera;
}

function label(html, x, y, className = '', color = '') {
  const element = document.createElement('div');
  element.className = `label ${className}`;
  element.innerHTML = html;
  Object.assign(element.style, { left: `${x}px`, top: `${y}px`, color });
  document.body.append(element);
}

function arrow([x1, y1], [x2, y2]) {
  const line = document.createElementNS('http://www.w3.org/2000/svg', 'line');
  Object.entries({ x1, y1, x2, y2, stroke: '#2b3440', 'stroke-width': 1.6,
    'marker-end': 'url(#tip)' }).forEach(([name, value]) => line.setAttribute(name, value));
  document.querySelector('svg').append(line);
}

/** The pixel position of a point for a camera whose picture begins at `left`. */
function pixelsOf(point, camera, left, width) {
  const p = point.clone().project(camera);
  return [left + (p.x + 1) / 2 * width, (1 - p.y) / 2 * HEIGHT];
}

function render(scene, camera, left, width) {
  renderer.setViewport(left, 0, width, HEIGHT);
  renderer.setScissor(left, 0, width, HEIGHT);
  renderer.setScissorTest(true);
  renderer.render(scene, camera);
}

/** Half a block with half of the bolt's hole in its front. */
function blockGeometry() {
  const half = 10.4;
  const radius = 5;
  const shape = new THREE.Shape();
  shape.moveTo(-half, 0);
  shape.lineTo(-radius, 0);
  shape.absarc(0, 0, radius, Math.PI, 0, true);
  shape.lineTo(half, 0);
  shape.lineTo(half, 13);
  shape.lineTo(-half, 13);
  const geometry = new THREE.ExtrudeGeometry(shape,
    { depth: BLOCK_TOP - BLOCK_BOTTOM, bevelEnabled: false, curveSegments: 48 });
  return geometry.translate(0, 0, BLOCK_BOTTOM);
}

function drawMoments(bolts) {
  const scene = makeScene([0, 0, -20], [-70, -110, 210], 85);
  const steel = new THREE.MeshStandardMaterial(
    { color: '#d3d8df', metalness: 0.8, roughness: 0.36, flatShading: true });
  const wood = ['#d3cbbd', '#c9bfae'].map((color) =>
    new THREE.MeshStandardMaterial({ color, roughness: 0.9 }));
  const block = blockGeometry();
  const at = (i) => (i - 2) * SPACING;
  bolts.forEach((bolt, i) => {
    add(scene, bolt, steel).position.x = at(i);
    add(scene, block, wood).position.x = at(i);
  });

  const camera = makeCamera(new THREE.Vector3(0, 0, -30.5), new THREE.Vector3(0, 1, -0.36), 84,
    SPLIT / HEIGHT);
  render(scene, camera, 0, SPLIT);
  TIMES.forEach((time, i) => {
    const [x] = pixelsOf(new THREE.Vector3(at(i), 0, BLOCK_BOTTOM), camera, 0, SPLIT);
    label(`<i>t</i> = ${time} s`, x, 606, '', ACCENTS[i]);
  });
  label('slices at five times', SPLIT / 2, 652, 'small');
}

/** Segments where a mesh crosses the plane x = 0, as (t, y, z). */
function outline(geometry, time) {
  const position = geometry.attributes.position;
  const index = geometry.index;
  const points = [];
  const corner = new THREE.Vector3();
  for (let i = 0; i < index.count; i += 3) {
    const corners = [0, 1, 2].map((j) => corner.fromBufferAttribute(position, index.getX(i + j))
      .clone());
    for (let j = 0; j < 3; ++j) {
      const [a, b] = [corners[j], corners[(j + 1) % 3]];
      if (a.x > 0 === b.x > 0) continue;
      const p = a.clone().lerp(b, a.x / (a.x - b.x));
      points.push(time * TIME_SCALE, p.y, p.z);
    }
  }
  return points;
}

function drawSculpture(sculpture, bolts) {
  const scene = makeScene([TIME_SCALE * 2.5, 0, -20], [-50, -150, 190], 60);
  // Maps the file's (y, z, t) to (t, y, z): a rotation, so the triangles keep facing outward.
  const place = new THREE.Matrix4().set(
    0, 0, TIME_SCALE, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 1);
  sculpture.applyMatrix4(place);
  add(scene, sculpture, new THREE.MeshStandardMaterial(
    { color: '#bcc6d4', metalness: 0.25, roughness: 0.5, flatShading: true }));
  bolts.forEach((bolt, i) => {
    const lines = new LineSegments2(
      new LineSegmentsGeometry().setPositions(outline(bolt, TIMES[i])),
      new LineMaterial({ color: ACCENTS[i], linewidth: 3, polygonOffset: true,
        polygonOffsetFactor: -4, polygonOffsetUnits: -4 }));
    scene.add(lines);
  });

  const width = WIDTH - SPLIT;
  const camera = makeCamera(new THREE.Vector3(TIME_SCALE * 2.5, 0, -24),
    new THREE.Vector3(0.62, 1, -0.5), 86, width / HEIGHT);
  render(scene, camera, SPLIT, width);
  // The axes are drawn in a free corner; the camera is orthographic, so only directions matter.
  const corner = [SPLIT + 92, 612];
  const [x0, y0] = pixelsOf(new THREE.Vector3(), camera, SPLIT, width);
  const axes = { t: [16, 0, 0], y: [0, 14, 0], z: [0, 0, 11] };
  for (const [name, along] of Object.entries(axes)) {
    const [x, y] = pixelsOf(new THREE.Vector3(...along), camera, SPLIT, width);
    const at = (part) => [corner[0] + part * (x - x0), corner[1] + part * (y - y0)];
    arrow(corner, at(1));
    label(name, ...at(1 + 16 / Math.hypot(x - x0, y - y0)), 'axis');
  }
  label('slice at <i>x</i> = 0: all five turns, time along', SPLIT + width / 2, 652, 'small');
}

try {
  const bolts = await Promise.all(TIMES.map((time) => geometryOf(`bolt-at-${time}.glb`)));
  const sculpture = await geometryOf('bolt-x0.glb');
  renderer.clear();
  drawMoments(bolts);
  drawSculpture(sculpture, bolts);
  window.outcome = 'done';
} catch (error) {
  window.outcome = `${error.stack ?? error}`;
}
