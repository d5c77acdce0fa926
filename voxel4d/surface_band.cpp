#include "voxel4d/surface_band.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include <fmt/format.h>
#include <openvdb/tools/FastSweeping.h>
#include <openvdb/tools/Interpolation.h>
#include <openvdb/tools/Morphology.h>
#include <openvdb/tools/ValueTransformer.h>
#include <openvdb/tree/LeafManager.h>

#include "voxel4d/advected_frames.h"
#include "voxel4d/indexed_frame.h"
#include "voxel4d/mean_of_known.h"
#include "voxel4d/sample_box.h"
#include "voxel4d/vdb_grid.h"

namespace t4d::voxel4d {
namespace {

using openvdb::FloatGrid;
using openvdb::MaskGrid;
using openvdb::Vec3d;
using openvdb::Vec3f;
using openvdb::Vec3SGrid;

using Distances = openvdb::tree::LeafManager<openvdb::FloatTree>;

/// Values that are this part of the one outside may be clamped.
constexpr double kClamped = 0.99;

constexpr auto kAllNeighbors = openvdb::tools::NN_FACE_EDGE_VERTEX;

Coord pointOf(const openvdb::Coord& at) { return {at.x(), at.y(), at.z()}; }

/// A value of a field as float that tells its sign.
float signedFloat(double value, bool inside) {
  constexpr double kLeast = std::numeric_limits<float>::min();
  constexpr double kMost = std::numeric_limits<float>::max() / 8;
  return static_cast<float>(inside ? std::clamp(value, -kMost, -kLeast)
                                   : std::clamp(value, kLeast, kMost));
}

std::array<Coord, 6> neighborsOf(const Coord& block) {
  const auto [x, y, z] = block;
  return {Coord{x - 1, y, z}, {x + 1, y, z}, {x, y - 1, z},
          {x, y + 1, z},      {x, y, z - 1}, {x, y, z + 1}};
}

/// Calls `visit` with each block on either side of a face between a tile and what is outside.
template <class Visit>
void visitBareFaces(const IndexedFrame& frame, Visit visit) {
  for (const InsideTile& tile : frame.tiles) {
    const std::int32_t last = tile.size - 1;
    for (std::int32_t i = 0; i < tile.size * tile.size; ++i) {
      const std::int32_t u = i / tile.size;
      const std::int32_t v = i % tile.size;
      for (const auto& [x, y, z] :
           {Coord{0, u, v}, {last, u, v}, {u, 0, v}, {u, last, v}, {u, v, 0}, {u, v, last}}) {
        const Coord block{tile.coord.x + x, tile.coord.y + y, tile.coord.z + z};
        for (const Coord& next : neighborsOf(block)) {
          if (frame.blockAt(next) || frame.tileAt(next)) continue;
          visit(block);
          visit(next);
        }
      }
    }
  }
}

/// `valueAt` gives the field at a point of the block, by its index.
template <class ValueAt>
void addLeaf(openvdb::FloatTree& tree, const Coord& block, ValueAt valueAt) {
  float* const values = tree.touchLeaf(cornerOf(block))->buffer().data();
  for (unsigned i = 0; i < 512; ++i) values[i] = valueAt(i);
}

void addSamples(openvdb::FloatTree& tree, const IndexedFrame& frame) {
  std::set<Coord> blocks;  // that the surface may meet
  for (const Block& block : frame.blocks) {
    blocks.insert(block.coord);
    for (const Coord& next : neighborsOf(block.coord)) blocks.insert(next);
  }
  visitBareFaces(frame, [&](const Coord& block) { blocks.insert(block); });
  for (const Coord& block : blocks) {
    addLeaf(tree, block, [&](unsigned i) {
      const double value = frame.samples->at(block, i);
      return signedFloat(value, value < 0);
    });
  }
}

void addBlocks(openvdb::FloatTree& tree, const IndexedFrame& frame) {
  for (std::size_t i = 0; i < frame.blocks.size(); ++i) {
    ValueBuffer buffer;
    const BlockValues values = valuesOf(frame, i, buffer);
    const BlockMask& inside = frame.blocks[i].inside;
    addLeaf(tree, frame.blocks[i].coord, [&](unsigned j) {
      return signedFloat(values.at(j), (inside[j / 64] >> (j % 64) & 1U) != 0);
    });
  }
  visitBareFaces(frame, [&](const Coord& block) { tree.touchLeaf(cornerOf(block)); });
}

/// The points of leaf nodes that have a neighbor on the other side of the surface.
MaskGrid::Ptr crossedPoints(const openvdb::FloatTree& values) {
  auto mask = MaskGrid::create();
  for (auto leaf = values.cbeginLeaf(); leaf; ++leaf) mask->tree().touchLeaf(leaf->origin());
  openvdb::tree::LeafManager<openvdb::MaskTree>(mask->tree())
      .foreach ([&](openvdb::MaskTree::LeafNodeType& leaf, std::size_t) {
        const openvdb::FloatGrid::ConstAccessor value(values);
        for (openvdb::Index i = 0; i < 512; ++i) {
          const openvdb::Coord at = leaf.offsetToGlobalCoord(i);
          const bool inside = value.getValue(at) < 0;
          bool crossed = false;
          for (const auto& [x, y, z] : neighborsOf(pointOf(at))) {
            crossed = crossed || (value.getValue({x, y, z}) < 0) != inside;
          }
          if (crossed) leaf.setValueOn(i);
        }
      });
  return mask;
}

/// The field of a frame, all inactive, and the points at its surface.
struct Field {
  FloatGrid::Ptr values;
  MaskGrid::Ptr surface;
};

Field fieldOf(const Frame& frame) {
  Field field;
  field.values = FloatGrid::create(signedFloat(frame.outsideValue, false));
  openvdb::FloatTree& tree = field.values->tree();
  for (const InsideTile& tile : frame.tiles) {
    const openvdb::Coord corner = cornerOf(tile.coord);
    tree.sparseFill({corner, corner.offsetBy(tile.size * kBlockSize - 1)},
                    signedFloat(tile.value, true), false);
  }
  const IndexedFrame indexed(frame);
  if (frame.samples) {
    addSamples(tree, indexed);
  } else {
    addBlocks(tree, indexed);
  }
  field.surface = crossedPoints(tree);
  openvdb::tools::dilateActiveValues(field.surface->tree(), 1, kAllNeighbors);
  return field;
}

/// The known velocities at the active points of a mask.
Vec3SGrid::Ptr knownVelocities(const MaskGrid& mask, const VelocityField& field) {
  auto velocity = Vec3SGrid::create(Vec3f(0));
  velocity->tree().topologyUnion(mask.tree());
  velocity->tree().voxelizeActiveTiles();
  openvdb::tree::LeafManager<openvdb::Vec3STree>(velocity->tree())
      .foreach ([&](openvdb::Vec3STree::LeafNodeType& leaf, std::size_t) {
        for (auto at = leaf.beginValueOn(); at; ++at) {
          const auto known = field.at(pointOf(at.getCoord()));
          if (known) at.setValue(Vec3f(Vec3d((*known)[0], (*known)[1], (*known)[2])));
          if (!known) at.setValueOff();
        }
      });
  return velocity;
}

/// The largest magnitude, and the point that has it; -1 where nothing is known.
std::pair<double, openvdb::Coord> fastest(const Vec3SGrid& velocity) {
  std::pair<double, openvdb::Coord> most = {-1, {}};
  for (auto at = velocity.cbeginValueOn(); at; ++at) {
    const double speed = Vec3d(*at).length();
    if (speed > most.first) most = {speed, at.getCoord()};
  }
  return most;
}

/// Between lattice points, of the known ones about it; zero where none is.
Vec3f interpolated(const openvdb::Vec3STree& known, const Vec3d& at) {
  const auto mean = meanOfKnown<Vec3d>(at, [&](const openvdb::Coord& point) {
    Vec3f value;
    return known.probeValue(point, value) ? std::optional(Vec3d(value)) : std::nullopt;
  });
  return Vec3f(mean.value_or(Vec3d(0)));
}

/// Sets all inactive values to `far`, with their sign.
void setFar(FloatGrid& distance, float far) {
  openvdb::tools::foreach (distance.beginValueOff(), [=](const FloatGrid::ValueOffIter& at) {
    at.setValue(*at < 0 ? -far : far);
  });
  distance.tree().root().setBackground(far, false);
}

double slopeOf(const Field& field, const FloatGrid& distance) {
  double values = 0;
  double distances = 0;
  const auto value = field.values->getConstAccessor();
  const auto far = distance.getConstAccessor();
  for (auto at = field.surface->cbeginValueOn(); at; ++at) {
    const double here = std::abs(far.getValue(at.getCoord()));
    if (here > 1) continue;
    values += std::abs(value.getValue(at.getCoord()));
    distances += here;
  }
  return distances > 0 ? values / distances : 0;
}

/// Takes the frame's own values for the distances where they are such, about: sweeping rounds edges
/// off.
void takeOwnDistances(const Field& field, const MaskGrid& where, double slope, double outsideValue,
                      FloatGrid& distance) {
  constexpr double kAbout = 0.5;  // voxels
  const auto value = field.values->getConstAccessor();
  auto into = distance.getAccessor();
  for (auto at = where.cbeginValueOn(); at; ++at) {
    const double own = value.getValue(at.getCoord()) / slope;
    if (std::abs(own * slope) >= kClamped * outsideValue) continue;
    if (std::abs(own - into.getValue(at.getCoord())) > kAbout) continue;
    into.setValueOnly(at.getCoord(), static_cast<float>(own));
  }
}

/// Where the point that is at `at` now was `time` ago; by steps of the classical Runge-Kutta
/// method.
template <class Sampler>
Vec3d carriedBack(const Sampler& velocity, Vec3d at, double time, int steps) {
  const double step = -time / steps;
  for (int i = 0; i < steps; ++i) {
    const Vec3d a = velocity.isSample(at);
    const Vec3d b = velocity.isSample(at + step / 2 * a);
    const Vec3d c = velocity.isSample(at + step / 2 * b);
    const Vec3d d = velocity.isSample(at + step * c);
    at += step / 6 * (a + 2.0 * b + 2.0 * c + d);
  }
  return at;
}

}  // namespace

Result<SurfaceBand> SurfaceBand::of(const Frame& frame, const VelocityField& velocity,
                                    double duration) {
  SurfaceBand band;
  band.duration_ = duration;
  Field field = fieldOf(frame);
  const auto [speed, at] = fastest(*knownVelocities(*field.surface, velocity));
  if (speed < 0 && velocity.moves && !field.surface->empty()) {
    return invalid(
        "none of its velocities is near the surface of the frame: its transform may be another");
  }
  band.speed_ = std::max(speed, 0.0);
  const double motion = band.speed_ * duration;
  if (!(motion <= kMostMotion)) {
    return invalid(
        fmt::format("moves the surface by {:.4g} voxels from frame to frame at the voxel ({}, {}, "
                    "{}); at most {} are possible: velocities are in length units per time unit "
                    "of the frames",
                    motion, at.x(), at.y(), at.z(), kMostMotion));
  }
  const int width = kWidth + 1 + static_cast<int>(std::ceil(motion));
  openvdb::tools::dilateActiveValues(field.surface->tree(), width, kAllNeighbors);
  field.surface->tree().voxelizeActiveTiles();
  const Vec3SGrid::Ptr known = knownVelocities(*field.surface, velocity);
  FloatGrid::Ptr values = field.values->deepCopy();
  values->tree().topologyUnion(field.surface->tree());
  const auto nearby = [&](const Vec3d& point) { return interpolated(known->tree(), point); };
  std::tie(band.distance_, band.velocity_) =
      openvdb::tools::sdfToSdfAndExt(*values, nearby, Vec3f(0));
  if (!band.distance_) {  // without a surface
    band.distance_ = values;
    band.velocity_ = Vec3SGrid::create(Vec3f(0));
  }
  setFar(*band.distance_, static_cast<float>(width));
  band.slope_ = slopeOf(field, *band.distance_);
  if (band.slope_ > 0) {
    takeOwnDistances(field, *field.surface, band.slope_, frame.outsideValue, *band.distance_);
  }
  openvdb::tools::foreach (
      known->cbeginValueOn(),
      [to = band.velocity_](const Vec3SGrid::ValueOnCIter& from) {
        to->tree().setValueOnly(from.getCoord(), *from);
      },
      false);
  return band;
}

FloatGrid::Ptr SurfaceBand::carried(double time) const {
  using openvdb::tools::GridSampler;
  constexpr double kStep = 4;  // voxels
  const int steps = 1 + static_cast<int>(std::abs(time) * speed_ / kStep);
  FloatGrid::Ptr result = distance_->deepCopy();
  Distances(result->tree()).foreach ([&](openvdb::FloatTree::LeafNodeType& leaf, std::size_t) {
    const auto velocities = velocity_->getConstAccessor();
    const auto distances = distance_->getConstAccessor();
    const GridSampler<Vec3SGrid::ConstAccessor, openvdb::tools::BoxSampler> velocity(
        velocities, velocity_->transform());
    const GridSampler<FloatGrid::ConstAccessor, openvdb::tools::QuadraticSampler> distance(
        distances, distance_->transform());
    for (auto at = leaf.beginValueOn(); at; ++at) {
      at.setValue(distance.isSample(carriedBack(velocity, at.getCoord().asVec3d(), time, steps)));
    }
  });
  return result;
}

}  // namespace t4d::voxel4d
