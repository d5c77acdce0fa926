#include "voxel4d/volumes/volume_velocity.h"

#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "voxel4d/same_place.h"
#include "voxel4d/sample_box.h"

namespace t4d::voxel4d {

namespace fs = std::filesystem;

namespace {

/// The value of a point that is in the box of the samples.
double valueAt(const SampleField& samples, const Coord& point) {
  const Coord block{point.x / kBlockSize, point.y / kBlockSize, point.z / kBlockSize};
  const auto index = static_cast<unsigned>(point.x % kBlockSize * 64 + point.y % kBlockSize * 8 +
                                           point.z % kBlockSize);
  return samples.at(block, index);
}

/// Whether any sample is not 0.
bool hasMotion(const SampleField& samples, const std::array<std::uint64_t, 3>& sizes) {
  for (std::int32_t x = 0; static_cast<std::uint64_t>(x) < sizes[0]; ++x) {
    for (std::int32_t y = 0; static_cast<std::uint64_t>(y) < sizes[1]; ++y) {
      for (std::int32_t z = 0; static_cast<std::uint64_t>(z) < sizes[2]; ++z) {
        if (valueAt(samples, {x, y, z}) != 0) return true;
      }
    }
  }
  return false;
}

class VolumeVelocity : public VelocitySource {
 public:
  /// `toLattice` maps velocities in space to those in lattice points.
  VolumeVelocity(std::array<VolumeFrames, 3> components, const Eigen::Matrix3d& toLattice)
      : components_(std::move(components)), toLattice_(toLattice) {}

  Place placeOf(std::size_t index) const override { return components_[0].frames->placeOf(index); }

  Result<VelocityField> field(std::size_t index) override {
    std::array<Frame, 3> frames;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      auto frame = components_[axis].frames->frame(index);
      if (!frame) return frame.error();
      frames[axis] = std::move(*frame);
    }
    VelocityField field;
    const auto& sizes = components_[0].sizes;
    field.moves = std::ranges::any_of(
        frames, [&](const Frame& frame) { return hasMotion(*frame.samples, sizes); });
    field.at = [frames = std::move(frames), toLattice = toLattice_,
                sizes = components_[0].sizes](const Coord& point) {
      const auto isIn = [](std::int32_t at, std::uint64_t size) {
        return at >= 0 && static_cast<std::uint64_t>(at) < size;
      };
      std::optional<Eigen::Vector3d> velocity;
      if (!isIn(point.x, sizes[0]) || !isIn(point.y, sizes[1]) || !isIn(point.z, sizes[2])) {
        return velocity;
      }
      const Eigen::Vector3d inSpace(valueAt(*frames[0].samples, point),
                                    valueAt(*frames[1].samples, point),
                                    valueAt(*frames[2].samples, point));
      if (!inSpace.isZero(0)) velocity = toLattice * inSpace;
      return velocity;
    };
    return field;
  }

 private:
  std::array<VolumeFrames, 3> components_;
  Eigen::Matrix3d toLattice_;
};

model::Affine3x4 placeOf(const VolumeFrames& frames) {
  return frames.toSpace.value_or(frames.frames->lattice().place());
}

Result<void> checkAlike(const VolumeFrames& component, const VolumeFrames& frames) {
  const Place where = component.frames->placeOf(0);
  const auto shape = [](const VolumeFrames& volume) {
    return fmt::format("{} x {} x {} samples in {} frames", volume.sizes[0], volume.sizes[1],
                       volume.sizes[2], volume.frames->frameCount());
  };
  if (component.sizes != frames.sizes ||
      component.frames->frameCount() != frames.frames->frameCount()) {
    return invalid(fmt::format("has velocities of {} (x, y, z); the solid has {}", shape(component),
                               shape(frames)),
                   where);
  }
  Eigen::Vector3d last;
  for (int axis = 0; axis < 3; ++axis) last[axis] = static_cast<double>(frames.sizes[axis] - 1);
  const double apart =
      voxelsApart(placeOf(frames), placeOf(component), Eigen::Vector3d::Zero(), last);
  if (apart <= kSamePlace) return {};
  return invalid(fmt::format("has velocities at other positions than the samples of the solid: a "
                             "corner is {:.4g} voxels away; up to {} are taken for rounding",
                             apart, kSamePlace),
                 where);
}

}  // namespace

Result<std::unique_ptr<VelocitySource>> openVolumeVelocity(std::span<const fs::path> files,
                                                           const VolumeOptions& options,
                                                           const VolumeFrames& frames) {
  if (files.size() != 3) {
    return invalid(
        fmt::format("velocities are in {} files; expected three, of the components along "
                    "x, y and z",
                    files.size()));
  }
  VolumeOptions how = options;
  how.valuesAlone = true;
  how.iso.reset();
  how.label.reset();
  how.outside.reset();
  std::array<VolumeFrames, 3> components;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    auto opened = openVolumeFrames({&files[axis], 1}, how);
    if (!opened) return opened.error();
    if (auto alike = checkAlike(*opened, frames); !alike) return alike.error();
    components[axis] = std::move(*opened);
  }
  const Eigen::Matrix3d toSpace = placeOf(frames).leftCols<3>();
  return std::make_unique<VolumeVelocity>(std::move(components), toSpace.inverse());
}

}  // namespace t4d::voxel4d
