#pragma once

#include "t4d/formats/t4d/chunk_file.h"
#include "t4d/formats/t4d/chunks.h"
#include "t4d/model/slab.h"

namespace t4d::formats {

/// Sums up the slabs of a body.
class Tally : public model::Sink {
 public:
  Result<void> put(const model::Slab& slab) override {
    addSlab(sum, slab);
    return {};
  }
  BodySummary sum;
};

/// As checkSummary, for the DONE at `doneOffset`.
inline Result<void> checkSummaryOf(const ChunkFile& file, std::uint64_t doneOffset,
                                   std::size_t body, const BodySummary& said,
                                   const BodySummary& found) {
  auto checked = checkSummary(said, found);
  if (checked) return checked;
  return file.damaged(doneOffset,
                      "DONE: body " + std::to_string(body) + ": " + checked.error().message);
}

}  // namespace t4d::formats
