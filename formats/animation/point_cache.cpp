#include "formats/animation/point_cache.h"

#include <fmt/format.h>

#include "formats/input_file.h"

namespace t4d::formats {
namespace {

constexpr std::uint64_t kPointBytes = 3 * sizeof(float);

}  // namespace

Result<void> PointCache::checkSize(const ByteSource& source, const Layout& layout,
                                   std::uint64_t at) {
  if (layout.points == 0) return invalid("holds no points", placeOfByte(source.name(), at));
  if (layout.samples < 2) {
    return invalid(fmt::format("{} sample{}, expected at least 2", layout.samples,
                               layout.samples == 1 ? "" : "s"),
                   placeOfByte(source.name(), at));
  }
  // Both counts have 32 bits, so nothing here overflows.
  const std::uint64_t held = source.size() - layout.firstByte;
  const std::uint64_t needed = layout.points * layout.samples;
  if (held % kPointBytes == 0 && held / kPointBytes == needed) return {};
  return invalid(fmt::format("declares {} samples of {} points, {} bytes each; {} bytes follow",
                             layout.samples, layout.points, kPointBytes, held),
                 placeOfByte(source.name(), at));
}

Result<void> PointCache::read(std::uint64_t sample, std::span<model::Point3> into) const {
  std::vector<std::byte> bytes(layout_.points * kPointBytes);
  const std::uint64_t begin = layout_.firstByte + sample * bytes.size();
  if (auto read = source_->read(begin, bytes); !read) return read;
  const auto* from = reinterpret_cast<const char*>(bytes.data());
  for (std::uint64_t i = 0; i < layout_.points; ++i) {
    for (int axis = 0; axis < 3; ++axis, from += sizeof(float)) {
      into[i][axis] = static_cast<double>(loadNumber<float>(from, layout_.order));
    }
    if (into[i].allFinite()) continue;
    return invalid(fmt::format("sample {}, point {} is ({}, {}, {}), expected finite coordinates",
                               sample, i, into[i].x(), into[i].y(), into[i].z()),
                   placeOfByte(source_->name(), begin + i * kPointBytes));
  }
  return {};
}

}  // namespace t4d::formats
