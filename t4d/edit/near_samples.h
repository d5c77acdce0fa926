#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "t4d/edit/cell_complex.h"
#include "t4d/edit/patch.h"
#include "t4d/measure/slice_bound.h"
#include "t4d/measure/space_time_tetrahedron.h"

namespace t4d::edit {

/// Keeps cells whose edges are collapsed near to the mesh that they come from, as far as its
/// samples, their own vertices and the middles of their edges tell.
class NearSamples {
 public:
  /// Nothing is kept near without an original, which must outlive it.
  NearSamples(std::vector<Sample> samples, std::size_t cellCount,
              const measure::SliceBound* original);

  /// Whether, when a and b join at `place`, this and the middles of its edges are within a distance
  /// of the original, and each sample of the cells around them is within it of one that remains.
  /// Cells at one time are in no slice, and may do what they like.
  bool stayNear(const CellComplex& complex, std::span<const model::Point4> vertices,
                std::uint32_t a, std::uint32_t b, const model::Point4& place, double distance);
  /// Gives them to the cells that stayNear has found.
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

  /// Whether the middles of the edges of the remaining cells at `place` are within a distance of
  /// the original.
  bool areEdgesNear(const CellComplex& complex, std::span<const model::Point4> vertices,
                    std::uint32_t a, std::uint32_t b, const model::Point4& place, double distance);

  /// The remaining cell that a point is nearest to; kNone if it is farther than the distance.
  std::uint32_t nearest(const model::Point4& point, double distance) const;

  static constexpr std::uint32_t kNone = CellComplex::kNone;
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
