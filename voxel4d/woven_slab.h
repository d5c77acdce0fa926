#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "t4d/mesh.h"
#include "voxel4d/coord_index.h"
#include "voxel4d/frame_layer.h"
#include "voxel4d/mask_distance.h"
#include "voxel4d/pattern_table.h"

namespace t4d::voxel4d {

/// The slab between two frames, or between a frame and none. What is in memory is a few bytes for
/// each hypercube that the surface meets; vertices and cells are made when they are asked for.
class WovenSlab : public model::StreamedSlab {
 public:
  /// The frames must outlive the slab. Of the edges along t, those that are crossed at the fraction
  /// f have their vertex at crossings.begin + f * (crossings.end - crossings.begin). Between masks
  /// (FrameLayer::isMask) the distances of `metric`, if there is one, say where that is. Fails for
  /// more than 2^32 - 1 vertices or cells, and if too many points appear or vanish within tiles.
  static Result<std::unique_ptr<WovenSlab>> between(
      const FrameLayer& before, const FrameLayer& after, const model::TimeSpan& time,
      const model::TimeSpan& crossings, const Lattice& lattice, const FaceMetric* metric);

  void vertices(std::uint32_t first, std::span<model::Point4> into) const override;
  void cells(std::uint64_t first, std::span<model::Cell> into) const override;

 private:
  /// The cubes that begin in one block.
  struct WovenBlock {
    Coord coord;
    BlockMask timeEdges{};        // points whose sign differs between the frames
    std::uint32_t firstTime = 0;  // number of the first crossing there
    std::uint32_t firstCell = 0;
    /// Cubes that have cells: the index of their lowest point in the block, and their pattern.
    std::vector<std::pair<std::uint16_t, std::uint16_t>> cubes;
  };

  WovenSlab(const FrameLayer& before, const FrameLayer& after, const model::TimeSpan& crossings,
            const Lattice& lattice, const FaceMetric* metric)
      : before_(before),
        after_(after),
        crossings_(crossings),
        lattice_(lattice),
        metric_(metric != nullptr && before.isMask() && after.isMask() ? metric : nullptr) {}

  Result<void> findBlocks();
  void findCubes(WovenBlock& block) const;
  Result<void> number();
  template <class Take>
  void eachInTime(const WovenBlock& block, Take take) const;
  void fractionsByDistance(const WovenBlock& block, float* into) const;
  void findFractions();
  void placeInTime(const WovenBlock& block, model::Point4* into) const;
  void emitCells(const WovenBlock& block, model::Cell* into) const;

  const FrameLayer& before_;
  const FrameLayer& after_;
  model::TimeSpan crossings_;
  const Lattice& lattice_;
  const FaceMetric* metric_;        // null: by values, or in the middle
  std::vector<WovenBlock> blocks_;  // in WeavingOrder
  CoordIndex index_;
  std::vector<float> fractions_;  // of all crossings in time, if there is a metric
};

}  // namespace t4d::voxel4d
