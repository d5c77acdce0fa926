#pragma once

#include "formats/t4d/chunk_file.h"
#include "formats/t4d/chunks.h"
#include "t4d/mesh.h"

namespace t4d::formats {

/// Sums up the slabs of a body.
class Tally : public model::Sink {
 public:
  Result<void> put(const model::Slab& slab) override {
    return putPrepared(slab, prepare(slab).get());
  }
  std::unique_ptr<Prepared> prepare(const model::Slab& slab) const override {
    auto bounds = std::make_unique<PreparedBounds>();
    for (const model::Point4& vertex : slab.vertices) bounds->bounds.add(vertex.head<3>());
    return bounds;
  }
  Result<void> putPrepared(const model::Slab& slab, Prepared* prepared) override {
    addSlab(sum, {slab.timeBegin, slab.timeEnd}, *slab.connectivity,
            slab.connectivity->cells.size(), static_cast<PreparedBounds*>(prepared)->bounds);
    return {};
  }
  BodySummary sum;

 private:
  struct PreparedBounds : Prepared {
    model::Bounds3 bounds;
  };
};

/// Does what checkSummary does for the DONE at `doneOffset`.
inline Result<void> checkSummaryOf(const ChunkFile& file, std::uint64_t doneOffset,
                                   std::size_t body, const BodySummary& said,
                                   const BodySummary& found) {
  auto checked = checkSummary(said, found);
  if (checked) return checked;
  return file.damaged(doneOffset,
                      "DONE: body " + std::to_string(body) + ": " + checked.error().message);
}

}  // namespace t4d::formats
