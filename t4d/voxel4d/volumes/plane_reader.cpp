#include "t4d/voxel4d/volumes/plane_reader.h"

#include <algorithm>

namespace t4d::voxel4d {

Result<void> PlaneReader::read(std::span<std::byte> into) {
  while (!into.empty()) {
    const std::uint64_t number = at_ / planeBytes_;
    const std::uint64_t from = at_ % planeBytes_;
    const auto part = into.first(std::min<std::uint64_t>(into.size(), planeBytes_ - from));
    if (part.size() == planeBytes_) {
      if (auto done = readPlane(number, part); !done) return done;
    } else {
      if (number != number_) {
        plane_.resize(planeBytes_);
        if (auto done = readPlane(number, plane_); !done) return done;
        number_ = number;
      }
      std::ranges::copy(std::span(plane_).subspan(from, part.size()), part.begin());
    }
    at_ += part.size();
    into = into.subspan(part.size());
  }
  return {};
}

}  // namespace t4d::voxel4d
