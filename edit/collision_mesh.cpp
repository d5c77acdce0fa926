#include "edit/collision_mesh.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "edit/reduce_surface.h"
#include "edit/surface_crossings.h"
#include "measure/enclosure.h"
#include "model/progress.h"
#include "model/surface_check.h"
#include "t4d/check.h"

namespace t4d::edit {
namespace {

using measure::Silhouette;
using model::TriangleMesh;

/// The most envelopes that are reduced.
constexpr int kRounds = 8;

/// Whether a surface bounds a solid; without CGAL, regardless of triangles that cross.
Result<bool> isSimple(const TriangleMesh& mesh) {
  if (!model::checkClosedSurface(mesh)) return false;
  if (!findsCrossings()) return true;
  const auto crossings = findCrossings(mesh, 1);
  if (!crossings) return crossings.error();
  return crossings->none();
}

/// Reduces a surface to one that does not cross itself: with fewer triangles if need be or, where
/// that does not help, with more. Nothing if none is found.
Result<std::optional<ReducedSurface>> simpleReduction(const TriangleMesh& mesh,
                                                      std::size_t triangles) {
  constexpr int kTries = 12;
  constexpr double kFewer = 0.97;
  constexpr double kMore = 1.3;
  for (const double factor : {kFewer, kMore}) {
    auto goal = static_cast<double>(triangles);
    for (int k = 0; k < kTries; ++k, goal *= factor) {
      ReducedSurface reduced = reducedSurface(mesh, static_cast<std::size_t>(goal));
      const auto simple = isSimple(reduced.mesh);
      if (!simple) return simple.error();
      if (*simple) return reduced;
    }
  }
  return std::optional<ReducedSurface>();
}

/// The distances by which an envelope is made larger before it is reduced, so that what is left is
/// outside, and hardly farther than need be.
class Allowance {
 public:
  double value() const { return value_; }

  /// The next one, after a mesh that keeps `kept` of `needed`, or cuts in with 0. `step` is about
  /// what reducing moves. False if that is good enough.
  bool tryNext(double kept, double needed, double step) {
    if (kept < needed) {
      tooSmall_ = std::max(tooSmall_, value_);
      const double more = kept > 0 ? 1.1 * (needed - kept) : std::max(step, value_ / 2);
      value_ = enough_ ? (tooSmall_ + *enough_) / 2 : value_ + more;
    } else {
      enough_ = value_;
      constexpr double kNear = 0.1;
      const double less = value_ - (kept - needed);
      if (value_ - std::max(less, tooSmall_) < kNear * value_) return false;
      value_ = less > tooSmall_ ? (less + value_) / 2 : (tooSmall_ + value_) / 2;
    }
    return true;
  }

 private:
  double value_ = 0;
  double tooSmall_ = 0;
  std::optional<double> enough_;
};

/// The smallest mesh that is found which encloses the silhouette at a distance of the reach and of
/// what coordinates are off; nothing if none is.
Result<std::optional<Envelope>> closestEnclosing(const Silhouette& silhouette,
                                                 EnvelopeOptions options, std::size_t triangles,
                                                 const model::Progress& progress) {
  const double reach = *options.reach;
  const double needed = reach + roundingOfComputing(silhouette.surface);
  options.defaultSeconds /= kRounds / 2;
  const measure::EnclosedPlaces places(silhouette.surface);
  Allowance allowance;
  std::optional<Envelope> best;
  for (int round = 0; round < kRounds; ++round) {
    options.reach = reach + allowance.value();
    auto envelope =
        envelopeOf(silhouette, options,
                   model::partOf(progress, round / double(kRounds), (round + 1) / double(kRounds)));
    if (!envelope) return envelope.error();
    auto reduced = simpleReduction(envelope->mesh, triangles);
    if (!reduced) return reduced.error();
    double kept = 0;
    if (*reduced) kept = places.margin((*reduced)->mesh, needed + allowance.value());
    if (kept >= needed) {
      envelope->mesh = std::move((*reduced)->mesh);
      best = std::move(*envelope);
    }
    const double step = *reduced ? (*reduced)->error : envelope->voxelSize;
    if (!allowance.tryNext(kept, needed, step)) break;
  }
  return best;
}

}  // namespace

Result<Envelope> collisionMeshOf(const Silhouette& silhouette, EnvelopeOptions options,
                                 std::size_t triangles, const model::Progress& progress) {
  if (!reducesSurfaces()) {
    return fail(ErrorCode::Unsupported,
                "this build has no meshoptimizer, which meshes of few triangles need");
  }
  if (silhouette.surface.triangles.empty()) return Envelope{};
  auto found = closestEnclosing(silhouette, std::move(options), triangles, progress);
  if (!found) return found.error();
  if (!*found) {
    return fail(ErrorCode::Failed,
                fmt::format("no mesh of {} triangles was found that contains the motion; allow "
                            "more triangles",
                            triangles));
  }
  Envelope& best = **found;
  constexpr double kTolerance = 2e-4;
  best.errorBound = measure::farthestFrom(best.mesh, silhouette.surface, kTolerance);
  measureParts(best);
  if (best.mesh.triangles.size() > triangles) {
    best.losses.push_back(
        fmt::format("the mesh has {} triangles, more than {}: no fewer were found "
                    "for a surface of this shape",
                    best.mesh.triangles.size(), triangles));
  }
  if (auto on = model::report(progress, 1); !on) return on.error();
  return std::move(best);
}

}  // namespace t4d::edit
