#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "model/attribute.h"
#include "model/error.h"
#include "model/geometry.h"
#include "model/layer_pose.h"
#include "model/times.h"

/// A 4D mesh is the boundary of a moving solid in space-time (x, y, z, t): a closed, oriented
/// 3-manifold of tetrahedral cells. It is always handled as a sequence of slabs in time order:
///
///        t
///        ^    upper layer  *-----*-----*   equal to the lower layer of the next slab
///        |                  \  .   .  /
///        |    interior        .     .
///        |                  /    .    \.
///        |    lower layer  *-----*-----*   equal to the upper layer of the slab before
///        +------------------------------> x, y, z
///
/// Producers of 4D meshes put slabs into a Sink. A Source provides the slabs of a 4D mesh.
namespace t4d::model {

/// A tetrahedron: four vertices (a, b, c, d), local to the slab. With the outward normal n of the
/// mesh, det[n, b-a, c-a, d-a] > 0.
using Cell = std::array<std::uint32_t, 4>;

/// Vertices that are the arithmetic means of others. The sources of mean i are `sources[offsets[i]]
/// .. sources[offsets[i + 1]]`; its four coordinates are the sum of the sources in this order, in
/// double precision, divided by their number. `offsets` is empty (no means) or has one more entry
/// than there are means.
struct Means {
  std::vector<std::uint32_t> offsets = {};
  std::vector<std::uint32_t> sources = {};

  std::uint32_t size() const {
    return offsets.empty() ? 0 : static_cast<std::uint32_t>(offsets.size() - 1);
  }
  void add(std::span<const std::uint32_t> from);
  friend bool operator==(const Means&, const Means&) = default;
};

/// The numbers of vertices of a slab. A layer is the vertices at the first or the last time of a
/// slab. The order of vertices is: lower layer, interior, upper layer.
struct VertexCounts {
  std::uint32_t vertexCount = 0;
  std::uint32_t lowerCount = 0;
  std::uint32_t upperCount = 0;

  std::uint32_t firstUpper() const { return vertexCount - upperCount; }

  friend bool operator==(const VertexCounts&, const VertexCounts&) = default;
};

/// Everything in a slab except positions. Slabs with the same connectivity share one object, so
/// results that depend only on the connectivity can be computed once.
struct Connectivity : VertexCounts {
  std::vector<Cell> cells = {};
  /// The last interior vertices are means. Their sources are not means themselves.
  Means means = {};
  /// Attributes of domain Cell, shared by all slabs with this connectivity.
  std::vector<Attribute> cellAttributes = {};

  std::uint32_t firstMean() const { return firstUpper() - means.size(); }

  friend bool operator==(const Connectivity&, const Connectivity&) = default;
};

/// Fails for an index out of range and a cell with a repeated vertex. The cells are those from
/// number `first` on of a slab with `vertexCount` vertices.
Result<void> checkCells(std::span<const Cell> cells, std::uint32_t vertexCount,
                        std::uint64_t first = 0);

/// Fails for an attribute of the wrong length.
Result<void> checkAttributes(std::span<const Attribute> attributes, std::size_t vertexCount,
                             std::size_t cellCount);

/// Fails for inconsistent counts, an index out of range, a cell with a repeated vertex, a mean of
/// nothing or of a mean, and an attribute of the wrong length. All code that takes slabs from
/// outside the library checks this first.
Result<void> checkConnectivity(const Connectivity& connectivity);

/// The part of a 4D mesh between two consecutive times. A cap is a slab without thickness.
struct Slab {
  double timeBegin = 0;
  double timeEnd = 0;
  std::vector<Point4> vertices = {};
  std::shared_ptr<const Connectivity> connectivity = {};
  /// Attributes of this slab alone, per vertex or per cell. Slabs that share a layer have the same
  /// values there, and setMeans computes those of means.
  std::vector<Attribute> attributes = {};
  /// How the upper layer was made, if known. Only a hint: if the two differ, the vertices are
  /// right.
  std::shared_ptr<const LayerPose> upperPose = nullptr;

  std::span<const Point4> lowerLayer() const {
    return std::span(vertices).first(connectivity->lowerCount);
  }
  std::span<const Point4> upperLayer() const {
    return std::span(vertices).last(connectivity->upperCount);
  }
};

/// Fails for coordinates that are not finite, layers off their times, and vertices outside the
/// slab's times. The vertices are those from number `first` on of a slab that lasts for `time`.
Result<void> checkVertices(std::span<const Point4> vertices, const VertexCounts& counts,
                           const TimeSpan& time, std::uint32_t first = 0);

/// Computes the means of a slab whose other vertices are set. All builders and readers call this
/// function, so a mean has the same bits wherever it is computed.
void setMeans(const Connectivity& connectivity, std::span<Point4> vertices);

/// Computes the rows for means of a vertex attribute whose other rows are set. Floating-point
/// numbers are averaged like positions, in double precision, and rounded to the type of the
/// attribute; a NaN is the quiet NaN without sign and payload. Integers are copied from the first
/// source.
void setMeans(const Connectivity& connectivity, Attribute& attribute);

/// Fails for a missing connectivity, a wrong number of vertices, coordinates that are not finite,
/// layers off their times, vertices outside the slab's times, and attributes of the wrong length.
Result<void> checkSlab(const Slab& slab);

class SlabBlocks;
class StreamedSlab;
struct LayeredSlab;

/// Takes the slabs of one 4D mesh in time order. After an error, the caller must stop.
class Sink {
 public:
  virtual ~Sink() = default;
  virtual Result<void> put(const Slab& slab) = 0;

  /// What a sink computes from a slab alone, without earlier slabs.
  struct Prepared {
    virtual ~Prepared() = default;
  };
  /// Computes what putPrepared needs. Called for several slabs at once, in any order. Null if `put`
  /// does all the work.
  virtual std::unique_ptr<Prepared> prepare(const Slab& /*slab*/) const { return nullptr; }
  /// Takes a slab like `put`, with the result of `prepare` for this slab.
  virtual Result<void> putPrepared(const Slab& slab, Prepared* /*prepared*/) { return put(slab); }

  /// Takes a slab that is made piece by piece. Unless overridden, assembles the slab and calls
  /// `put`.
  virtual Result<void> putStreamed(const StreamedSlab& slab);
};

/// Provides the slabs of one 4D mesh, in any order and to any number of threads at once.
class Source {
 public:
  virtual ~Source() = default;
  virtual std::size_t slabCount() const = 0;
  /// The first and last time of a slab; does not read the slab.
  virtual TimeSpan timeSpan(std::size_t index) const = 0;
  /// The bounds of the slab's vertices, if they are known without reading it.
  virtual std::optional<Bounds3> bounds(std::size_t /*index*/) const { return std::nullopt; }
  /// The number of cells of the slab, if it is known without reading it.
  virtual std::optional<std::uint64_t> cellCount(std::size_t /*index*/) const {
    return std::nullopt;
  }
  /// The slab is valid while the caller holds it and the source exists. A caller that releases each
  /// slab before requesting the next has one in memory at a time.
  virtual Result<std::shared_ptr<const Slab>> slab(std::size_t index) const = 0;
  /// The slab block by block; null if the source does not offer that for this slab. Valid as long
  /// as the source.
  virtual Result<std::shared_ptr<const SlabBlocks>> blocks(std::size_t /*index*/) const {
    return std::shared_ptr<const SlabBlocks>();
  }
  /// The slab without its means; null if the source does not offer that for this slab.
  virtual Result<std::shared_ptr<const LayeredSlab>> layered(std::size_t /*index*/) const {
    return std::shared_ptr<const LayeredSlab>();
  }
};

/// Called with the fraction done, from 0 to 1.
using Progress = std::function<void(double)>;

/// Puts all slabs of `source` into `sink`. They are read one after another and prepared on all
/// threads. Two slabs are in memory, or one for each thread if they are known to be small.
Result<void> pump(const Source& source, Sink& sink, const Progress& progress = {});

/// The first and last time; {0, 0} for a source without slabs.
TimeSpan timeSpanOf(const Source& source);

/// A 4D mesh in memory.
class Mesh : public Sink, public Source {
 public:
  Result<void> put(const Slab& slab) override;
  std::size_t slabCount() const override { return slabs_.size(); }
  TimeSpan timeSpan(std::size_t index) const override;
  std::optional<std::uint64_t> cellCount(std::size_t index) const override;
  /// Valid until the next `put`.
  Result<std::shared_ptr<const Slab>> slab(std::size_t index) const override;

  std::span<const Slab> slabs() const { return slabs_; }

 private:
  std::vector<Slab> slabs_;
};

}  // namespace t4d::model
