#include "formats/animation/pc2_reader.h"

#include <array>
#include <cmath>
#include <cstring>
#include <string_view>

#include <fmt/format.h>

#include "formats/input_file.h"

namespace t4d::formats {
namespace {

constexpr std::size_t kPc2HeaderBytes = 32;
constexpr std::string_view kPc2Signature{"POINTCACHE2\0", 12};

}  // namespace

Result<PointCache> openPc2(std::unique_ptr<ByteSource> source) {
  const auto at = [&](std::uint64_t byte) { return placeOfByte(source->name(), byte); };
  if (source->size() < kPc2HeaderBytes) {
    return invalid(fmt::format("the file ends in the header of {} bytes", kPc2HeaderBytes),
                   at(source->size()));
  }
  std::array<std::byte, kPc2HeaderBytes> header;
  if (auto read = source->read(0, header); !read) return read.error();
  const auto* bytes = reinterpret_cast<const char*>(header.data());
  if (std::string_view(bytes, kPc2Signature.size()) != kPc2Signature) {
    return invalid("does not begin with POINTCACHE2: it is not a .pc2 file", at(0));
  }
  const auto version = loadNumber<std::int32_t>(bytes + 12);
  if (version != 1) {
    return fail(ErrorCode::Unsupported, fmt::format("is version {}, expected 1", version), at(12));
  }
  const auto points = loadNumber<std::int32_t>(bytes + 16);
  const auto first = static_cast<double>(loadNumber<float>(bytes + 20));
  const auto rate = static_cast<double>(loadNumber<float>(bytes + 24));
  const auto samples = loadNumber<std::int32_t>(bytes + 28);
  if (points < 0 || samples < 0) {
    return invalid(fmt::format("declares {} points and {} samples", points, samples), at(16));
  }
  if (!std::isfinite(first) || !std::isfinite(rate) || !(rate > 0)) {
    return invalid(fmt::format("begins at frame {} with {} frames between samples, expected a "
                               "number and one above 0",
                               first, rate),
                   at(20));
  }
  const PointCache::Layout layout{static_cast<std::uint64_t>(points),
                                  static_cast<std::uint64_t>(samples), kPc2HeaderBytes,
                                  std::endian::little};
  if (auto good = PointCache::checkSize(*source, layout, 16); !good) return good.error();
  std::vector<double> times;
  times.reserve(layout.samples);
  for (std::uint64_t i = 0; i < layout.samples; ++i) {
    times.push_back(first + static_cast<double>(i) * rate);
  }
  return PointCache(std::move(source), layout, std::move(times));
}

}  // namespace t4d::formats
