// Slabs as textures, and what draws their sections.
import * as THREE from 'three';

import { cutTable, eachRunThatMayBeCut, heightsOf } from 't4d-reader';

import { rangeOfSpeeds } from './cell_speed.js';
import { blockCells, rowTexels } from './common.js';
import { componentsOf } from './components.js';
import { facesVertex, fragment, meshVertex, sectionVertex } from './shaders.js';
import { trackColor } from './tracks.js';

const formats = {
  rgbaFloat: [THREE.RGBAFormat, THREE.FloatType, 'RGBA32F', 4, Float32Array],
  float: [THREE.RedFormat, THREE.FloatType, 'R32F', 1, Float32Array],
  rgbaUint: [THREE.RGBAIntegerFormat, THREE.UnsignedIntType, 'RGBA32UI', 4, Uint32Array],
  uint: [THREE.RedIntegerFormat, THREE.UnsignedIntType, 'R32UI', 1, Uint32Array],
};

/** The size of a texture of as many texels, in whole rows but where one is enough. */
const sizeOf = (texels) =>
  (texels <= rowTexels ? [Math.max(1, texels), 1] : [rowTexels, Math.ceil(texels / rowTexels)]);

/** A texture of as many texels; fill(array) writes them, the rest is 0. */
function textureOf(kind, texels, fill) {
  const [format, type, internal, components, Type] = formats[kind];
  const [width, height] = sizeOf(texels);
  const data = new Type(width * height * components);
  fill(data);
  const texture = new THREE.DataTexture(data, width, height, format, type);
  texture.internalFormat = internal;
  texture.unpackAlignment = 4;
  texture.needsUpdate = true;
  return texture;
}

const nothing = {
  values: textureOf('rgbaFloat', 1, () => {}),
  ids: textureOf('uint', 1, () => {}),
};

/** Takes from all renderers what is always there, so that it keeps none of them in memory. */
export function forgetNothing() {
  nothing.values.dispose();
  nothing.ids.dispose();
}

/** So many cells fit a texture, and vertices; a triangle has 27 bits for its cell. */
export const mostTexels = (renderer) => Math.min(2 ** 27, rowTexels * renderer.capabilities.maxTextureSize);

/**
 * A slab on the GPU. Textures of cells are shared by the slabs of one connectivity: `cells` counts its users.
 */
export class GpuSlab {
  /**
   * @param slab of the worker
   * @param {{texture: THREE.DataTexture, users: number}} cells of makeCells()
   * @param {number[]} center x, y, z, t: positions are float32 from here
   */
  constructor(slab, cells, center) {
    Object.assign(this, {
      vertices: slab.vertices, begin: slab.begin, end: slab.end, min: slab.min, max: slab.max, numCells: slab.numCells, bounds: slab.bounds,
      attributes: slab.attributes, cells, connectivity: slab.connectivity,
    });
    ++cells.users;
    this.positions = textureOf('rgbaFloat', slab.numVertices, (data) => {
      for (let i = 0; i < slab.vertices.length; ++i) data[i] = slab.vertices[i] - center[i & 3];
    });
    this.colorTextures = new Map();
    /** The values of attributes that were asked for, by name. */
    this.asked = new Map();
    this.bytes = slab.vertices.byteLength + slab.bounds.byteLength + this.positions.image.data.byteLength;
  }

  /** The values of an attribute have come. */
  setAttribute(name, values) {
    const found = this.attributes.find((each) => each.name === name);
    const { components, type, domain } = found;
    found.values = values;
    this.bytes += 2 * values.byteLength;
    if (values instanceof Uint32Array && components === 1 && domain === 'cell') {
      const texture = textureOf('uint', values.length, (data) => data.set(values));
      this.colorTextures.set(name, { ...found, texture, isIds: true });
      return;
    }
    // Colours in whole numbers: sRGB of 8 bits, linear of 16.
    const isColor = components >= 3;
    const scale = isColor && type === 1 ? 1 / 255 : isColor && type === 3 ? 1 / 65535 : 1;
    const texture = textureOf('rgbaFloat', values.length / components, (data) => {
      for (let row = 0; row < values.length / components; ++row) {
        for (let k = 0; k < components; ++k) {
          const value = values[row * components + k] * scale;
          data[4 * row + k] = isColor && type === 1 && k < 3 ? linearOf(value) : value;
        }
      }
    });
    this.colorTextures.set(name, { ...found, texture, isIds: false });
  }

  /** The speeds of nearly all of its cells. */
  get speeds() {
    this.rangeOfSpeeds ??= [rangeOfSpeeds(this.vertices, this.cells.texture.image.data.subarray(0, 4 * this.numCells))];
    return this.rangeOfSpeeds[0];
  }

  /** Takes it from all renderers, of which those that still draw it upload it again. */
  dispose() {
    this.positions.dispose();
    this.cells.texture.dispose();
    for (const made of this.colorTextures.values()) made.texture.dispose();
  }
}

const linearOf = (value) => (value <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4);

/** The cells of a connectivity on the GPU, for GpuSlab. */
export const makeCells = ({ cells, prisms }) => ({
  texture: textureOf('rgbaUint', cells.length / 4, (data) => data.set(cells)), prisms, users: 0,
  bytes: cells.byteLength + (prisms?.byteLength ?? 0),
});

const blackEdges = new THREE.Color(0.02, 0.02, 0.03);

function materialOf(vertexShader) {
  return new THREE.RawShaderMaterial({
    glslVersion: THREE.GLSL3,
    vertexShader,
    fragmentShader: fragment,
    side: THREE.DoubleSide,
    defines: {},
    uniforms: {
      cells: { value: null }, positions: { value: null }, heights: { value: null }, triangles: { value: null },
      isReversed: { value: false },
      axes: { value: [new THREE.Vector4(), new THREE.Vector4(), new THREE.Vector4()] },
      colorMode: { value: 0 }, bodyColor: { value: new THREE.Color() }, colorRange: { value: new THREE.Vector2(0, 1) },
      values: { value: nothing.values }, ids: { value: nothing.ids },
      opacity: { value: 1 }, wireframe: { value: false }, edgeColor: { value: blackEdges },
    },
  });
}

/** What has no vertices of its own: the shaders make them from their number. */
class NumberedMesh extends THREE.Mesh {
  constructor(slab, vertexShader) {
    super(new THREE.BufferGeometry(), materialOf(vertexShader));
    this.slab = slab;
    this.frustumCulled = false;
    const { uniforms } = this.material;
    uniforms.cells.value = slab.cells.texture;
    uniforms.positions.value = slab.positions;
  }

  /** Axes as rows of x, y, z, t. */
  setAxes(axes) {
    axes.forEach((axis, i) => this.material.uniforms.axes.value[i].set(...axis));
  }

  /**
   * @param {{mode: 'body'|'attribute'|'time'|'age'|'speed'|'track', name?: string, color: THREE.Color, range: number[],
   *   opacity: number, wireframe: boolean}} look
   */
  setLook(look) {
    const { uniforms } = this.material;
    uniforms.bodyColor.value.copy(look.color);
    uniforms.colorRange.value.set(...look.range);
    uniforms.wireframe.value = look.wireframe;
    uniforms.opacity.value = look.opacity;
    this.material.transparent = look.opacity < 1;
    this.material.depthWrite = look.opacity === 1;
    this.material.blending = look.opacity < 1 ? THREE.CustomBlending : THREE.NoBlending;
    this.material.blendSrc = THREE.OneFactor;
    this.material.blendDst = THREE.OneMinusSrcAlphaFactor;
    const attribute = look.mode === 'attribute' ? this.slab.colorTextures.get(look.name) : undefined;
    let mode = ['time', 'age'].includes(look.mode) ? 6 : 0;
    if (attribute?.isIds) {
      mode = 1;
      uniforms.ids.value = attribute.texture;
    } else if (attribute) {
      const isColor = attribute.components >= 3;
      mode = attribute.domain === 'vertex' ? (isColor ? 4 : 2) : (isColor ? 5 : 3);
      uniforms.values.value = attribute.texture;
    }
    if (look.mode === 'track' && this.trackColors) {
      mode = 7;
      uniforms.values.value = this.trackColors;
    }
    uniforms.colorMode.value = mode;
    const isSpeed = look.mode === 'speed';
    if (isSpeed === Object.hasOwn(this.material.defines, 'SPEED')) return;
    this.material.defines = isSpeed ? { SPEED: 1 } : {};
    this.material.needsUpdate = true;
  }

  dispose() {
    this.material.uniforms.heights.value?.dispose();
    this.material.uniforms.triangles.value?.dispose();
    this.trackColors?.dispose();
    this.material.dispose();
    this.geometry.dispose();
  }
}

const cornersOfMask = Uint8Array.from(cutTable, (edges) => edges.length);

/**
 * Whether a triangle of a polygon keeps its corners (X4), where vertices of its cell are on the hyperplane.
 * @param {number[]} heights of the corners of the cell
 */
function isWhole(mask, second, heights) {
  const sources = [0, 1 + second, 2 + second].map((corner) => {
    const [a, b] = cutTable[mask][corner];
    return heights[a] === 0 ? a : heights[b] === 0 ? b : 4 + corner;
  });
  return sources[0] !== sources[1] && sources[1] !== sources[2] && sources[2] !== sources[0];
}

/** The section of one slab. */
export class SectionMesh extends NumberedMesh {
  constructor(slab) {
    super(slab, sectionVertex);
    const { uniforms } = this.material;
    uniforms.heights.value = textureOf('float', slab.vertices.length / 4, () => {});
    uniforms.triangles.value = textureOf('uint', 1024, () => {});
  }

  /**
   * @param plane hyperplane() of the reader
   * @param {number[][]} axes that the section is shown along
   * @param {boolean} isReversed whether det[axes, normal] is negative
   * @param {boolean} atLast whether vertices on the hyperplane are above (X1)
   */
  cut(plane, axes, isReversed, atLast) {
    const { uniforms } = this.material;
    uniforms.isReversed.value = isReversed;
    this.setAxes(axes);
    const key = JSON.stringify([plane.normal, plane.offset, atLast]);
    if (key === this.cutKey) return;
    this.cutKey = key;
    this.plane = plane;
    const heights = heightsOf(this.slab.vertices, plane);
    this.numTriangles = this.classify(plane, heights, atLast);
    this.geometry.setDrawRange(0, 3 * this.numTriangles);
    this.visible = this.numTriangles > 0;
    if (!this.visible) return;
    roundKeepingSigns(heights, uniforms.heights.value.image.data);
    uniforms.heights.value.needsUpdate = true;
    uniforms.triangles.value.needsUpdate = true;
  }

  /**
   * Colours the triangles of a section at a time by their tracks.
   * @param {import('./tracks.js').Tracks} tracks
   * @param {string} body
   */
  setTracks(tracks, body) {
    if (this.tracksKey === this.cutKey) return;
    this.tracksKey = this.cutKey;
    const list = this.material.uniforms.triangles.value.image.data.subarray(0, this.numTriangles);
    const cells = this.slab.cells.texture.image.data;
    const triangles = Array.from(list, (entry) => {
      const edges = cutTable[(entry >> 1) & 15];
      const cell = 4 * (entry >>> 5);
      return [0, 1 + (entry & 1), 2 + (entry & 1)].map((corner) => edges[corner].map((i) => cells[cell + i]));
    });
    const { ofTriangle, components } = componentsOf(this.slab.vertices, triangles, heightsOf(this.slab.vertices, this.plane));
    // The table has them as det[axes, normal] > 0.
    if (this.material.uniforms.isReversed.value) for (const each of components) each.volume *= -1;
    const colors = tracks.idsOf(body, components, this.plane.offset).map(trackColor);
    this.trackColors?.dispose();
    this.trackColors = textureOf('rgbaFloat', ofTriangle.length, (data) =>
      ofTriangle.forEach((component, i) => data.set(colors[component], 4 * i)));
  }

  /** Lists the triangles that are cut, and returns their number. */
  classify(plane, heights, atLast) {
    const cells = this.slab.cells.texture.image.data;
    const above = new Uint8Array(heights.length);
    for (let i = 0; i < heights.length; ++i) above[i] = heights[i] > 0 || (atLast && heights[i] === 0) ? 1 : 0;
    let list = this.material.uniforms.triangles.value.image.data;
    let count = 0;
    this.eachRun(plane, heights, (begin, end) => {
      const most = count + (end - begin) / 2;
      if (most > list.length) list = this.grow(2 * most, count);
      for (let i = begin; i < end; i += 4) {
        const a = cells[i];
        const b = cells[i + 1];
        const c = cells[i + 2];
        const d = cells[i + 3];
        const mask = above[a] | (above[b] << 1) | (above[c] << 2) | (above[d] << 3);
        if (mask === 0 || mask === 15) continue;
        const entry = (i << 3) | (mask << 1);
        const isQuadrilateral = cornersOfMask[mask] === 4;
        if (heights[a] !== 0 && heights[b] !== 0 && heights[c] !== 0 && heights[d] !== 0) {
          list[count++] = entry;
          if (isQuadrilateral) list[count++] = entry | 1;
        } else {
          const ofCell = [heights[a], heights[b], heights[c], heights[d]];
          if (isWhole(mask, 0, ofCell)) list[count++] = entry;
          if (isQuadrilateral && isWhole(mask, 1, ofCell)) list[count++] = entry | 1;
        }
      }
    });
    return count;
  }

  /** The cells that may be cut, as use(begin, end) of the numbers of their corners. */
  eachRun(plane, heights, use) {
    const { bounds, numCells, min, max, cells: { prisms, texture } } = this.slab;
    const cells = texture.image.data.subarray(0, 4 * numCells);
    if (prisms) {
      eachRunThatMayBeCut({ cells, prisms, min, max }, heights, plane, use);
      return;
    }
    for (let i = 0, k = 0; i < cells.length; i += 4 * blockCells, k += 8) {
      if (!plane.mayCut(bounds.subarray(k, k + 4), bounds.subarray(k + 4, k + 8))) continue;
      use(i, Math.min(cells.length, i + 4 * blockCells));
    }
  }

  /** Makes room for as many triangles. */
  grow(size, count) {
    const { triangles } = this.material.uniforms;
    const before = triangles.value;
    triangles.value = textureOf('uint', size, (data) => data.set(before.image.data.subarray(0, count)));
    before.dispose();
    return triangles.value.image.data;
  }
}

const smallest = 2 ** -126; // what is smaller a GPU may take for 0

function roundKeepingSigns(heights, rounded) {
  for (let i = 0; i < heights.length; ++i) {
    const height = heights[i];
    rounded[i] = Math.abs(height) >= smallest || height === 0 ? height : Math.sign(height) * smallest;
  }
}

/** All cells of a slab, without one of the axes. */
export class FacesMesh extends NumberedMesh {
  constructor(slab) {
    super(slab, facesVertex);
    this.geometry.setDrawRange(0, 12 * slab.numCells);
  }
}

/** The times of points, relative to another. */
function timesOf(points4, center) {
  const times = new Float32Array(points4.length / 4);
  for (let i = 0; i < times.length; ++i) times[i] = points4[4 * i + 3] - center;
  return times;
}

/** The triangles of a section of the worker, along some axes. */
function geometryOf({ points4, triangles, distances }, axes, [cx, cy, cz, ct]) {
  const positions = new Float32Array(points4.length / 4 * 3);
  axes.forEach(([x, y, z, t], axis) => {
    for (let i = 0, k = axis; i < points4.length; i += 4, k += 3) {
      positions[k] = x * (points4[i] - cx) + y * (points4[i + 1] - cy) + z * (points4[i + 2] - cz)
        + t * (points4[i + 3] - ct);
    }
  });
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.BufferAttribute(positions, 3));
  geometry.setIndex(new THREE.BufferAttribute(triangles, 1));
  geometry.setAttribute('value', new THREE.BufferAttribute(distances ?? timesOf(points4, ct), 1));
  return geometry;
}

/** A section that the worker cut: too large to be cut here, or with distances. */
export class CutMesh extends THREE.Mesh {
  /**
   * @param section of the worker, with its `sketch` if it has one
   * @param {number[][]} axes that it is shown along
   * @param {number[]} center
   */
  constructor(section, axes, center) {
    const whole = geometryOf(section, axes, center);
    super(whole, materialOf(meshVertex));
    this.whole = whole;
    this.sketch = section.sketch ? geometryOf(section.sketch, axes, center) : whole;
    this.frustumCulled = false;
    this.modesOfValues = section.distances ? ['distance'] : ['time', 'age'];
  }

  /** Draws the sketch, if there is one, or the section. */
  setRough(isRough) {
    this.geometry = isRough ? this.sketch : this.whole;
  }

  /** Colours it by the distances that it has; without them by time or age; or by body. */
  setLook({ mode, color, range }) {
    const { uniforms } = this.material;
    uniforms.bodyColor.value.copy(color);
    uniforms.colorRange.value.set(...range);
    uniforms.colorMode.value = this.modesOfValues.includes(mode) ? 2 : 0;
  }

  dispose() {
    this.whole.dispose();
    this.sketch.dispose();
    this.material.dispose();
  }
}

/** The programs by the context of each renderer. */
const feedbackPrograms = new WeakMap();

/** A program of the same shader whose vertices can be read back. */
function makeFeedbackProgram(gl) {
  const program = gl.createProgram();
  for (const [type, source] of [[gl.VERTEX_SHADER, sectionVertex], [gl.FRAGMENT_SHADER, fragment]]) {
    const shader = gl.createShader(type);
    gl.shaderSource(shader, `#version 300 es\n${source}`);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
    gl.attachShader(program, shader);
  }
  gl.transformFeedbackVaryings(program, ['vSection'], gl.INTERLEAVED_ATTRIBS);
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program));
  return program;
}

/**
 * The triangles that the GPU cuts for a section, by transform feedback of the same shader.
 * @param {THREE.WebGLRenderer} renderer
 * @param {SectionMesh} mesh
 * @returns {Float32Array} three coordinates of each corner, along the axes of the section
 */
export function readBack(renderer, mesh) {
  const gl = renderer.getContext();
  const { count } = mesh.geometry.drawRange;
  if (!mesh.visible || count === 0) return new Float32Array(0);
  if (!feedbackPrograms.has(gl)) feedbackPrograms.set(gl, makeFeedbackProgram(gl));
  const program = feedbackPrograms.get(gl);
  gl.useProgram(program);
  const at = (name) => gl.getUniformLocation(program, name);
  const { uniforms } = mesh.material;
  const textures = ['cells', 'positions', 'heights', 'triangles', 'ids', 'values'];
  for (const name of textures) renderer.initTexture(uniforms[name].value);
  textures.forEach((name, unit) => {
    gl.activeTexture(gl.TEXTURE0 + unit);
    gl.bindTexture(gl.TEXTURE_2D, renderer.properties.get(uniforms[name].value).__webglTexture);
    gl.uniform1i(at(name), unit);
  });
  gl.uniform1i(at('isReversed'), uniforms.isReversed.value ? 1 : 0);
  gl.uniform4fv(at('axes'), uniforms.axes.value.flatMap((axis) => axis.toArray()));
  const buffer = gl.createBuffer();
  gl.bindBuffer(gl.TRANSFORM_FEEDBACK_BUFFER, buffer);
  gl.bufferData(gl.TRANSFORM_FEEDBACK_BUFFER, count * 12, gl.STREAM_READ);
  gl.bindVertexArray(null);
  const feedback = gl.createTransformFeedback();
  gl.bindTransformFeedback(gl.TRANSFORM_FEEDBACK, feedback);
  gl.bindBufferBase(gl.TRANSFORM_FEEDBACK_BUFFER, 0, buffer);
  gl.enable(gl.RASTERIZER_DISCARD);
  gl.beginTransformFeedback(gl.TRIANGLES);
  gl.drawArrays(gl.TRIANGLES, 0, count);
  gl.endTransformFeedback();
  gl.disable(gl.RASTERIZER_DISCARD);
  gl.bindTransformFeedback(gl.TRANSFORM_FEEDBACK, null);
  gl.bindBufferBase(gl.TRANSFORM_FEEDBACK_BUFFER, 0, null);
  gl.bindBuffer(gl.TRANSFORM_FEEDBACK_BUFFER, buffer);
  const corners = new Float32Array(count * 3);
  gl.getBufferSubData(gl.TRANSFORM_FEEDBACK_BUFFER, 0, corners);
  gl.bindBuffer(gl.TRANSFORM_FEEDBACK_BUFFER, null);
  gl.deleteTransformFeedback(feedback);
  gl.deleteBuffer(buffer);
  renderer.resetState();
  return corners;
}

/** Counts, volume and area of triangles of readBack(), in their own numbers. */
export function measureCorners(corners) {
  let volume = 0;
  let area = 0;
  for (let i = 0; i < corners.length; i += 9) {
    const [ax, ay, az, bx, by, bz, cx, cy, cz] = corners.subarray(i, i + 9);
    volume += (ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)) / 6;
    const [ux, uy, uz, vx, vy, vz] = [bx - ax, by - ay, bz - az, cx - ax, cy - ay, cz - az];
    area += Math.hypot(uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx) / 2;
  }
  return { numTriangles: corners.length / 9, volume, area };
}
