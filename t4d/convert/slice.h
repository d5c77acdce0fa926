#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "t4d/convert/hyperplane.h"
#include "t4d/model/slab.h"
#include "t4d/model/triangle_mesh.h"

namespace t4d::convert {

/// The section of a 4D mesh by a hyperplane: a closed triangle mesh facing outward, in the
/// coordinates of basisOf(hyperplane).
struct Slice {
  model::TriangleMesh mesh;
  std::uint64_t slabsRead = 0;
  /// Attributes that could not be transferred, one sentence each.
  std::vector<std::string> losses;
};

/// Whether a vertex exactly on the hyperplane counts as below or above it.
enum class OnHyperplane : std::uint8_t { Below, Above };

/// Marching tetrahedra over slabs in time order.
///
/// A cut point is identified by the edge it lies on; if it falls on a vertex, it is that vertex.
/// Triangles that lose a corner this way are dropped. As a result, the section at a layer is
/// exactly the layer's triangles, without slivers, and every section is closed.
///
/// A triangle gets the cell attributes of the cell it was cut from. Vertex attributes are
/// interpolated along the edge if they are floating point; otherwise they are those of the vertex
/// below.
///
/// put() fails if checkHyperplane does, or checkConnectivity or checkSlab for the slab; the
/// connectivity is checked once for all consecutive slabs that share it.
class Slicer : public model::Sink {
 public:
  explicit Slicer(const Hyperplane& hyperplane, OnHyperplane rule = OnHyperplane::Below);
  ~Slicer() override;

  Result<void> put(const model::Slab& slab) override;
  Slice finish();

 private:
  class PointTable;
  struct CutPoint;

  Result<void> check(const model::Slab& slab);
  std::uint32_t cutPoint(const model::Slab& slab, std::uint32_t below, std::uint32_t above);
  void numberAsInLayer(std::size_t firstPoint, std::size_t firstTriangle);
  void carryAttributes(const model::Slab& slab, const std::vector<std::uint32_t>& cells);

  Hyperplane hyperplane_;
  HyperplaneBasis basis_;
  OnHyperplane rule_;
  Slice slice_;
  std::shared_ptr<const model::Connectivity> checked_;  // last one that passed checkConnectivity
  std::vector<double> height_;         // of each vertex of the slab above the hyperplane
  std::unique_ptr<PointTable> table_;  // cut points of this slab, by edge
  std::vector<CutPoint> points_;       // of this slab, in the order of the slice's vertices
  std::size_t firstPoint_ = 0;         // number of slice vertices made by earlier slabs
  std::uint32_t lastFirstUpper_ = 0;
  std::uint32_t lastUpperCount_ = 0;
  bool hasAttributes_ = false;
};

/// The solid at `time`: the limit from later times or, at the last time of the mesh, from earlier
/// ones. A time that equals that of a layer up to rounding (model::timeWithin) is taken as the
/// layer's. Reads one slab. Fails if `time` is outside the mesh (the error gives the range), and if
/// the mesh has no slabs.
Result<Slice> sliceAtTime(const model::Source& source, double time);

/// The section by any hyperplane; reads all slabs. For a hyperplane of constant time, with the
/// normal (0, 0, 0, w) of either sign, this is sliceAtTime. Fails if checkHyperplane, the Slicer or
/// the source does.
Result<Slice> slice(const model::Source& source, const Hyperplane& hyperplane,
                    const model::Progress& progress = {});

}  // namespace t4d::convert
