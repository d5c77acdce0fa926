#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "formats/animation/deformation_reader.h"
#include "formats/motion/package_path.h"
#include "formats/triangle/mesh_bodies.h"
#include "t4d/edit.h"
#include "t4d/motion.h"
#include "t4d/sweep.h"
#include "t4d/weave.h"
#include "tools/t4d/mending.h"
#include "tools/t4d/observer.h"
#include "tools/t4d/t4d_file.h"
#include "voxel4d/frame_spacing.h"

namespace t4d::tools {

class Members;

/// The voxel method instead of the mesh method: frames of voxels, woven.
struct VoxelMethod {
  double voxelSize = 1;  ///< in length units
  /// The default is enough frames that no point moves by more than a voxel between two.
  voxel4d::FrameTimes times = {};
  bool mask = false;  ///< masks of inside points, not level sets
  voxel4d::Between between = voxel4d::Between::Distance;
  voxel4d::CapStyle caps = voxel4d::CapStyle::Flat;
  /// Given options that only the mesh method uses; named in a notice.
  std::vector<std::string> ignored = {};
};

/// A solid along a motion.
struct MotionSweep {
  std::string solid;                             ///< a triangle mesh
  std::string motion;                            ///< .json, or a table of poses
  formats::MotionTableOptions table = {};        ///< for a table
  std::optional<formats::BodiesBy> bodies = {};  ///< of an .obj; nothing for one body
  mesh4d::StepRule steps = {};                   ///< of the mesh method
  std::optional<VoxelMethod> voxels = {};
  std::uint64_t maxSteps = mesh4d::kMaxSteps;
};

/// A solid that is deformed: meshes of the same triangles, their collection (.pvd), or a mesh and
/// its point cache.
struct DeformationSweep {
  std::vector<std::string> files;
  formats::KeyTimes times = {};
};

/// An animated glTF file: a body for each node.
struct AnimationSweep {
  std::string file;
  std::string animation = {};            ///< as formats::GltfAnimationOptions
  std::string scene = {};                ///< as formats::GltfAnimationOptions
  std::optional<double> tolerance = {};  ///< as formats::GltfAnimationOptions, in length units
};

/// A mechanism (.json), or a robot (.urdf) and a table of its joints: a body for each solid.
struct MechanismSweep {
  std::string file;
  std::string motion = {};    ///< of a .urdf alone
  std::string geometry = {};  ///< of a .urdf alone, as formats::UrdfOptions; "" for the default
  mesh4d::StepRule steps = {};
  bool ownSteps = false;                       ///< as mesh4d::mechanismKeys without `common`
  std::optional<std::uint64_t> maxSteps = {};  ///< as mesh4d::mechanismKeys
  /// The use of convex hulls. Nothing means a Hull::Fallback that nobody asked for: each hull is a
  /// loss. So is what is mended without SweepOptions::mending.
  std::optional<Hull> hull = {};
  formats::Packages packages = {};  ///< of a .urdf alone, as formats::UrdfOptions
};

/// The ways in which files are swept, by their names.
enum class SweepKind : std::uint8_t { Motion, Deformation, Animation, Mechanism };

/// The kind of a sweep of at least one file; `motion` is "" if there is none.
SweepKind sweepKindOf(std::span<const std::string> files, const std::string& motion);

/// The maximum number of frames of a union, unless a number or a time between them is given.
inline constexpr std::uint64_t kUsualFrames = 300;

/// One solid of all bodies of a deformation or an animation, which may overlap, by the voxel
/// method.
struct VoxelUnion {
  /// The edge length of a voxel; without it, a hundredth of the largest extent at the first time.
  std::optional<double> voxelSize = {};
  /// The default is enough frames that no vertex moves by more than a voxel between two, but no
  /// more than kUsualFrames.
  voxel4d::FrameTimes times = {};
  voxel4d::CapStyle caps = voxel4d::CapStyle::Flat;
};

struct SweepOptions {
  std::variant<MotionSweep, DeformationSweep, AnimationSweep, MechanismSweep> what;
  /// Mends solids first; nothing for solids as they are, but for mechanisms, which are mended in
  /// any case. Of deformations and animations no vertex can be moved: without `remesh` and
  /// `maxMove`; with cones, triangles may cross.
  std::optional<edit::MendSurfaceOptions> mending = {};
  /// Makes each connected component of deformations and animations a body (edit::divideSolids).
  bool components = false;
  std::optional<VoxelUnion> united = {};  ///< of deformations and animations, without components
  // Options of the mesh method, as in mesh4d::SweepOptions.
  mesh4d::CapMethod caps = mesh4d::CapMethod::TetGen;
  mesh4d::PrismSplit prism = mesh4d::PrismSplit::Fourteen;
  model::Part part = {};  ///< of one body that is not centred
  T4dFileOptions output = {};
};

struct SweptBody {
  std::string name;
  std::uint64_t vertices = 0;
  std::uint64_t tetrahedra = 0;
  std::uint64_t steps = 0;
  std::uint64_t runs = 1;                ///< as formats::AnimatedBody
  std::optional<double> tolerance = {};  ///< as formats::AnimatedBody
};

/// Something found in a step; `body` is "" if there is but one.
template <class Found>
struct FoundInBody {
  std::string body;
  Found found;
};

/// The folds of mesh4d::SweepReport, of all bodies together.
struct SweepFolds {
  std::uint64_t prisms = 0;
  std::uint64_t steps = 0;
  std::vector<FoundInBody<mesh4d::Fold>> first = {};  ///< up to mesh4d::kMostFolds
};
struct SweepCrossings {
  std::uint64_t pairs = 0;
  std::uint64_t steps = 0;
  std::uint64_t unfinishedSteps = 0;
  std::vector<FoundInBody<mesh4d::StepCrossing>> first = {};  ///< up to mesh4d::kMostFolds
};

struct SweepReport {
  std::uint64_t vertices = 0;
  std::uint64_t tetrahedra = 0;
  std::uint64_t steps = 0;
  std::array<std::uint64_t, 2> capTetrahedra = {0, 0};  ///< at start and end
  /// No point of a slice is farther from the true solid at that time, nor the other way round, in
  /// length units. Only for the mesh method, with a motion or a mechanism.
  std::optional<double> chordBound = {};
  std::optional<double> tolerance = {};  ///< of an animation: the largest of all bodies
  std::vector<SweptBody> bodies = {};    ///< if they have names: not for one solid alone
  std::vector<model::HalfTurn> halfTurns = {};
  /// Only without a motion; `crossings` are nothing if they were not searched for.
  std::optional<SweepFolds> folds = {};
  std::optional<SweepCrossings> crossings = {};
  std::vector<MendedBody> mended = {};   ///< empty if none was to be mended
  std::optional<double> voxelSize = {};  ///< of a union, in length units
  std::uint64_t bytes = 0;               ///< of the file
  double seconds = 0;                    ///< with reading and writing
  std::vector<std::string> losses = {};
  std::vector<std::string> otherAnimations = {};  ///< as formats::AnimatedScene
  /// Notices of sweeping, a sentence each. Those of the files that were read went to the observer.
  std::vector<std::string> notices = {};
};

/// Reads files, sweeps them, and writes a .t4d file with a body for each of theirs. Errors name the
/// file that is at fault; the first has those of other bodies (Error::others). Fails (Options) if
/// the output is one of the files that are read, and if one name is given for several bodies.
Result<SweepReport> sweep(const SweepOptions& options, Observer& observer = nobody());

/// The options nearest to these, for the same deformation or animation, with which all its bodies
/// can be swept: with mending, components, cones, or a thickness for sheets. Nothing if none of
/// them helps, or these do. Reads the files again.
std::optional<SweepOptions> workingOptions(const SweepOptions& options);

void describe(Members& members, const SweepReport& report);

}  // namespace t4d::tools
