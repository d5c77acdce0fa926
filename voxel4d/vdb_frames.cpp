#include <algorithm>
#include <cmath>
#include <numeric>

#include <fmt/format.h>

#include "model/limits.h"
#include "t4d/frames.h"
#include "t4d/mesh.h"
#include "voxel4d/advected_frames.h"
#include "voxel4d/frame_spacing.h"
#include "voxel4d/occupancy.h"
#include "voxel4d/region_border.h"
#include "voxel4d/same_place.h"
#include "voxel4d/vdb_file.h"
#include "voxel4d/vdb_grid.h"
#include "voxel4d/vdb_places.h"
#include "voxel4d/vdb_velocity.h"

namespace t4d::voxel4d {

namespace {

namespace fs = std::filesystem;

std::optional<double> numberOf(const openvdb::GridBase& grid, const char* name) {
  if (const auto value = grid.getMetadata<openvdb::DoubleMetadata>(name)) return value->value();
  if (const auto value = grid.getMetadata<openvdb::FloatMetadata>(name)) return value->value();
  if (const auto value = grid.getMetadata<openvdb::Int32Metadata>(name)) return value->value();
  if (const auto value = grid.getMetadata<openvdb::Int64Metadata>(name)) {
    return static_cast<double>(value->value());
  }
  return std::nullopt;
}

Result<void> setTimes(std::vector<VdbPlace>& places, const VdbFramesOptions& options,
                      bool oneApart) {
  if (!options.times.empty()) {
    if (auto good = checkFrameTimes(options.times, places.size()); !good) {
      return invalid(good.error().message, places.front().file.string());
    }
    for (std::size_t i = 0; i < places.size(); ++i) places[i].time = options.times[i];
    return {};
  }
  if (options.frameTime && !(*options.frameTime > 0 && std::isfinite(*options.frameTime))) {
    return invalid(fmt::format("the time between frames is {}; it must be a positive number",
                               *options.frameTime));
  }
  if (!std::isfinite(options.startTime)) {
    return invalid(fmt::format("the start time is {}", options.startTime));
  }
  for (std::size_t i = 0; i < places.size(); ++i) {
    VdbPlace& place = places[i];
    if (options.frameTime || oneApart) {
      place.time = model::steppedTime(options.startTime, options.frameTime.value_or(1), i);
    } else {
      const auto time = numberOf(*place.header, kTimeMetadata);
      if (!time) {
        return invalid(fmt::format("has no time: no number '{}' in its metadata", kTimeMetadata),
                       place.where, Remedy::FrameTime);
      }
      place.time = *time;
    }
    if (!std::isfinite(place.time)) {
      return invalid(fmt::format("its time is {}", place.time), place.where);
    }
    if (i > 0 && options.frameTime && !(place.time > places[i - 1].time)) {
      return invalid(fmt::format("frames {} apart from time {} on: doubles are too coarse there to "
                                 "tell frame {} from the one before",
                                 *options.frameTime, options.startTime, i),
                     {}, Remedy::FrameTime);
    }
    if (std::abs(place.time) > model::kLargestCoordinate) {
      return invalid(fmt::format("its time is {}; the largest possible is {}", place.time,
                                 model::kLargestCoordinate),
                     place.where);
    }
    if (i > 0 && !(place.time > places[i - 1].time)) {
      return invalid(fmt::format("times do not increase: its time is {}, that of the frame before "
                                 "({}) is {}",
                                 place.time, places[i - 1].where.text(), places[i - 1].time),
                     place.where);
    }
  }
  return {};
}

bool severalNames(const std::vector<VdbPlace>& places) {
  return std::any_of(places.begin(), places.end(), [&](const VdbPlace& place) {
    return place.header->getName() != places.front().header->getName();
  });
}

/// The voxels that a grid has, as its metadata say. Without them, as far as voxels can be; none of
/// an empty grid.
openvdb::CoordBBox voxelsOf(const openvdb::GridBase& header) {
  const auto low =
      header.getMetadata<openvdb::Vec3IMetadata>(openvdb::GridBase::META_FILE_BBOX_MIN);
  const auto high =
      header.getMetadata<openvdb::Vec3IMetadata>(openvdb::GridBase::META_FILE_BBOX_MAX);
  if (low && high) return {openvdb::Coord(low->value()), openvdb::Coord(high->value())};
  constexpr std::int32_t kFarthest = kMaxCoordinate;
  return {openvdb::Coord(-kFarthest), openvdb::Coord(kFarthest)};
}

/// Fails if the lattice of a grid is not that of the first, but for rounding.
Result<void> checkSameLattice(const Lattice& first, const openvdb::GridBase& firstHeader,
                              const Lattice& other, const openvdb::GridBase& header) {
  openvdb::CoordBBox voxels = voxelsOf(header);
  voxels.expand(voxelsOf(firstHeader));
  if (voxels.empty()) voxels = {openvdb::Coord(0), openvdb::Coord(0)};
  const auto pointOf = [](const openvdb::Coord& voxel) {
    return Eigen::Vector3d(voxel.x(), voxel.y(), voxel.z());
  };
  const double apart =
      voxelsApart(first.place(), other.place(), pointOf(voxels.min()), pointOf(voxels.max()));
  if (apart <= kSamePlace) return {};
  const auto text = [](const Lattice& l) {
    return fmt::format("voxel size {} and origin ({}, {}, {})", l.voxelSize, l.origin.x(),
                       l.origin.y(), l.origin.z());
  };
  return invalid(
      fmt::format("its transform has {}, that of the first frame {}: a corner of its "
                  "voxels is {:.4g} voxels away from there; up to {} are taken for "
                  "rounding",
                  text(other), text(first), apart, kSamePlace));
}

Result<Lattice> checkHeaders(const std::vector<VdbPlace>& places, const VdbFramesOptions& options) {
  Lattice lattice;
  GridKind kind{};
  for (std::size_t i = 0; i < places.size(); ++i) {
    const auto& [file, grid, where, header, time] = places[i];
    const auto thisKind = kindOf(*header, where);
    if (!thisKind) return thisKind.error();
    if (i == 0) kind = *thisKind;
    if (*thisKind != kind) {
      return invalid(
          fmt::format("is a grid of type {}, the first frame one of type {}: frames with "
                      "values cannot follow frames without",
                      typeOf(*header), typeOf(*places[0].header)),
          where);
    }
    if (options.iso && *thisKind == GridKind::Mask) {
      return invalid(fmt::format("an iso value is given, but a grid of type {} has no values",
                                 typeOf(*header)),
                     where);
    }
    if (!options.iso && header->getGridClass() == openvdb::GRID_FOG_VOLUME) {
      return invalid("is a fog volume (densities), not a level set: it needs an iso value", where,
                     Remedy::IsoValue);
    }
    const auto here = latticeOf(*header, where);
    if (!here) return here.error();
    if (i == 0) lattice = *here;
    if (auto same = checkSameLattice(lattice, *places.front().header, *here, *header); !same) {
      return invalid(same.error().message, where);
    }
  }
  return lattice;
}

/// The points of a region as far as points can be.
std::optional<openvdb::CoordBBox> boxOf(const std::optional<Region>& region) {
  if (!region) return std::nullopt;
  constexpr std::int64_t kFarthest = 2 * std::int64_t{kMaxCoordinate};
  openvdb::CoordBBox box;
  for (int axis = 0; axis < 3; ++axis) {
    const auto& [begin, end] = region->space[axis];
    const auto near = [&](std::int64_t at) {
      return static_cast<std::int32_t>(std::clamp(at, -kFarthest, kFarthest));
    };
    box.min()[axis] = near(begin.value_or(-kFarthest));
    box.max()[axis] = near(end.value_or(kFarthest)) - 1;
  }
  return box;
}

class VdbFrames : public FrameSource {
 public:
  VdbFrames(std::vector<VdbPlace> places, const Lattice& lattice, const VdbFramesOptions& options,
            bool oneApart)
      : places_(std::move(places)),
        oneApart_(oneApart),
        lattice_(lattice),
        iso_(options.iso),
        below_(options.below),
        read_{options.largeFrame, boxOf(options.region)} {
    if (options.region) border_ = RegionBorder(options.region->space);
  }

  const Lattice& lattice() const override { return lattice_; }
  std::size_t frameCount() const override { return places_.size(); }
  Place placeOf(std::size_t index) const override { return places_[index].where; }
  bool isOneApart() const override { return oneApart_; }
  std::string notice() const override { return border_.notice(); }

  void readsPart() override { solid_ = true; }

  Result<Frame> frame(std::size_t index) override {
    const VdbPlace& place = places_[index];
    auto grid = reader_.read(place, read_);
    if (!grid) return grid.error();
    auto frame = frameOf(*grid, place.time, iso_, place.where, below_);
    if (!frame) return frame;
    border_.look(*frame);
    const auto anyInside = [](const Block& block) {
      return std::any_of(block.inside.begin(), block.inside.end(),
                         [](std::uint64_t word) { return word != 0; });
    };
    solid_ = solid_ || !frame->tiles.empty() ||
             std::any_of(frame->blocks.begin(), frame->blocks.end(), anyInside);
    if (index + 1 == places_.size() && !solid_) {
      // Densities are not always marked as such.
      const bool densities = !iso_ && kindOf(*grid->grid, place.where) == GridKind::Values &&
                             grid->grid->getGridClass() == openvdb::GRID_UNKNOWN;
      return invalid(iso_ ? fmt::format("no sample of any frame is {} the iso value {}",
                                        below_ ? "below" : "above", *iso_)
                          : std::string("no sample of any frame is inside"),
                     places_.front().file.string(), densities ? Remedy::IsoValue : Remedy::None);
    }
    return frame;
  }

 private:
  std::vector<VdbPlace> places_;
  bool oneApart_;
  Lattice lattice_;
  std::optional<double> iso_;
  bool below_;
  VdbTreeOptions read_;
  RegionBorder border_;
  VdbPlaceReader reader_;
  bool solid_ = false;  // whether any frame so far had a point inside
};

}  // namespace

Result<std::unique_ptr<FrameSource>> openVdbFrames(std::span<const fs::path> inputs,
                                                   const VdbFramesOptions& options) {
  if (options.iso && !std::isfinite(*options.iso)) {
    return invalid(fmt::format("the iso value is {}", *options.iso));
  }
  if (options.region && !options.velocity.empty()) {
    return invalid(
        "a region and a velocity exclude each other: where a solid is cut off it does not move");
  }
  auto files = vdbFilesOf(inputs);
  if (!files) return files.error();
  std::vector<std::string> velocity;
  if (!options.velocity.empty()) {
    auto names = vdbVelocityGrids(files->front(), options.velocity);
    if (!names) return names.error();
    velocity = std::move(*names);
  }
  auto places = vdbPlacesOf(*files, options.grid, velocity);
  if (!places) return places.error();
  const auto lattice = checkHeaders(*places, options);
  if (!lattice) {
    Error error = lattice.error();
    // In a file with several quantities, some grids are not frames.
    if (error.remedy == Remedy::None && files->size() == 1 && severalNames(*places)) {
      error.remedy = Remedy::GridName;
    }
    return error;
  }
  if (places->size() == 1) {
    return invalid("one frame only; a 4D mesh needs two or more", places->front().where);
  }
  const bool oneApart = !options.frameTime && options.times.empty() &&
                        std::ranges::none_of(*places, [](const VdbPlace& place) {
                          return numberOf(*place.header, kTimeMetadata).has_value();
                        });
  if (auto set = setTimes(*places, options, oneApart); !set) return set.error();
  if (options.region) {
    const auto used =
        extentOf(options.region->time, 't', places->size(), places->front().file.string());
    if (!used) return used.error();
    keep(*places, *used);
  }
  const std::size_t count = places->size();
  auto frames = std::make_unique<VdbFrames>(std::move(*places), *lattice, options, oneApart);
  if (velocity.empty()) return frames;
  if (oneApart) {
    return invalid(
        fmt::format(
            "velocities need the time from frame to frame, and no grid has a number '{}' in "
            "its metadata",
            kTimeMetadata),
        files->front().string(), Remedy::FrameTime);
  }
  auto velocities = openVdbVelocity(*files, velocity, *lattice, count);
  if (!velocities) return velocities.error();
  return advectedFrames(std::move(frames), std::move(*velocities), options.substeps);
}

}  // namespace t4d::voxel4d
