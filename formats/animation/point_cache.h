#pragma once

#include <bit>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "formats/t4d/byte_source.h"
#include "t4d/mesh.h"

namespace t4d::formats {

/// A point cache: the places of the points of a mesh at a sequence of times, as float32 triples,
/// sample after sample. The points are those of the mesh's file, in its order.
class PointCache {
 public:
  struct Layout {
    std::uint64_t points = 0;
    std::uint64_t samples = 0;
    std::uint64_t firstByte = 0;  ///< of the first sample
    std::endian order = std::endian::little;
  };

  /// `source` holds exactly what `layout` says (checkSize). `times` has one for each sample.
  PointCache(std::unique_ptr<ByteSource> source, const Layout& layout, std::vector<double> times)
      : source_(std::move(source)), layout_(layout), times_(std::move(times)) {}

  const std::string& name() const { return source_->name(); }
  std::uint64_t pointCount() const { return layout_.points; }
  std::uint64_t sampleCount() const { return layout_.samples; }
  /// Times as the file gives them, in its own unit.
  const std::vector<double>& times() const { return times_; }

  /// Reads one sample. Coordinates that are not finite are an error.
  Result<void> read(std::uint64_t sample, std::span<model::Point3> into) const;

  /// Fails, at byte `at`, unless there are points and at least two samples, and the file has
  /// exactly the bytes that they take.
  static Result<void> checkSize(const ByteSource& source, const Layout& layout, std::uint64_t at);

 private:
  std::unique_ptr<ByteSource> source_;
  Layout layout_;
  std::vector<double> times_;
};

}  // namespace t4d::formats
