#pragma once

/// 4D meshes as slabs, and what makes and takes them.

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "t4d/error.h"

namespace t4d::model {

using Point3 = Eigen::Vector3d;  ///< x, y, z in length units
using Point4 = Eigen::Vector4d;  ///< x, y, z in length units, t in time units

/// Axis-aligned bounds; empty (min > max) until something is added.
template <int Dimension>
struct Bounds {
  using Point = Eigen::Matrix<double, Dimension, 1>;
  Point min = Point::Constant(std::numeric_limits<double>::infinity());
  Point max = Point::Constant(-std::numeric_limits<double>::infinity());

  bool empty() const { return !(min.array() <= max.array()).all(); }
  void add(const Point& point) {
    min = min.cwiseMin(point);
    max = max.cwiseMax(point);
  }
  /// Empty bounds add nothing.
  void add(const Bounds& other) {
    min = min.cwiseMin(other.min);
    max = max.cwiseMax(other.max);
  }
};

using Bounds3 = Bounds<3>;
using Bounds4 = Bounds<4>;

/// No number: stands in place of the number of a vertex, triangle or cell, or of another number
/// given in memory.
inline constexpr std::uint32_t kNoIndex = ~std::uint32_t{0};

}  // namespace t4d::model

/// Times of layers, frames and slices, computed to equal the decimal numbers that people type.
///
/// A double means the shortest decimal number that reads back as it, for instance 0.7. Multiples
/// are computed exactly for these decimal numbers and rounded once: the third step of 0.7 from 0
/// ends at 2.1, while 3 * 0.7 in doubles is 2.0999999999999996. If the exact numbers need more than
/// 128 bits, plain double arithmetic is used.
namespace t4d::model {

class Source;

struct TimeSpan {
  double begin = 0;
  double end = 0;
};

/// begin + k * step.
double steppedTime(double begin, double step, std::uint64_t k);

/// begin + (end - begin) * k / n, with n > 0; begin for k = 0, end for k = n. k may exceed n.
double dividedTime(const TimeSpan& span, std::uint64_t k, std::uint64_t n);

/// The steppedTime of every k below `count`.
std::vector<double> steppedTimes(double begin, double step, std::uint64_t count);

/// `count` times evenly spaced from `begin` to `end`, both included; `begin` alone for one.
std::vector<double> evenTimes(const TimeSpan& span, std::uint64_t count);

/// Times within this distance are considered equal. It is in units in the last place of the largest
/// magnitude among the time and both ends of the mesh. Sums of rounded steps are off by one or two.
inline constexpr int kSameTimeUlps = 4;

/// The time of a mesh that `time` refers to: the nearest end or layer within kSameTimeUlps,
/// otherwise `time` itself; nothing if it is outside the mesh, or the mesh has no slab.
std::optional<double> timeWithin(const Source& source, double time);

/// The time that `time` refers to in a mesh that lasts for `span`: the nearest end within
/// kSameTimeUlps, otherwise `time` itself; nothing if it is outside the span.
std::optional<double> timeWithin(const TimeSpan& span, double time);

/// The 3x4 matrix (rotation | translation) of an affine map.
using Affine3x4 = Eigen::Matrix<double, 3, 4>;

/// x = ((m00 qx + m01 qy) + m02 qz) + m03, and y and z by the next rows, each operation in double
/// precision. All code that computes or checks a posed layer calls this function, so it has the
/// same bits wherever it is computed.
Point3 posed(const Affine3x4& pose, const Point3& point);

/// The vertices of a layer as those of a reference, moved by a pose. A solid that keeps its shape
/// is stored in this way.
struct LayerPose {
  std::shared_ptr<const std::vector<Point3>> reference = {};
  Affine3x4 pose = Affine3x4::Identity();
  /// The reference is rounded to float32 first, and so is the result.
  bool float32 = false;

  Point3 at(std::size_t vertex) const;
  /// Whether the layer has exactly the positions of this pose; times are ignored.
  bool gives(std::span<const Point4> layer) const;
};

/// The type of the numbers in an attribute. Enumerator values are those of the file format
/// (formats/t4d/SPEC.md).
enum class ScalarType : std::uint8_t {
  UInt8 = 1,
  Int8 = 2,
  UInt16 = 3,
  Int16 = 4,
  UInt32 = 5,
  Int32 = 6,
  UInt64 = 7,
  Int64 = 8,
  Float32 = 9,
  Float64 = 10,
};

/// Bytes of one scalar; 0 for a value that is not a ScalarType.
std::size_t scalarSize(ScalarType type);

/// The elements that rows of an attribute belong to. A cell is a tetrahedron of a 4D mesh, or a
/// triangle of a slice.
enum class Domain : std::uint8_t { Vertex = 1, Cell = 2 };

/// A named array of numbers with one row per vertex or per cell.
struct Attribute {
  std::string name = {};
  Domain domain = Domain::Cell;
  ScalarType type = ScalarType::Float64;
  std::uint32_t components = 1;
  /// All rows in order, `rowBytes()` bytes each, in the machine's byte order.
  std::vector<std::byte> values = {};

  std::size_t rowBytes() const { return scalarSize(type) * components; }
  std::size_t rows() const { return rowBytes() == 0 ? 0 : values.size() / rowBytes(); }
  const std::byte* row(std::size_t index) const { return values.data() + index * rowBytes(); }

  friend bool operator==(const Attribute&, const Attribute&) = default;
};

/// Writes to `into` the values at a point on the edge between the vertices of two rows, at
/// `fraction` of the way: floating-point numbers are interpolated, integers are those of the first
/// row.
void interpolateRow(const Attribute& attribute, std::size_t from, std::size_t to, double fraction,
                    std::byte* into);

/// The attributes of domain Vertex, with `count` rows from row `first` on.
std::vector<Attribute> vertexRows(std::span<const Attribute> attributes, std::size_t first,
                                  std::size_t count);

template <class T>
constexpr ScalarType scalarTypeOf();
template <>
constexpr ScalarType scalarTypeOf<std::uint8_t>() {
  return ScalarType::UInt8;
}
template <>
constexpr ScalarType scalarTypeOf<std::int8_t>() {
  return ScalarType::Int8;
}
template <>
constexpr ScalarType scalarTypeOf<std::uint16_t>() {
  return ScalarType::UInt16;
}
template <>
constexpr ScalarType scalarTypeOf<std::int16_t>() {
  return ScalarType::Int16;
}
template <>
constexpr ScalarType scalarTypeOf<std::uint32_t>() {
  return ScalarType::UInt32;
}
template <>
constexpr ScalarType scalarTypeOf<std::int32_t>() {
  return ScalarType::Int32;
}
template <>
constexpr ScalarType scalarTypeOf<std::uint64_t>() {
  return ScalarType::UInt64;
}
template <>
constexpr ScalarType scalarTypeOf<std::int64_t>() {
  return ScalarType::Int64;
}
template <>
constexpr ScalarType scalarTypeOf<float>() {
  return ScalarType::Float32;
}
template <>
constexpr ScalarType scalarTypeOf<double>() {
  return ScalarType::Float64;
}

/// An attribute with one component per row, copied from `values`.
template <class T>
Attribute makeAttribute(std::string name, Domain domain, const std::vector<T>& values) {
  const auto* bytes = reinterpret_cast<const std::byte*>(values.data());
  return {std::move(name), domain, scalarTypeOf<T>(), 1,
          std::vector<std::byte>(bytes, bytes + values.size() * sizeof(T))};
}

struct Transform;

/// What the numbers of an attribute mean, so that they can be mapped together with the solid
/// (formats/t4d/SPEC.md, section "Kinds of attributes").
struct AttributeMeaning {
  /// "scalar", "vector", "point", "normal", "color" or "label"; "" is "scalar".
  std::string kind;
  /// A product of powers, in which `length` and `time` are the units of the file: "length/time",
  /// "1/time^2", "N"; "" for none.
  std::string unit;
  /// Further members of its JSON object, kept as they are.
  std::string otherJson = "{}";

  friend bool operator==(const AttributeMeaning&, const AttributeMeaning&) = default;
};

/// Maps the names of attributes to their meanings.
using AttributeMeanings = std::map<std::string, AttributeMeaning>;

/// The meaning in `given`; otherwise that of the name if the format registers it with this type,
/// such as `velocity`; otherwise the default.
AttributeMeaning meaningOf(const Attribute& attribute, const AttributeMeanings& given);

/// Whether the values are directions or positions in space: a vector, a point or a normal.
bool isSpatial(const AttributeMeaning& meaning);

/// The powers of `length` and `time` in a unit. Both are 0 for a unit that is not a product of
/// powers.
struct UnitPowers {
  int length = 0;
  int time = 0;
};
UnitPowers powersOf(std::string_view unit);

/// Maps the values of an attribute with the solid: vectors turn and stretch, points move, normals
/// stay perpendicular to their surface and keep their length, numbers in units of length and time
/// are scaled; labels and colours stay. Returns whether any value may have changed. Fails with
/// ErrorCode::Unsupported if the attribute cannot be mapped: for a unit of length if the map does
/// not scale all directions by the same factor, for types and components that the kind cannot have,
/// and for an unknown kind. Fails with ErrorCode::InvalidInput if a value becomes infinite, or a
/// whole row 0.
Result<bool> mapValues(Attribute& attribute, const AttributeMeaning& meaning, const Transform& by);

}  // namespace t4d::model

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
  /// The pose that made the upper layer, if known. It is only a hint: if the two differ, the
  /// vertices are right.
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

  /// The part of a sink's work that needs a slab alone, without earlier slabs.
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

/// Called with the fraction done, from 0 to 1. Returns whether to go on: after false, the work ends
/// with the error "stopped", of code Failed.
using Progress = std::function<bool(double)>;

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

/// A slab that is made piece by piece, like those between two voxel frames, which can have more
/// cells than fit into memory. It has neither means nor attributes.
class StreamedSlab : public VertexCounts {
 public:
  virtual ~StreamedSlab() = default;

  TimeSpan time;
  std::uint64_t cellCount = 0;

  /// Sets `into` to the vertices, or the cells, from number `first` on; they must exist. Every call
  /// gives the same values. Safe to call from several threads at once.
  virtual void vertices(std::uint32_t first, std::span<Point4> into) const = 0;
  virtual void cells(std::uint64_t first, std::span<Cell> into) const = 0;
};

/// The complete slab in memory.
Slab assembled(const StreamedSlab& slab);

/// A named 4D mesh; a file may have several.
struct Body {
  std::string name = {};
  const Source* source = nullptr;
};

/// The span from the first time of any body to the last; {0, 0} if no body has a slab.
TimeSpan timeSpanOf(std::span<const Body> bodies);

/// Numbers from `begin` up to, not including, `end`.
struct PartRange {
  std::uint64_t begin = 0;
  std::uint64_t end = 0;

  std::uint64_t size() const { return end - begin; }
};

/// One of several consecutive parts of a whole, each worked on alone.
struct Part {
  std::uint64_t number = 1;  ///< from 1 to count
  std::uint64_t count = 1;

  bool isFirst() const { return number == 1; }
  bool isLast() const { return number == count; }

  /// Its share of `all` things in a row, such as steps: the first parts have one more where they do
  /// not divide evenly. Empty for some parts if there are fewer things than parts.
  PartRange of(std::uint64_t all) const { return {before(number - 1, all), before(number, all)}; }

 private:
  std::uint64_t before(std::uint64_t parts, std::uint64_t all) const {
    return parts * (all / count) + (parts < all % count ? parts : all % count);
  }
};

/// Discards slabs: for reading a source through, and for timing producers.
class NullSink : public Sink {
 public:
  Result<void> put(const Slab& /*slab*/) override { return {}; }
  Result<void> putStreamed(const StreamedSlab& /*slab*/) override { return {}; }
};

/// Collects the names of the attributes of all slabs, and passes the slabs on.
class AttributeNames : public Sink {
 public:
  /// The sink must outlive this one.
  explicit AttributeNames(Sink& next) : next_(next) {}

  Result<void> put(const Slab& slab) override { return putPrepared(slab, prepare(slab).get()); }
  std::unique_ptr<Prepared> prepare(const Slab& slab) const override { return next_.prepare(slab); }
  Result<void> putPrepared(const Slab& slab, Prepared* prepared) override {
    if (slab.connectivity) note(slab.connectivity->cellAttributes);
    note(slab.attributes);
    return next_.putPrepared(slab, prepared);
  }
  const std::set<std::string>& names() const { return names_; }

 private:
  void note(const std::vector<Attribute>& attributes) {
    for (const Attribute& attribute : attributes) names_.insert(attribute.name);
  }

  Sink& next_;
  std::set<std::string> names_;
};

/// Passes each slab to several sinks, in the order given. The first error ends the stream.
class Tee : public Sink {
 public:
  /// The sinks must outlive the tee.
  explicit Tee(std::vector<Sink*> sinks) : sinks_(std::move(sinks)) {}

  Result<void> put(const Slab& slab) override {
    for (Sink* sink : sinks_) {
      if (auto done = sink->put(slab); !done) return done;
    }
    return {};
  }
  std::unique_ptr<Prepared> prepare(const Slab& slab) const override {
    auto all = std::make_unique<PreparedAll>();
    for (const Sink* sink : sinks_) all->each.push_back(sink->prepare(slab));
    return all;
  }
  Result<void> putPrepared(const Slab& slab, Prepared* prepared) override {
    const auto& all = static_cast<const PreparedAll&>(*prepared);
    for (std::size_t i = 0; i < sinks_.size(); ++i) {
      if (auto done = sinks_[i]->putPrepared(slab, all.each[i].get()); !done) return done;
    }
    return {};
  }
  Result<void> putStreamed(const StreamedSlab& slab) override {
    for (Sink* sink : sinks_) {
      if (auto done = sink->putStreamed(slab); !done) return done;
    }
    return {};
  }

 private:
  struct PreparedAll : Prepared {
    std::vector<std::unique_ptr<Prepared>> each;
  };

  std::vector<Sink*> sinks_;
};

/// A whole 4D mesh as two matrices.
struct FlatMesh {
  /// One row (x, y, z, t) per vertex, in time order.
  Eigen::Matrix<double, Eigen::Dynamic, 4, Eigen::RowMajor> vertices;
  /// One row of four vertex indices per tetrahedron, oriented as Cell.
  Eigen::Matrix<std::uint32_t, Eigen::Dynamic, 4, Eigen::RowMajor> cells;
};

/// Joins all slabs of a mesh. The layer between two slabs appears once. Attributes are dropped.
///
/// Fails if the source does, if a lower layer differs from the upper layer of the previous slab, or
/// if the mesh has more than 2^32 - 1 vertices.
Result<FlatMesh> flatten(const Source& source, const Progress& progress = {});

/// A map of space and time: x becomes A x + b for `space` = (A | b), and t becomes
/// timeScale * t + timeShift.
struct Transform {
  Affine3x4 space = Affine3x4::Identity();
  double timeScale = 1;  ///< positive
  double timeShift = 0;

  Point4 operator()(const Point4& point) const;
  double time(double t) const { return timeScale * t + timeShift; }
  bool mirrors() const;
  /// Whether A is singular, or so nearly singular that a solid would become flat up to rounding.
  bool flattens() const;
};

/// Maps all vertices. If space is mirrored, the last two vertices of each cell are exchanged, so
/// that the mesh still faces outward. Layers that are poses of a reference (Slab::upperPose) remain
/// such. Attributes are mapped by their meanings (mapValues); those that cannot be mapped are left
/// out.
///
/// `put` and `putStreamed` fail if two different times become equal, `put` also if a value of an
/// attribute overflows or underflows.
class Transformed : public Sink {
 public:
  /// `into` must outlive this sink. The determinant of A is not zero.
  Transformed(Sink& into, const Transform& by, AttributeMeanings meanings = {})
      : into_(into), by_(by), meanings_(std::move(meanings)), mirrors_(by.mirrors()) {}

  Result<void> put(const Slab& slab) override;
  Result<void> putStreamed(const StreamedSlab& slab) override;

  /// The names of attributes that were left out, with the reasons.
  const std::map<std::string, std::string>& lostAttributes() const { return lost_; }

 private:
  Result<TimeSpan> timesOf(double begin, double end) const;
  Result<bool> mapAttributes(std::vector<Attribute>& attributes, const Connectivity& connectivity);
  Result<void> mapConnectivity(Slab& moved);
  void moveLayers(const Slab& slab, Slab& moved);
  std::vector<Point4> takeLower(std::span<const Point4> given);
  LayerPose poseOf(const LayerPose& given);

  Sink& into_;
  Transform by_;
  AttributeMeanings meanings_;
  std::map<std::string, std::string> lost_;
  bool mirrors_;
  // The last connectivity and its image, which the mapped slabs share.
  std::shared_ptr<const Connectivity> given_;
  std::shared_ptr<const Connectivity> mapped_;
  // The last reference of posed layers and its image.
  std::shared_ptr<const std::vector<Point3>> givenReference_;
  std::shared_ptr<const std::vector<Point3>> movedReference_;
  // The upper layer of the last slab, if it was posed: before and after mapping.
  std::vector<Point4> givenUpper_;
  std::vector<Point4> movedUpper_;
};

}  // namespace t4d::model
