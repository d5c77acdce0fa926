#include "t4d/mesh.h"

namespace t4d::model {

Slab assembled(const StreamedSlab& slab) {
  auto connectivity = std::make_shared<Connectivity>();
  static_cast<VertexCounts&>(*connectivity) = slab;
  connectivity->cells.resize(slab.cellCount);
  slab.cells(0, connectivity->cells);
  Slab whole{slab.time.begin, slab.time.end, {}, nullptr, {}};
  whole.vertices.resize(slab.vertexCount);
  slab.vertices(0, whole.vertices);
  whole.connectivity = std::move(connectivity);
  return whole;
}

Result<void> Sink::putStreamed(const StreamedSlab& slab) { return put(assembled(slab)); }

}  // namespace t4d::model
