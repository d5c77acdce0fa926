#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "formats/t4d/body_details.h"
#include "measure/clearance_over_time.h"
#include "measure/collision_verdict.h"
#include "t4d/collide.h"
#include "t4d/mesh.h"
#include "tools/t4d/input.h"
#include "tools/t4d/observer.h"

namespace t4d::tools {

class Members;

/// Two bodies by their names.
using BodyNames = std::array<std::string, 2>;

struct CollideOptions {
  std::optional<double> clearance = {};  ///< a distance that is to be kept, in length units
  bool ignoreUnits = false;              ///< take numbers as they are where units differ
  std::vector<BodyNames> ignore = {};    ///< pairs of bodies that are not tested, in either order
  /// Also test bodies of one input that are joined: parts of one link (formats::linkOf), or of two
  /// of which one is the parent of the other (formats::BodyInfo::parent).
  bool adjacent = false;
  /// Measure overlaps; without it, their volumes and deepest times are not known.
  bool overlapVolumes = true;
  std::vector<double> times = {};  ///< of CollidedPair::samples
  model::Part part = {};           ///< the share of the pairs that is tested
};

/// Two bodies, and whether they meet.
struct CollidedPair {
  model::Body a;
  model::Body b;
  std::array<measure::MotionBetweenLayers, 2> motions = {};  ///< of a and of b
  measure::Collision collision = {};
  measure::CollisionVerdict verdict = {};
  std::optional<measure::ClearanceVerdict> clearance = {};  ///< with CollideOptions::clearance
  std::vector<measure::ClearanceSample> samples = {};       ///< at CollideOptions::times

  /// Whether the clearance is kept for certain, or none was asked for.
  bool keepsClearance() const;
  /// Whether they meet, or cannot be told not to, or may be nearer than the clearance.
  bool mayMeet() const;
  /// The steps that decide what is open, as mesh4d::MinVolumeRatio; nothing if no steps do.
  std::optional<double> decidingVolumeRatio() const;
  std::optional<std::uint64_t> decidingStepsPerTurn() const;  ///< as steps
  std::optional<double> decidingDeviation() const;            ///< as mesh4d::MaxDeviation
};

/// A body that was reshaped before it was swept: what is found is about the solid in the file.
struct MendedOfFile {
  std::string file;
  std::string body;
  formats::MendedInfo info;
};

/// The changes made in at least one body, as a sentence without a full stop.
std::string noticeOf(std::span<const MendedOfFile> mended);

struct CollideReport {
  std::vector<CollidedPair> pairs;                ///< not empty
  std::vector<BodyNames> ignored;                 ///< those that were not tested
  bool overlapVolumes = true;                     ///< they were measured
  std::vector<MendedOfFile> mended = {};          ///< of bodies that were tested
  std::vector<formats::JointCourse> joints = {};  ///< of all inputs

  bool mayMeet() const;
};

/// Whether moving solids touch or overlap, when, and how near they come (measure::collide): each
/// body of the first input with each of the second or, of one input, each with each. The pairs are
/// valid as long as the inputs. Fails for two inputs with different units or up axes, unless they
/// are ignored, for a single body, and if all pairs are ignored.
Result<CollideReport> collide(std::span<const Input> inputs, const CollideOptions& options = {},
                              Observer& observer = nobody());

/// The number of pairs that `collide` tests, which is the most parts that it can be divided into.
std::uint64_t pairCount(std::span<const Input> inputs, const CollideOptions& options);

/// A table of CollidedPair::samples, with the columns
/// time,a,b,distance,lower_bound,overlap_depth: by time, and at a time in the order of the pairs.
std::string clearanceCsv(const CollideReport& report);

/// The samples as JSON: for each pair its names and `samples`.
std::string clearanceJson(const CollideReport& report);

void describe(Members& members, const CollideReport& report);

/// Two solids at a time.
struct ContactView {
  double time = 0;
  model::TriangleMesh a;
  model::TriangleMesh b;
  /// For each triangle, whether it is in contact, up to rounding.
  std::vector<bool> contactA;
  std::vector<bool> contactB;
};

/// The solids of a pair at their first contact or, without one, when they are nearest; nothing if
/// they never exist at the same time.
Result<std::optional<ContactView>> contactView(const CollidedPair& pair);

/// Writes the view of the pair that meets first or, without any contact, comes nearest, with
/// contacts in red, in any of formats::writableTriangleMeshExtensions. `metadata` is that of the
/// first input. Returns what the format cannot hold.
Result<std::vector<std::string>> writeContacts(const CollideReport& report,
                                               const formats::Metadata& metadata,
                                               const std::string& path,
                                               Observer& observer = nobody());

}  // namespace t4d::tools
