#include "formats/animation/mdd_reader.h"

#include <array>
#include <cmath>

#include <fmt/format.h>

#include "formats/input_file.h"

namespace t4d::formats {
namespace {

constexpr std::size_t kMddHeaderBytes = 8;

}  // namespace

Result<PointCache> openMdd(std::unique_ptr<ByteSource> source) {
  const auto at = [&](std::uint64_t byte) { return placeOfByte(source->name(), byte); };
  if (source->size() < kMddHeaderBytes) {
    return invalid(fmt::format("the file ends in the header of {} bytes", kMddHeaderBytes),
                   at(source->size()));
  }
  std::array<std::byte, kMddHeaderBytes> header;
  if (auto read = source->read(0, header); !read) return read.error();
  const auto* bytes = reinterpret_cast<const char*>(header.data());
  const auto samples = loadNumber<std::int32_t>(bytes, std::endian::big);
  const auto points = loadNumber<std::int32_t>(bytes + 4, std::endian::big);
  if (points < 0 || samples < 0) {
    return invalid(fmt::format("declares {} samples and {} points", samples, points), at(0));
  }
  const std::uint64_t timeBytes = static_cast<std::uint64_t>(samples) * sizeof(float);
  if (timeBytes > source->size() - kMddHeaderBytes) {
    return invalid(fmt::format("declares {} samples, whose times the {} bytes that follow cannot "
                               "hold",
                               samples, source->size() - kMddHeaderBytes),
                   at(0));
  }
  const PointCache::Layout layout{static_cast<std::uint64_t>(points),
                                  static_cast<std::uint64_t>(samples), kMddHeaderBytes + timeBytes,
                                  std::endian::big};
  if (auto good = PointCache::checkSize(*source, layout, 0); !good) return good.error();
  std::vector<std::byte> stored(timeBytes);
  if (auto read = source->read(kMddHeaderBytes, stored); !read) return read.error();
  std::vector<double> times;
  times.reserve(layout.samples);
  for (std::uint64_t i = 0; i < layout.samples; ++i) {
    const auto* from = reinterpret_cast<const char*>(stored.data()) + i * sizeof(float);
    times.push_back(static_cast<double>(loadNumber<float>(from, std::endian::big)));
    if (std::isfinite(times.back())) continue;
    return invalid(fmt::format("the time of sample {} is {}", i, times.back()),
                   at(kMddHeaderBytes + i * sizeof(float)));
  }
  return PointCache(std::move(source), layout, std::move(times));
}

}  // namespace t4d::formats
