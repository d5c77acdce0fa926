// A section is cut by a vertex shader: three vertices for each triangle that a hyperplane cuts from a cell. Which cells
// are cut, and in how many triangles, comes from the page, which decides by the layer rule of the specification (X1 to
// X4) in double precision; the heights n.p - offset are rounded only then.
import { cutTable } from 't4d-reader';

import { cellSpeed } from './cell_speed.js';
import { rowTexels } from './common.js';

// Bits 0 to 2: the corners of the polygon; then four bits for each, the two corners of the cell that the edge joins.
const packedTable = cutTable.map((edges) =>
  edges.reduce((bits, [a, b], i) => bits | (a << (3 + 4 * i)) | (b << (5 + 4 * i)), edges.length) >>> 0);

const fetches = `
uniform highp usampler2D cells;
uniform highp sampler2D positions;

ivec2 texel(uint i) { return ivec2(int(i % ${rowTexels}u), int(i / ${rowTexels}u)); }
vec4 position(uint vertex) { return texelFetch(positions, texel(vertex), 0); }
#ifdef SPEED // another program: without a GPU, what is not taken of a branch costs time, too
${cellSpeed}
float speedOf(uvec4 corners) {
  return speedOfCell(position(corners.x), position(corners.y), position(corners.z), position(corners.w));
}
#endif
`;

const colors = `
uniform int colorMode;      // 0 one colour, 1 whole numbers of cells, 2 a number of vertices, 3 of cells,
                            // 4 colours of vertices, 5 of cells, 6 time, 7 colours of triangles; SPEED if defined
uniform vec3 bodyColor;     // linear
uniform vec2 colorRange;
uniform highp sampler2D values;
uniform highp usampler2D ids;

vec3 linearOf(vec3 c) {
  return mix(c / 12.92, pow((c + 0.055) / 1.055, vec3(2.4)), step(0.04045, c));
}

// Five colours of viridis.
vec3 ramp(float s) {
  const vec3 stops[5] = vec3[5](vec3(68, 1, 84), vec3(59, 82, 139), vec3(33, 145, 140), vec3(94, 201, 98),
    vec3(253, 231, 37));
  float place = clamp(s, 0.0, 1.0) * 4.0;
  int i = min(int(place), 3);
  return linearOf(mix(stops[i], stops[i + 1], place - float(i)) / 255.0);
}

// A colour of its own for each number.
vec3 distinct(uint id) {
  if (id == 0xffffffffu) return vec3(0.25);
  uint h = id * 0x9e3779b1u;
  h = (h ^ (h >> 15)) * 0x85ebca6bu;
  h ^= h >> 13;
  vec3 c = vec3(float(h & 255u), float((h >> 8) & 255u), float((h >> 16) & 255u)) / 255.0;
  return linearOf(0.25 + 0.7 * c);
}

vec3 ofNumber(float value) {
  if (isnan(value) || isinf(value)) return vec3(0.22);
  float size = colorRange.y - colorRange.x;
  return ramp(size > 0.0 ? (value - colorRange.x) / size : 0.0);
}
`;

export const sectionVertex = `
precision highp float;
precision highp int;
${fetches}
uniform highp sampler2D heights;
uniform highp usampler2D triangles;  // bit 0: the second of a quadrilateral, 1 to 4: the corners above, 5 on: the cell
uniform bool isReversed;
uniform vec4 axes[3];
uniform mat4 modelViewMatrix;
uniform mat4 projectionMatrix;
${colors}
out vec3 vSection;          // along the axes of the section
out vec3 vView;
out vec3 vEdge;             // barycentric; 1 along edges that are none of the section
out vec3 vColor;

const uint table[16] = uint[16](${packedTable.map((bits) => `${bits}u`).join(', ')});

void main() {
  uint triangle = texelFetch(triangles, texel(uint(gl_VertexID / 3)), 0).r;
  uint cell = triangle >> 5;
  uint edges = table[(triangle >> 1) & 15u];
  int second = int(triangle & 1u);
  int which = gl_VertexID % 3;
  if (isReversed && which > 0) which = 3 - which;
  int corner = which == 0 ? 0 : which + second;
  uint edge = edges >> (3 + 4 * corner);

  uvec4 corners = texelFetch(cells, texel(cell), 0);
  uint a = corners[edge & 3u];
  uint b = corners[(edge >> 2) & 3u];
  float ha = texelFetch(heights, texel(a), 0).r;
  float hb = texelFetch(heights, texel(b), 0).r;
  float s = ha == 0.0 ? 0.0 : hb == 0.0 ? 1.0 : ha / (ha - hb);
  vec4 pa = position(a);
  vec4 pb = position(b);
  vec4 p = s == 1.0 ? pb : pa + s * (pb - pa);
  vSection = vec3(dot(axes[0], p), dot(axes[1], p), dot(axes[2], p));
  vec4 view = modelViewMatrix * vec4(vSection, 1.0);
  vView = view.xyz;
  gl_Position = projectionMatrix * view;

  vEdge = vec3(0);
  vEdge[which] = 1.0;
  // Of a quadrilateral the diagonal is no edge: it lies opposite to the second corner, or to the third.
  if ((edges & 7u) == 4u) vEdge[second == 0 ? 1 : 2] = 1.0;

  vColor = bodyColor;
  if (colorMode == 1) {
    vColor = distinct(texelFetch(ids, texel(cell), 0).r);
  } else if (colorMode == 3) {
    vColor = ofNumber(texelFetch(values, texel(cell), 0).r);
  } else if (colorMode == 5) {
    vColor = texelFetch(values, texel(cell), 0).rgb;
  } else if (colorMode == 2 || colorMode == 4) {
    vec4 va = texelFetch(values, texel(a), 0);
    vec4 vb = texelFetch(values, texel(b), 0);
    vec4 v = s == 1.0 ? vb : va + s * (vb - va);
    vColor = colorMode == 2 ? ofNumber(v.r) : v.rgb;
  } else if (colorMode == 6) {
    vColor = ofNumber(p.w);
  } else if (colorMode == 7) {
    vColor = texelFetch(values, texel(uint(gl_VertexID / 3)), 0).rgb;
  }
#ifdef SPEED
  vColor = ofNumber(speedOf(corners));
#endif
}
`;

/** Triangles that were cut elsewhere. */
export const meshVertex = `
precision highp float;
precision highp int;
in vec3 position;
in float value;
uniform mat4 modelViewMatrix;
uniform mat4 projectionMatrix;
${colors}
out vec3 vView;
out vec3 vEdge;
out vec3 vColor;

void main() {
  vec4 view = modelViewMatrix * vec4(position, 1.0);
  vView = view.xyz;
  gl_Position = projectionMatrix * view;
  vEdge = vec3(1);
  vColor = colorMode == 2 ? ofNumber(value) : bodyColor;
}
`;

/** The faces of all cells, projected to three of the four axes: the solid in space-time. */
export const facesVertex = `
precision highp float;
precision highp int;
${fetches}
uniform vec4 axes[3];
uniform mat4 modelViewMatrix;
uniform mat4 projectionMatrix;
${colors}
out vec3 vView;
out vec3 vEdge;
out vec3 vColor;

void main() {
  uint cell = uint(gl_VertexID / 12);
  uvec4 corners = texelFetch(cells, texel(cell), 0);
  int place = gl_VertexID % 12;
  // Face i leaves corner i out.
  int corner = (place / 3 + 1 + place % 3) % 4;
  vec4 p = position(corners[corner]);
  vec4 view = modelViewMatrix * vec4(dot(axes[0], p), dot(axes[1], p), dot(axes[2], p), 1.0);
  vView = view.xyz;
  gl_Position = projectionMatrix * view;
  vEdge = vec3(1);
  vColor = bodyColor;
  if (colorMode == 1) vColor = distinct(texelFetch(ids, texel(cell), 0).r);
  if (colorMode == 6) vColor = ofNumber(p.w);
#ifdef SPEED
  vColor = ofNumber(speedOf(corners));
#endif
}
`;

export const fragment = `
precision highp float;
uniform float opacity;
uniform bool wireframe;
uniform vec3 edgeColor;
in vec3 vView;
in vec3 vEdge;
in vec3 vColor;
out vec4 color;

vec3 sRgbOf(vec3 c) {
  return mix(c * 12.92, 1.055 * pow(max(c, vec3(0)), vec3(1.0 / 2.4)) - 0.055, step(0.0031308, c));
}

void main() {
  vec3 n = normalize(cross(dFdx(vView), dFdy(vView)));
  if (n.z < 0.0) n = -n;
  vec3 toEye = normalize(-vView);
  float key = max(dot(n, normalize(vec3(-0.4, 0.6, 0.9))), 0.0);
  float fill = max(dot(n, normalize(vec3(0.8, -0.2, 0.5))), 0.0);
  float light = 0.22 + 0.68 * key + 0.2 * fill + 0.1 * n.y;
  float shine = 0.12 * pow(max(dot(n, normalize(normalize(vec3(-0.4, 0.6, 0.9)) + toEye)), 0.0), 40.0);
  vec3 lit = vColor * light + shine;
  if (wireframe) {
    // Not 0, as along a diagonal: smoothstep() is undefined there.
    vec3 width = max(fwidth(vEdge), vec3(1e-5));
    vec3 near = smoothstep(vec3(0), width * 1.2, vEdge);
    // Of triangles of a pixel, edges would leave nothing else.
    float dense = clamp(max(width.x, max(width.y, width.z)) * 1.5, 0.0, 0.75);
    lit = mix(mix(edgeColor, lit, dense), lit, min(near.x, min(near.y, near.z)));
  }
  color = vec4(sRgbOf(lit), 1.0) * opacity;
}
`;
