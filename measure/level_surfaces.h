#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "measure/slab_reeb.h"
#include "slice/cut.h"
#include "t4d/check.h"
#include "t4d/mesh.h"

namespace t4d::measure {

/// The connected surfaces of a slice at a time, or just after the time of vertices: points on edges
/// are told apart even where they have one position, so that surfaces that touch at that time are
/// not joined.
struct LevelSurfaces {
  slice::Cut cut;
  std::uint32_t count = 0;
  std::vector<std::uint32_t> ofPoint;  ///< the surface of each point of the cut
  std::vector<std::int64_t> euler2;    ///< twice the Euler number of each surface
};

/// `above` has a 1 for each vertex after the time, and a 0 for each other.
LevelSurfaces levelSurfaces(std::span<const model::Cell> cells,
                            std::span<const std::uint8_t> above);

/// 1 for each vertex after the time; with `orAt` for those at the time, too.
std::vector<std::uint8_t> verticesAfter(const model::Slab& slab, double time, bool orAt = false);

/// The arc of each surface of a slice in an odd slot, or model::kNoIndex.
std::vector<std::uint32_t> arcsOf(const LevelSurfaces& surfaces,
                                  const model::Connectivity& connectivity, const SlabReeb& reeb,
                                  std::uint32_t slot);

/// The surfaces of some cells alone just after a time, measured before any of their vertices that
/// is later; and whether `place` is within what they enclose, if given.
struct LocalSurface {
  SolidMeasures measures;
  std::int64_t euler2 = 0;
  bool holdsPlace = false;
};
LocalSurface localSurface(const model::Slab& slab, std::span<const std::uint32_t> cells,
                          double time, const model::Point3* place = nullptr);

/// The positions of the points of a cut at a time.
std::vector<model::Point3> pointsAt(const slice::Cut& cut, std::span<const model::Point4> vertices,
                                    double time);

/// The measures of each surface; the volume of one that faces inward is negative.
std::vector<SolidMeasures> measuresOf(const LevelSurfaces& surfaces,
                                      std::span<const model::Point3> points, double time);

/// For each of the surfaces `inner`, that which a ray from its outermost point in one direction
/// meets first: with the surface of a cavity the next wall of the same solid. Returns `count` where
/// there is none.
std::vector<std::uint32_t> nextSurfaces(const LevelSurfaces& surfaces,
                                        std::span<const model::Point3> points,
                                        std::span<const std::uint32_t> inner);

}  // namespace t4d::measure
