// The components of a section at a time, each with its box.

/** Disjoint sets of numbers below `size`. */
class Sets {
  constructor(size) {
    this.parent = Uint32Array.from({ length: size }, (_, i) => i);
  }

  root(item) {
    const { parent } = this;
    while (parent[item] !== item) item = parent[item] = parent[parent[item]];
    return item;
  }

  unite(a, b) {
    this.parent[this.root(a)] = this.root(b);
  }
}

/**
 * Triangles are connected across edges, and not where surfaces touch at a vertex.
 * @param {Float64Array} vertices x, y, z, t of each
 * @param {[number, number][][]} triangles of three corners each: the edges of cells that they are on
 * @param {Float64Array} heights of the vertices over the hyperplane
 * @returns {{ofTriangle: Uint32Array, components: {min: number[], max: number[], volume: number}[]}} volumes are negative
 *   where a surface faces inward
 */
export function componentsOf(vertices, triangles, heights) {
  const count = vertices.length / 4;
  const points = new Map();
  const places = [];
  const pointOf = ([a, b]) => {
    const key = heights[a] === 0 ? a * count + a : heights[b] === 0 ? b * count + b : Math.min(a, b) * count + Math.max(a, b);
    let point = points.get(key);
    if (point === undefined) {
      point = places.length / 3;
      points.set(key, point);
      const s = heights[a] === 0 ? 0 : heights[b] === 0 ? 1 : heights[a] / (heights[a] - heights[b]);
      for (let i = 0; i < 3; ++i) places.push((1 - s) * vertices[4 * a + i] + s * vertices[4 * b + i]);
    }
    return point;
  };
  const corners = triangles.map((edges) => edges.map(pointOf));
  const sets = new Sets(triangles.length);
  const sides = new Map();
  corners.forEach((points3, triangle) => {
    for (let i = 0; i < 3; ++i) {
      const [a, b] = [points3[i], points3[(i + 1) % 3]];
      const key = Math.min(a, b) * points.size + Math.max(a, b);
      if (sides.has(key)) sets.unite(sides.get(key), triangle);
      else sides.set(key, triangle);
    }
  });
  const components = [];
  const numbers = new Map();
  const ofTriangle = Uint32Array.from(corners, (points3, triangle) => {
    const root = sets.root(triangle);
    if (!numbers.has(root)) {
      numbers.set(root, components.length);
      const from = places.slice(3 * points3[0], 3 * points3[0] + 3);
      components.push({ min: [...from], max: [...from], volume: 0, from });
    }
    const component = components[numbers.get(root)];
    for (const point of points3) {
      for (let i = 0; i < 3; ++i) {
        component.min[i] = Math.min(component.min[i], places[3 * point + i]);
        component.max[i] = Math.max(component.max[i], places[3 * point + i]);
      }
    }
    const [[ax, ay, az], [bx, by, bz], [cx, cy, cz]] =
      points3.map((point) => component.from.map((value, i) => places[3 * point + i] - value));
    component.volume += (ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)) / 6;
    return numbers.get(root);
  });
  return { ofTriangle, components };
}
