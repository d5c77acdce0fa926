#include "t4d/model/streamed_slab.h"

namespace t4d::model {

Slab assembled(const StreamedSlab& slab) {
  auto connectivity = std::make_shared<Connectivity>();
  connectivity->vertexCount = slab.vertexCount;
  connectivity->lowerCount = slab.lowerCount;
  connectivity->upperCount = slab.upperCount;
  connectivity->cells.resize(slab.cellCount);
  slab.cells(0, connectivity->cells);
  Slab whole{slab.timeBegin, slab.timeEnd, {}, nullptr, {}};
  whole.vertices.resize(slab.vertexCount);
  slab.vertices(0, whole.vertices);
  whole.connectivity = std::move(connectivity);
  return whole;
}

Result<void> Sink::putStreamed(const StreamedSlab& slab) { return put(assembled(slab)); }

}  // namespace t4d::model
