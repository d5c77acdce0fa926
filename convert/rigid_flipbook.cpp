#include "convert/rigid_flipbook.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include <fmt/format.h>

#include "convert/first_looks.h"
#include "convert/flipbook.h"
#include "convert/frame_slices.h"
#include "convert/prism_steps.h"
#include "convert/shown_times.h"
#include "formats/gltf/gltf_rigid_writer.h"
#include "formats/usd/usd_writer.h"
#include "model/progress.h"
#include "t4d/convert.h"

namespace t4d::convert {
namespace {

using model::Affine3x4;
using model::LayerPose;
using model::Point3;
using model::Slab;

/// Rotations computed in doubles are orthogonal to about 1e-15, also after a few products; what is
/// further off has a scale or a shear.
constexpr double kRotationError = 1e-9;

bool isRotation(const Eigen::Matrix3d& matrix) {
  return (matrix.transpose() * matrix - Eigen::Matrix3d::Identity()).norm() <= kRotationError &&
         matrix.determinant() > 0;
}

class RigidSink : public PrismSteps {
 public:
  Result<void> put(const Slab& slab) override {
    if (auto done = PrismSteps::put(slab); !done) return done;
    before_ = slab.upperPose;
    beforeTime_ = slab.timeEnd;
    return {};
  }

  Result<RigidMotion> finish() {
    if (motion_.layers.empty()) return fail(ErrorCode::Unsupported, "it has no steps");
    motion_.solid.triangles = triangles();
    return std::move(motion_);
  }

 private:
  Result<void> step(const Slab& slab) override {
    if (motion_.layers.empty()) {
      if (!before_ || beforeTime_ != slab.timeBegin || !before_->gives(slab.lowerLayer())) {
        return no(slab.timeBegin, "the file has no pose");
      }
      reference_ = before_->reference;
      motion_.solid.vertices = *reference_;
      const model::Bounds3 bounds = boundsOf(motion_.solid);
      motion_.center = bounds.min / 2 + bounds.max / 2;
      if (auto added = addLayer(slab.timeBegin, *before_); !added) return added;
    }
    if (!slab.upperPose || !slab.upperPose->gives(slab.upperLayer())) {
      return no(slab.timeEnd, "the file has no pose");
    }
    if (auto added = addLayer(slab.timeEnd, *slab.upperPose); !added) return added;
    motion_.distance =
        std::max(motion_.distance, chordDistance() + slice::lightDistance(slab, triangles(), 0.25));
    return {};
  }

  Result<void> addLayer(double time, const LayerPose& pose) {
    if (pose.reference != reference_) {
      if (!std::ranges::equal(*pose.reference, *reference_)) {
        return no(time, "the pose is one of another shape");
      }
      reference_ = pose.reference;
    }
    if (!isRotation(pose.pose.leftCols<3>())) {
      return no(time, "the pose is not a rotation: it scales, shears or mirrors");
    }
    motion_.layers.push_back({time, pose.pose});
    return {};
  }

  /// The distance of the last step.
  double chordDistance() const {
    const auto& layers = motion_.layers;
    const Eigen::Matrix3d from = layers[layers.size() - 2].pose.leftCols<3>();
    const Eigen::Matrix3d to = layers.back().pose.leftCols<3>();
    const Eigen::AngleAxisd turn(Eigen::Matrix3d(from.transpose() * to));
    const double half = std::sin(turn.angle() / 4);
    const double lag = 2 * half * half;  // 1 - cos(angle / 2)
    if (lag == 0) return 0;
    double radius = 0;
    for (const Point3& point : motion_.solid.vertices) {
      radius = std::max(radius, turn.axis().cross(point - motion_.center).norm());
    }
    return radius * lag;
  }

  RigidMotion motion_;
  std::shared_ptr<const std::vector<Point3>> reference_;
  std::shared_ptr<const LayerPose> before_;
  double beforeTime_ = 0;
};

/// The pose that players show between two layers.
formats::RigidBody::Key keyBetween(const RigidMotion::Layer& a, const RigidMotion::Layer& b,
                                   const Point3& center, double time) {
  const Eigen::Quaterniond from(Eigen::Matrix3d(a.pose.leftCols<3>()));
  const Eigen::Quaterniond to(Eigen::Matrix3d(b.pose.leftCols<3>()));
  const double fraction = a.time == b.time ? 0 : (time - a.time) / (b.time - a.time);
  const Point3 start = model::posed(a.pose, center);
  formats::RigidBody::Key key;
  key.rotation = from.slerp(fraction, to);
  key.translation = start + fraction * (model::posed(b.pose, center) - start);
  return key;
}

/// The keys from `span.begin`, at second 0, to `span.end`, at `seconds`.
formats::RigidBody rigidBody(const model::Body& body, RigidMotion motion,
                             const model::TimeSpan& span, double seconds) {
  formats::RigidBody made;
  made.mesh.name = body.name;
  const auto secondsAt = [&](double time) {
    return span.end > span.begin ? (time - span.begin) / (span.end - span.begin) * seconds : 0;
  };
  const auto& layers = motion.layers;
  const double begin = std::clamp(span.begin, layers.front().time, layers.back().time);
  const double end = std::clamp(span.end, layers.front().time, layers.back().time);
  const auto add = [&](double time) {
    auto next = std::ranges::lower_bound(layers, time, {}, &RigidMotion::Layer::time);
    if (next == layers.end()) --next;
    const auto before = next == layers.begin() || next->time == time ? next : next - 1;
    made.keys.push_back(keyBetween(*before, *next, motion.center, time));
    made.keys.back().seconds = secondsAt(time);
  };
  add(begin);
  for (const RigidMotion::Layer& layer : layers) {
    if (layer.time > begin && layer.time < end) add(layer.time);
  }
  if (end > begin) add(end);
  made.mesh.mesh = std::move(motion.solid);
  for (Point3& point : made.mesh.mesh.vertices) point -= motion.center;
  return made;
}

Result<std::vector<std::string>> writeUsd(const std::filesystem::path& path,
                                          std::span<const formats::RigidBody> bodies, double end,
                                          const FlipbookOptions& options) {
  auto writer = formats::UsdWriter::create(path, options.framesPerSecond, 1, options.write);
  if (!writer) return writer.error();
  for (const formats::RigidBody& body : bodies) {
    if (auto added = writer->addRigid(body); !added) return added.error();
  }
  return writer->finish(end);
}

}  // namespace

Result<RigidMotion> rigidMotionOf(const model::Source& source, const model::Progress& progress) {
  RigidSink sink;
  if (auto done = model::pump(source, sink, progress); !done) return done.error();
  return sink.finish();
}

Result<FrameSlicesReport> writeRigidFlipbook(std::span<const model::Body> bodies,
                                             std::span<const double> times,
                                             const std::filesystem::path& path,
                                             const FlipbookOptions& options,
                                             const model::Progress& progress) {
  if (auto checked = checkFlipbook(bodies, times, options); !checked) {
    return checked.error();
  }
  const model::TimeSpan span{times.front(), times.back()};
  // Times in USD are counted in frames.
  const bool isUsd = formats::isUsd(path);
  const double perSecond = isUsd ? 1 : options.framesPerSecond;
  const double seconds = static_cast<double>(times.size()) / perSecond;
  const double moving = static_cast<double>(times.size() - 1) / perSecond;
  std::vector<formats::RigidBody> made;
  FrameSlicesReport report;
  report.frames = times.size();
  report.light = true;
  for (const model::Body& body : bodies) {
    if (body.source->slabCount() == 0) continue;
    const auto number = static_cast<std::uint64_t>(&body - bodies.data());
    const model::Progress progressOfBody = model::eachOf(progress, number, bodies.size());
    auto motion = rigidMotionOf(*body.source, progressOfBody);
    if (!motion) {
      return ofBody(body.name, "is not a rigid one whose poses are known", motion.error());
    }
    report.distance = std::max(report.distance, motion->distance);
    made.push_back(rigidBody(body, std::move(*motion), span, moving));
    formats::RigidBody& last = made.back();
    report.triangles += last.mesh.mesh.triangles.size();
    const auto looksLost = addFirstLooks(body, span, options, last.mesh);
    if (!looksLost) return looksLost.error();
    addNewLines(*looksLost, report.losses);
    last.shown = shownTimes(body, times, perSecond);
    if (last.shown.size() == 1 && last.shown.front().second) last.shown.clear();
  }
  auto lost = isUsd ? writeUsd(path, made, seconds, options)
                    : formats::writeRigidAnimation(path, made, seconds, options.write);
  if (!lost) return lost.error();
  addNewLines(*lost, report.losses);
  report.files = {path};
  return report;
}

}  // namespace t4d::convert
