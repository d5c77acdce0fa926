#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "formats/gltf/gltf_animation.h"
#include "formats/motion/mechanism_reader.h"
#include "t4d/file.h"
#include "t4d/motion.h"
#include "t4d/surface.h"
#include "t4d/weave.h"
#include "tools/t4d/observer.h"
#include "tools/t4d/sweep.h"
#include "tools/t4d/t4d_file.h"

/// The parts of sweep: reading, and sweeping by a motion or through keys.
namespace t4d::tools {

/// Solids that move by one motion.
struct SolidsInMotion {
  std::vector<formats::NamedMesh> solids;
  model::Motion motion;
};

/// Bodies whose vertices have keys.
struct BodiesWithKeys {
  std::shared_ptr<const formats::LoadedMechanism> mechanism = {};  ///< that the keys refer to
  std::vector<formats::AnimatedBody> bodies = {};
  std::vector<std::filesystem::path> keyFiles = {};  ///< as formats::LoadedDeformation
};

/// The moving solids, as read from files.
struct SweepInput {
  std::variant<SolidsInMotion, BodiesWithKeys> moving;
  std::vector<formats::BodyInfo> infos = {};  ///< of bodies with names; empty for one without
  std::string bodyWord = {};                  ///< what these bodies are in the input, plural
  std::optional<double> chordBound = {};      ///< of a mechanism
  std::vector<model::HalfTurn> halfTurns = {};
  std::string lengthUnit = {};
  std::string timeUnit = {};
  std::string up = "y";
  double voxelSize = 0;  ///< of a union
  std::vector<std::string> losses = {};
  std::vector<std::string> otherAnimations = {};  ///< as formats::AnimatedScene
  std::vector<std::string> files = {};            ///< all that were read
  std::vector<formats::JointCourse> joints = {};  ///< of a mechanism
  std::vector<MendedBody> mended = {};      ///< in the order of the bodies; empty without mending
  std::vector<std::string> materials = {};  ///< the names that the attribute `material` numbers
};

/// The observer gets the notices of files.
Result<SweepInput> readSweepInput(const SweepOptions& options, Observer& observer);

/// Mends, divides and unites bodies as the options say, and names those that are divided. The
/// observer gets the notices of mending. If several bodies cannot be mended, the error has those of
/// the others.
Result<void> makeSolids(const SweepOptions& options, SweepInput& input, Observer& observer);

/// The file of the solid, or the first one.
const std::string& modelOf(const SweepOptions& options);

/// The files that the options name.
std::vector<std::string> namedFilesOf(const SweepOptions& options);

/// The data on how the file was made, for its metadata: JSON.
std::string sweepDetails(const SweepOptions& options, const SweepInput& input);

/// Options of the mesh method.
mesh4d::SweepOptions meshMethodOf(const SweepOptions& options);

/// The fault of a solid as the mesh method takes it, at its place; nothing if it is sound.
std::optional<Error> faultOf(const model::TriangleMesh& solid, const SweepOptions& options,
                             const Place& where);

/// Sweeps each solid into a body of the file.
Result<SweepReport> sweepByMotion(const SweepOptions& options, const SweepInput& input,
                                  T4dFile& file, Observer& observer);

/// Weaves the solid at these times.
Result<SweepReport> sweepByVoxels(const VoxelMethod& how, voxel4d::SolidAtTime solid,
                                  std::vector<double> times, model::Sink& sink, Observer& observer);

/// Sweeps the union of all bodies into the one body of the file.
Result<SweepReport> sweepUnion(const SweepOptions& options, const SweepInput& input, T4dFile& file,
                               Observer& observer);

/// Sweeps each body with its keys into one of the file.
Result<SweepReport> sweepThroughKeys(const SweepOptions& options, const SweepInput& input,
                                     T4dFile& file, Observer& observer);

}  // namespace t4d::tools
