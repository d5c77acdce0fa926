#include "measure/chord_bound.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "model/progress.h"

namespace t4d::measure {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using model::LayerPose;
using model::Slab;

/// The longest edge of triangles of the lower layer, measured across an axis.
double longestEdge(const Slab& slab, const Vector3d& axis) {
  double longest = 0;
  const std::uint32_t lower = slab.connectivity->lowerCount;
  for (const model::Cell& cell : slab.connectivity->cells) {
    for (int k = 0; k < 4; ++k) {
      for (int l = 0; l < k; ++l) {
        if (cell[k] >= lower || cell[l] >= lower) continue;
        const Vector3d edge = (slab.vertices[cell[k]] - slab.vertices[cell[l]]).head<3>();
        longest = std::max(longest, axis.cross(edge).norm());
      }
    }
  }
  return longest;
}

/// The pose of a layer without a stated one: that of another layer, `like`, moved rigidly; with the
/// rotation of `like` if only a translation lies between them. Nothing if the layer is not `like`,
/// moved.
std::shared_ptr<const LayerPose> fittedPose(std::span<const model::Point4> layer,
                                            const LayerPose& like) {
  if (layer.empty() || like.reference->size() != layer.size()) return nullptr;
  const auto count = static_cast<Eigen::Index>(layer.size());
  Eigen::Matrix3Xd from(3, count);
  Eigen::Matrix3Xd to(3, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    from.col(i) = like.at(static_cast<std::size_t>(i));
    to.col(i) = layer[static_cast<std::size_t>(i)].head<3>();
  }
  const Eigen::Matrix4d moved = Eigen::umeyama(from, to, /*with_scaling=*/false);
  Matrix3d turn = moved.topLeftCorner<3, 3>();
  Vector3d shift = moved.topRightCorner<3, 1>();
  if (turn.isApprox(Matrix3d::Identity(), 1e-12)) {
    turn.setIdentity();
    shift = to.rowwise().mean() - from.rowwise().mean();
  }
  const double size = std::max(from.cwiseAbs().maxCoeff(), to.cwiseAbs().maxCoeff());
  const double largestError = ((turn * from).colwise() + shift - to).cwiseAbs().maxCoeff();
  const double rounding = like.float32 ? 1e-6 : 1e-12;
  if (!(largestError <= rounding * size)) return nullptr;
  auto fitted = std::make_shared<LayerPose>(like);
  fitted->pose = turn * like.pose;
  fitted->pose.col(3) += shift;
  if (turn.isIdentity(0)) fitted->pose.leftCols<3>() = like.pose.leftCols<3>();
  return fitted;
}

class Bounds {
 public:
  explicit Bounds(std::optional<ChordBound>& worst) : worst_(worst) { worst_ = ChordBound{}; }

  /// False if the motion from one pose to the other is not rigid, such as in a mesh that was
  /// scaled along an axis.
  bool add(const Slab& slab, const LayerPose& from, const LayerPose& to) {
    const Matrix3d before = from.pose.leftCols<3>();
    const Matrix3d after = to.pose.leftCols<3>();
    if (from.float32 || to.float32) {
      // Half a unit in the last place along three axes, of the reference and of the result.
      constexpr double kRounding = 0x1p-23;
      double largest = 0;
      for (const model::Point3& point : *from.reference) {
        largest = std::max(largest, point.cwiseAbs().maxCoeff());
      }
      double moved = 0;
      for (const model::Point4& vertex : slab.vertices) {
        moved = std::max(moved, vertex.head<3>().cwiseAbs().maxCoeff());
      }
      rounding_ = std::max(rounding_, kRounding * (largest * before.norm() + moved));
      worst_->rounding = rounding_;
    }
    if (before == after) return true;  // a translation
    // Poses of a mesh that was scaled scale, too.
    const Matrix3d toSolid = before.inverse();
    const Matrix3d turn = after * toSolid;
    constexpr double kRigid = 1e-9;
    if (!((turn * turn.transpose()).isIdentity(kRigid) && turn.determinant() > 0)) return false;
    const Eigen::AngleAxisd angleAxis(turn);
    const Vector3d shift = to.pose.col(3) - turn * from.pose.col(3);
    const double half = angleAxis.angle() / 2;
    if (!(half > 0)) return true;
    // The axis of the screw from pose to pose goes through this point.
    const Vector3d across = shift - shift.dot(angleAxis.axis()) * angleAxis.axis();
    const Vector3d center =
        (across + angleAxis.axis().cross(across) * std::cos(half) / std::sin(half)) / 2;
    ChordBound here;
    here.angleRadians = angleAxis.angle();
    for (const model::Point4& vertex : slab.lowerLayer()) {
      const Vector3d arm = vertex.head<3>() - center;
      here.radius = std::max(here.radius, angleAxis.axis().cross(arm).norm());
    }
    // In a long screw the axis stays where it is in the solid.
    constexpr double kSameAxis = 1e-12;
    const Vector3d axisInSolid = toSolid * angleAxis.axis();
    if (connectivity_ != slab.connectivity || !axisInSolid.isApprox(axisInSolid_, kSameAxis)) {
      connectivity_ = slab.connectivity;
      axisInSolid_ = axisInSolid;
      edge_ = longestEdge(slab, angleAxis.axis());
    }
    here.edge = edge_;
    here.edgeFactor =
        slab.connectivity->means.size() > 0 ? model::kEdgeFactorOf14 : model::kEdgeFactorOf3;
    here.bound = here.forAngle(here.angleRadians);
    here.rounding = rounding_;
    if (here.bound > worst_->bound) worst_ = here;
    return true;
  }

 private:
  std::optional<ChordBound>& worst_;
  std::shared_ptr<const model::Connectivity> connectivity_;
  Vector3d axisInSolid_ = Vector3d::Zero();
  double edge_ = 0;
  double rounding_ = 0;
};

}  // namespace

Result<std::optional<ChordBound>> chordBound(const model::Source& source,
                                             const model::TimeSpan& span,
                                             const MotionBetweenLayers& motion,
                                             const model::Progress& progress) {
  std::optional<ChordBound> worst;
  if (!motion.isKnown) return worst;
  Bounds bounds(worst);
  std::shared_ptr<const LayerPose> before;
  for (std::size_t i = 0; i < source.slabCount(); ++i) {
    const model::TimeSpan own = source.timeSpan(i);
    if (own.begin >= span.end && own.end > own.begin) break;
    // Slabs before the span are read only to know where it begins.
    const bool next = i + 1 < source.slabCount() && source.timeSpan(i + 1).end > span.begin;
    if (own.end <= span.begin && !next) continue;
    const auto slab = source.slab(i);
    if (!slab) return slab.error();
    const auto& pose = (*slab)->upperPose;
    if (own.end > own.begin && own.end > span.begin) {
      // The first and the last layer of a part of a sweep are stated as they are.
      auto from = before;
      auto to = pose;
      if (!from && to) from = fittedPose((*slab)->lowerLayer(), *to);
      if (from && (!to || to->reference != from->reference)) {
        to = fittedPose((*slab)->upperLayer(), *from);
      }
      if (!from || !to) return std::optional<ChordBound>();
      if (!bounds.add(**slab, *from, *to)) return std::optional<ChordBound>();
    }
    before = pose;
    if (auto on = model::report(progress, i + 1, source.slabCount()); !on) return on.error();
  }
  if (worst && motion.bound) {
    worst->isStated = true;
    worst->bound = *motion.bound;
  }
  if (worst) worst->bound += worst->rounding;
  return worst;
}

}  // namespace t4d::measure
