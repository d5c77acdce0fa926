#include <cstdio>

#include "t4d/mesh.h"

// The boundary of a pentachoron, as one slab without layers.
int main() {
  using namespace t4d::model;
  auto connectivity = std::make_shared<Connectivity>();
  connectivity->vertexCount = 5;
  connectivity->cells = {{1, 2, 3, 4}, {0, 3, 2, 4}, {0, 1, 3, 4}, {0, 2, 1, 4}, {0, 1, 2, 3}};
  Slab slab;
  slab.timeEnd = 1;
  slab.vertices = {{0, 0, 0, 0}, {1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}};
  slab.connectivity = connectivity;
  Mesh mesh;
  if (!mesh.put(slab)) return 1;
  const auto flat = flatten(mesh);
  if (!flat) return 1;
  std::printf("%td vertices, %td cells\n", flat->vertices.rows(), flat->cells.rows());
}
