// The picture: one camera for all panes, which stand side by side.
import * as THREE from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';

import { forgetNothing } from './gpu.js';

/** Half the angle that the camera sees across the shorter side of a pane. */
const halfAngle = 17.5 * Math.PI / 180;

export class View {
  /**
   * @param {HTMLCanvasElement} canvas
   * @param {HTMLCanvasElement} gizmo
   * @param {() => void} onMove
   */
  constructor(canvas, gizmo, onMove) {
    this.canvas = canvas;
    this.gizmo = gizmo;
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true, powerPreference: 'high-performance' });
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.renderer.autoClear = false;
    this.camera = new THREE.PerspectiveCamera();
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.zoomToCursor = true;
    this.controls.addEventListener('change', onMove);
    this.radius = 1;
    this.labels = ['x', 'y', 'z'];
    this.turn = new THREE.Quaternion();
  }

  /** The position of the camera, and what it looks at. */
  get place() {
    return [...this.camera.position.toArray(), ...this.controls.target.toArray()];
  }

  set place(place) {
    this.camera.position.set(...place.slice(0, 3));
    this.controls.target.set(...place.slice(3));
    this.controls.update();
  }

  /** Moves the camera so that it looks at a point of the section, from the same side and as far away. */
  lookAt(point) {
    const move = new THREE.Vector3(...point).applyQuaternion(this.turn).sub(this.controls.target);
    this.camera.position.add(move);
    this.controls.target.add(move);
    this.controls.update();
  }

  /** Moves the camera so that a ball around the middle is seen. */
  fit(radius) {
    this.radius = radius > 0 ? radius : 1;
    const distance = this.radius / Math.sin(halfAngle);
    this.camera.position.set(0.55, 0.42, 0.8).normalize().multiplyScalar(distance);
    this.controls.target.set(0, 0, 0);
    this.controls.update();
  }

  /** The camera sees the same across the shorter side of a pane, so that what was fitted stays in the picture. */
  setAspect(aspect) {
    const { camera } = this;
    camera.aspect = aspect;
    camera.fov = 2 * Math.atan(Math.tan(halfAngle) / Math.min(1, aspect)) * 180 / Math.PI;
    camera.updateProjectionMatrix();
  }

  /** Which axis of the sections points up: 'y', or 'z' for the third. */
  setUp(up) {
    this.turn.setFromAxisAngle(new THREE.Vector3(1, 0, 0), up === 'z' ? -Math.PI / 2 : 0);
  }

  /** Draws the panes, each in its part of the canvas. */
  render(panes) {
    const { renderer, camera, canvas } = this;
    const width = canvas.clientWidth;
    const height = canvas.clientHeight;
    const size = renderer.getSize(new THREE.Vector2());
    if (size.x !== width || size.y !== height) renderer.setSize(width, height, false);
    const distance = camera.position.distanceTo(this.controls.target) + this.controls.target.length();
    camera.near = Math.max(this.radius * 1e-4, (distance - this.radius) * 0.2);
    camera.far = distance + 4 * this.radius;
    this.setAspect(Math.max(1, width / Math.max(1, panes.length)) / Math.max(1, height));
    renderer.setScissorTest(false);
    renderer.setClearColor(new THREE.Color(getComputedStyle(canvas).backgroundColor), 1);
    renderer.clear();
    renderer.setScissorTest(true);
    panes.forEach((pane, i) => {
      const left = Math.round(i * width / panes.length);
      const right = Math.round((i + 1) * width / panes.length);
      renderer.setViewport(left, 0, right - left, height);
      renderer.setScissor(left, 0, right - left, height);
      pane.group.quaternion.copy(this.turn);
      renderer.render(pane.scene, camera);
    });
    this.drawGizmo();
  }

  drawGizmo() {
    const { gizmo } = this;
    const ratio = this.renderer.getPixelRatio();
    const size = gizmo.clientWidth;
    gizmo.width = gizmo.height = size * ratio;
    const context = gizmo.getContext('2d');
    context.scale(ratio, ratio);
    context.clearRect(0, 0, size, size);
    context.font = '13px system-ui, sans-serif';
    context.textAlign = 'center';
    context.textBaseline = 'middle';
    const turn = this.camera.quaternion.clone().invert().multiply(this.turn);
    const axes = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
      .map((axis, i) => ({ i, at: new THREE.Vector3(...axis).applyQuaternion(turn) }))
      .sort((a, b) => a.at.z - b.at.z);
    for (const { i, at } of axes) {
      const color = ['#d3452f', '#3f9b3a', '#3b7dd8'][i];
      const [x, y] = [size / 2 + at.x * size * 0.34, size / 2 - at.y * size * 0.34];
      context.strokeStyle = context.fillStyle = color;
      context.lineWidth = 2;
      context.beginPath();
      context.moveTo(size / 2, size / 2);
      context.lineTo(x, y);
      context.stroke();
      context.fillText(this.labels[i], size / 2 + at.x * size * 0.43, size / 2 - at.y * size * 0.43);
    }
  }

  /** Calls when the GPU has drawn what it is to draw by now. */
  whenDrawn(call) {
    const gl = this.renderer.getContext();
    const fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    gl.flush();
    const look = () => {
      if (!gl.isContextLost() && gl.getSyncParameter(fence, gl.SYNC_STATUS) !== gl.SIGNALED) {
        requestAnimationFrame(look);
        return;
      }
      gl.deleteSync(fence);
      call();
    };
    requestAnimationFrame(look);
  }

  /** Gives the memory of the GPU back. */
  dispose() {
    this.controls.dispose();
    forgetNothing();
    this.renderer.dispose();
    this.renderer.forceContextLoss();
  }

  /** Waits until the GPU has drawn. */
  finish() {
    const gl = this.renderer.getContext();
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
  }
}
