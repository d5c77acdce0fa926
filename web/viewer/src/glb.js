/**
 * A binary glTF of triangle meshes, in float32.
 * @param {{name: string, points: Float64Array, triangles: Uint32Array, color: number[]}[]} meshes
 *   points along three axes, colours linear
 * @param {{isZUp: boolean}} options whether the third axis points up, which glTF's does not
 * @returns {Uint8Array|null} null if there are no triangles
 */
export function glbOf(meshes, { isZUp }) {
  const parts = [];
  let length = 0;
  const views = [];
  const add = (array, target) => {
    views.push({ buffer: 0, byteOffset: length, byteLength: array.byteLength, target });
    parts.push(new Uint8Array(array.buffer, array.byteOffset, array.byteLength));
    length += array.byteLength;
    return views.length - 1;
  };
  const json = {
    asset: { version: '2.0', generator: 't4d viewer' },
    scene: 0,
    scenes: [{ nodes: [0] }],
    // z up turned to y up.
    nodes: [{ children: [], ...(isZUp ? { rotation: [-Math.SQRT1_2, 0, 0, Math.SQRT1_2] } : {}) }],
    meshes: [], materials: [], accessors: [], bufferViews: views, buffers: [],
  };
  for (const { name, points, triangles, color } of meshes) {
    if (triangles.length === 0) continue;
    const positions = Float32Array.from(points);
    const min = [Infinity, Infinity, Infinity];
    const max = [-Infinity, -Infinity, -Infinity];
    positions.forEach((value, i) => {
      min[i % 3] = Math.min(min[i % 3], value);
      max[i % 3] = Math.max(max[i % 3], value);
    });
    const position = json.accessors.push({
      bufferView: add(positions, 34962), componentType: 5126, count: positions.length / 3, type: 'VEC3', min, max,
    }) - 1;
    const indices = json.accessors.push({
      bufferView: add(triangles, 34963), componentType: 5125, count: triangles.length, type: 'SCALAR',
    }) - 1;
    const material = json.materials.push({
      pbrMetallicRoughness: { baseColorFactor: [...color, 1], metallicFactor: 0, roughnessFactor: 0.7 },
    }) - 1;
    const mesh = json.meshes.push({ name, primitives: [{ attributes: { POSITION: position }, indices, material }] }) - 1;
    json.nodes[0].children.push(json.nodes.push({ name, mesh }) - 1);
  }
  if (json.meshes.length === 0) return null;
  json.buffers.push({ byteLength: length });
  const text = new TextEncoder().encode(JSON.stringify(json));
  const padded = Math.ceil(text.length / 4) * 4;
  const bytes = new Uint8Array(12 + 8 + padded + 8 + length);
  const view = new DataView(bytes.buffer);
  [0x46546c67, 2, bytes.length, padded, 0x4e4f534a].forEach((word, i) => view.setUint32(4 * i, word, true));
  bytes.fill(0x20, 20, 20 + padded);
  bytes.set(text, 20);
  view.setUint32(20 + padded, length, true);
  view.setUint32(24 + padded, 0x004e4942, true);
  let at = 28 + padded;
  for (const part of parts) {
    bytes.set(part, at);
    at += part.length;
  }
  return bytes;
}
