#include "formats/t4d/layer_digest.h"

#include <algorithm>

#include "formats/t4d/layout.h"
#include "platform/crc32c.h"

namespace t4d::formats {

using t4d_layout::kBlockRows;

LayerDigest::LayerDigest(std::uint64_t count)
    : count_(count), blocks_(t4d_layout::blockCount(count)) {}

LayerDigest::LayerDigest(std::span<const model::Point4> vertices) : LayerDigest(vertices.size()) {
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    const auto rest = vertices.subspan(i * kBlockRows);
    setBlock(i, rest.first(std::min<std::size_t>(rest.size(), kBlockRows)));
  }
}

void LayerDigest::setBlock(std::size_t block, std::span<const model::Point4> vertices) {
  std::vector<double> column(vertices.size());
  for (int axis = 0; axis < 3; ++axis) {
    std::ranges::transform(vertices, column.begin(),
                           [&](const model::Point4& vertex) { return vertex[axis] + 0.0; });
    blocks_[block][axis] = platform::crc32c(column.data(), column.size() * sizeof(double));
  }
}

}  // namespace t4d::formats
