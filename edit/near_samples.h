#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "edit/cell_complex.h"
#include "edit/patch.h"
#include "measure/slice_bound.h"
#include "measure/space_time_tetrahedron.h"
#include "t4d/mesh.h"

namespace t4d::edit {

/// Keeps cells whose edges are collapsed near the original mesh. This is tested with samples of the
/// original, and with vertices and middles of edges of the cells.
class NearSamples {
 public:
  /// Without an original, no cell is kept near. The original must outlive this object.
  NearSamples(std::vector<Sample> samples, std::size_t cellCount,
              const measure::SliceBound* original);

  /// Whether a and b may join at `place`: `place` and the middles of its edges must be within a
  /// distance of the original, and each sample of the cells around a and b within this distance of
  /// a remaining cell. Cells at one time are in no slice, so they are not tested.
  bool stayNear(const CellComplex& complex, std::span<const model::Point4> vertices,
                std::uint32_t a, std::uint32_t b, const model::Point4& place, double distance);
  /// Assigns the samples to the cells that stayNear has found.
  void move();

  std::vector<Sample> take() { return std::move(samples_); }

 private:
  struct Remaining {
    std::uint32_t cell;
    measure::SpaceTimeTetrahedron tetrahedron;
  };
  struct Move {
    std::uint32_t sample;
    std::uint32_t cell;
  };

  /// Whether the middles of the edges at `place`, of the remaining cells, are within a distance of
  /// the original.
  bool areEdgesNear(const CellComplex& complex, std::span<const model::Point4> vertices,
                    std::uint32_t a, std::uint32_t b, const model::Point4& place, double distance);

  /// The remaining cell that is nearest to a point; model::kNoIndex if it is farther away than the
  /// distance.
  std::uint32_t nearest(const model::Point4& point, double distance) const;

  const measure::SliceBound* original_;
  std::vector<Sample> samples_;
  std::vector<std::uint32_t> first_;  // of each cell
  std::vector<std::uint32_t> next_;   // of each sample
  std::vector<Remaining> remaining_;
  std::vector<std::uint32_t> emptied_;  // cells
  std::vector<std::uint32_t> around_;   // vertices
  std::vector<Move> moves_;
};

}  // namespace t4d::edit
