#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "t4d/mesh.h"

namespace t4d::formats {

/// A body with its counts, as formats::BodySummary and measure::MeshReport have them.
struct CountedBody : model::Body {
  std::uint64_t vertices = 0;  ///< those on a seam counted once
  std::uint64_t tetrahedra = 0;
};

/// The bodies of a 4D mesh as formats without slabs have them: one list of all vertices, one of all
/// tetrahedra. Each list is one pass over the slabs, with two slabs in memory.
class FlatBodies {
 public:
  /// Fails if there are more vertices than 32-bit indices can number. `bodies` must outlive this.
  static Result<FlatBodies> of(std::span<const CountedBody> bodies);

  std::span<const CountedBody> bodies() const { return bodies_; }
  std::uint64_t vertexCount() const { return vertexCount_; }
  std::uint64_t cellCount() const { return cellCount_; }

  /// Calls back with all vertices in order, at most kMostAtOnce at a time.
  Result<void> forVertices(
      const std::function<Result<void>(std::span<const model::Point4>)>& take) const;

  /// Calls back with all tetrahedra in order, body by body, at most kMostAtOnce at a time. Their
  /// indices refer to the list of all vertices.
  Result<void> forCells(
      const std::function<Result<void>(std::size_t body, std::span<const model::Cell>)>& take)
      const;

  /// Finds the attributes that `keeps` accepts and that all slabs of all bodies have, of one type
  /// and number of components; one pass over the slabs.
  Result<void> findAttributes(bool (*keeps)(const model::Attribute&));
  /// The attributes that were found, without rows, in the order of the first slab.
  std::span<const model::Attribute> attributes() const { return attributes_; }
  /// Calls back with the rows of one of them, for all vertices or all tetrahedra in order.
  Result<void> forRows(const model::Attribute& attribute,
                       const std::function<Result<void>(std::span<const std::byte>)>& take) const;

  static constexpr std::size_t kMostAtOnce = std::size_t{1} << 16;

 private:
  std::span<const CountedBody> bodies_;
  std::uint64_t vertexCount_ = 0;
  std::uint64_t cellCount_ = 0;
  std::vector<model::Attribute> attributes_;
};

}  // namespace t4d::formats
