// The distance of sections from each other, for colours.
import { BufferAttribute, BufferGeometry, Vector3 } from 'three';
import { MeshBVH } from 'three-mesh-bvh';

/** All triangles of some sections in one tree, in float32 from an origin; null without any. */
function treeOf(sections, origin) {
  const corners = sections.reduce((sum, { triangles }) => sum + triangles.length, 0);
  if (corners === 0) return null;
  const positions = new Float32Array(3 * corners);
  let length = 0;
  for (const { points, triangles } of sections) {
    for (const point of triangles) {
      for (let axis = 0; axis < 3; ++axis) positions[length++] = points[3 * point + axis] - origin[axis];
    }
  }
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(positions, 3));
  return new MeshBVH(geometry);
}

/**
 * How far each point of some sections is from the surfaces of others.
 * @param {import('t4d-reader').Section[]} sections
 * @param {import('t4d-reader').Section[]} others
 * @returns {Float32Array[]} for each of the sections, a distance for each of its points; NaN without others
 */
export function distancesFrom(sections, others) {
  const origin = others.find(({ points }) => points.length > 0)?.points.slice(0, 3) ?? [0, 0, 0];
  const tree = treeOf(others, origin);
  const from = new Vector3();
  const found = {};
  return sections.map(({ points }) => Float32Array.from({ length: points.length / 3 }, (_, i) => {
    if (!tree) return NaN;
    from.set(...[0, 1, 2].map((axis) => points[3 * i + axis] - origin[axis]));
    return tree.closestPointToPoint(from, found).distance;
  }));
}
