#include "voxel4d/advected_frames.h"

#include <algorithm>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <openvdb/tools/Prune.h>
#include <openvdb/tree/LeafManager.h>

#include "t4d/mesh.h"
#include "voxel4d/surface_band.h"
#include "voxel4d/vdb_grid.h"

namespace t4d::voxel4d {
namespace {

using openvdb::FloatGrid;

/// A frame, and how it moves.
struct Moving {
  Frame frame;
  VelocityField velocity;
  std::optional<SurfaceBand> band = {};
};

/// The blend of two fields of distances, times `scale`, clamped to the width of a band.
FloatGrid::Ptr blended(const FloatGrid& a, const FloatGrid& b, double part, double scale) {
  const auto far = static_cast<float>(SurfaceBand::kWidth * scale);
  auto blend = FloatGrid::create(far);
  blend->tree().combine2(a.tree(), b.tree(),
                         [&](const float& from, const float& to, float& result) {
                           const double value = scale * ((1 - part) * from + part * to);
                           result = std::clamp(static_cast<float>(value), -far, far);
                         });
  blend->tree().root().setBackground(far, false);
  openvdb::tree::LeafManager<openvdb::FloatTree>(blend->tree())
      .foreach ([&](openvdb::FloatTree::LeafNodeType& leaf, std::size_t) {
        leaf.setValuesOn();
        for (auto at = leaf.beginValueOn(); at; ++at) {
          if (std::abs(*at) >= far) at.setValueOff();
        }
      });
  openvdb::tools::pruneLevelSet(blend->tree(), far, -far);
  return blend;
}

bool isEmpty(const Frame& frame) { return countInside(frame) == 0; }

class AdvectedFrames : public FrameSource {
 public:
  AdvectedFrames(std::unique_ptr<FrameSource> frames, std::unique_ptr<VelocitySource> velocities,
                 std::uint32_t substeps)
      : frames_(std::move(frames)), velocities_(std::move(velocities)), substeps_(substeps) {}

  const Lattice& lattice() const override { return frames_->lattice(); }
  std::size_t frameCount() const override {
    return frames_->frameCount() == 0 ? 0 : (frames_->frameCount() - 1) * substeps_ + 1;
  }
  bool isOneApart() const override { return frames_->isOneApart(); }
  std::string notice() const override {
    const std::string notice = frames_->notice();
    if (vanished_ == 0) return notice;
    return notice + (notice.empty() ? "" : "; ") +
           fmt::format(
               "nothing is left of the solid in {} of the frames in between: the velocities "
               "may have another sign, or another unit",
               vanished_);
  }
  Place placeOf(std::size_t index) const override {
    const std::size_t frame = index / substeps_;
    if (index % substeps_ == 0) return frames_->placeOf(frame);
    return placeIn(frames_->placeOf(frame),
                   fmt::format("{} of {} steps to the next frame", index % substeps_, substeps_));
  }

  void readsPart() override { frames_->readsPart(); }

  Result<Frame> frame(std::size_t index) override {
    const std::size_t step = index % substeps_;
    const bool isFirst = !std::exchange(begun_, true);
    if (isFirst && step != 0) {
      if (auto read = readNext(index / substeps_); !read) return read.error();
    }
    if (isFirst || step == 1 % substeps_) {
      before_ = std::move(next_);
      if (auto read = readNext((index + substeps_ - 1) / substeps_); !read) {
        return read.error();
      }
    }
    return step == 0 ? next_.frame : between(index, step);
  }

 private:
  Result<void> readNext(std::size_t index) {
    auto frame = frames_->frame(index);
    if (!frame) return frame.error();
    if (!frame->hasValues()) {
      return invalid(
          "says only what is inside: velocities carry level sets and densities, whose values say "
          "how far the surface is",
          frames_->placeOf(index));
    }
    auto velocity = velocities_->field(index);
    if (!velocity) return velocity.error();
    next_ = {std::move(*frame), std::move(*velocity)};
    return {};
  }

  /// Makes the bands of both frames; `number` is that of the first.
  Result<void> prepare(std::size_t number) {
    const double duration = next_.frame.time - before_.frame.time;
    if (!(duration > 0)) {
      return invalid(fmt::format("is at time {}, not after the frame before it, at {}",
                                 next_.frame.time, before_.frame.time),
                     frames_->placeOf(number + 1));
    }
    for (Moving* moving : {&before_, &next_}) {
      if (moving->band && moving->band->duration() >= duration) continue;
      auto band = SurfaceBand::of(moving->frame, moving->velocity, duration);
      const std::size_t index = moving == &before_ ? number : number + 1;
      if (!band) return invalid(band.error().message, velocities_->placeOf(index));
      moving->band = std::move(*band);
    }
    return {};
  }

  Result<Frame> between(std::size_t index, std::size_t step) {
    if (auto done = prepare(index / substeps_); !done) return done.error();
    const double part = static_cast<double>(step) / substeps_;
    const double begin = before_.frame.time;
    const double end = next_.frame.time;
    const double time = model::dividedTime({begin, end}, step, substeps_);
    const double scale = scaleAt(part);
    const VdbGrid grid{blended(*before_.band->carried(time - begin),
                               *next_.band->carried(time - end), part, scale),
                       nullptr};
    auto frame = frameOf(grid, time, {}, placeOf(index));
    if (frame && isEmpty(*frame) && !isEmpty(before_.frame) && !isEmpty(next_.frame)) ++vanished_;
    return frame;
  }

  /// The values of one in between change as much from voxel to voxel as those of its neighbours, so
  /// that points change sides when they should.
  double scaleAt(double part) const {
    const double a = before_.band->slope();
    const double b = next_.band->slope();
    if (a > 0 && b > 0) return (1 - part) * a + part * b;
    return std::max(a, b) > 0 ? std::max(a, b) : 1;
  }

  std::unique_ptr<FrameSource> frames_;
  std::unique_ptr<VelocitySource> velocities_;
  std::uint32_t substeps_;
  std::uint64_t vanished_ = 0;
  bool begun_ = false;
  Moving before_;
  Moving next_;
};

}  // namespace

std::unique_ptr<FrameSource> advectedFrames(std::unique_ptr<FrameSource> frames,
                                            std::unique_ptr<VelocitySource> velocities,
                                            std::uint32_t substeps) {
  return std::make_unique<AdvectedFrames>(std::move(frames), std::move(velocities), substeps);
}

}  // namespace t4d::voxel4d
