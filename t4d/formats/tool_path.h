#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "t4d/model/error.h"
#include "t4d/model/motion.h"
#include "t4d/model/times.h"

namespace t4d::formats {

/// How a cutting tool moves: its tip is the origin of the tool, which points along +z from there.
struct ToolPath {
  model::Motion motion;                 ///< in mm and s
  std::vector<model::TimeSpan> rapids;  ///< moves that must not cut
  std::size_t moves = 0;                ///< in the file; an arc is one
  std::vector<std::string> notices;     ///< one sentence each
};

struct ToolPathOptions {
  double tolerance = 0.01;    ///< mm; the farthest that chords of arcs are from them
  double rapidFeed = 10'000;  ///< mm/min
};

/// Builds a tool path from moves that are straight for the tip, while the tool turns evenly about
/// it by the smallest angle.
class ToolPathBuilder {
 public:
  bool started() const { return started_; }
  const model::Point3& tip() const { return tip_; }

  /// `axis` is the direction from the tip to the shank; any length but zero.
  void start(const model::Point3& tip, const Eigen::Vector3d& axis = Eigen::Vector3d::UnitZ());

  /// In `seconds`; none, and no way, is no move. Fails for more segments than a motion can have,
  /// and if the tool would turn by half a turn, which could be any way round.
  Result<void> moveTo(const model::Point3& tip, const Eigen::Vector3d& axis, double seconds,
                      bool rapid);
  Result<void> moveTo(const model::Point3& tip, double seconds, bool rapid) {
    return moveTo(tip, axis_, seconds, rapid);
  }

  /// The angle in degrees from the present axis to another one.
  double turnTo(const Eigen::Vector3d& axis) const;

  /// Fails if nothing moved.
  Result<ToolPath> finish();

  ToolPath path;  ///< of which `moves` and `notices` are the caller's

 private:
  bool started_ = false;
  double time_ = 0;
  model::Point3 tip_ = model::Point3::Zero();
  Eigen::Vector3d axis_ = Eigen::Vector3d::UnitZ();
  model::Pose pose_;
};

}  // namespace t4d::formats
