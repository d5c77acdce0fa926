#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "formats/input_file.h"
#include "formats/t4d/body_details.h"
#include "model/mechanism.h"
#include "t4d/error.h"
#include "t4d/surface.h"

namespace t4d::formats {

/// A solid of a mechanism.
struct MechanismSolid {
  std::string name;  ///< no other solid of the mechanism has it
  std::size_t link = 0;
  model::Pose place = {};  ///< of the mesh in the world, while the mechanism is at rest
  model::TriangleMesh mesh = {};
  Place where = {};  ///< the file of the mesh, or what describes it, for messages
};

struct LoadedMechanism {
  model::Mechanism mechanism;
  std::vector<MechanismSolid> solids;  ///< at least one
  std::string lengthUnit;
  std::string timeUnit;
  std::string up;                                 ///< "" if unknown
  std::vector<JointCourse> joints;                ///< with a value, in units of the file
  std::vector<model::HalfTurn> halfTurns;         ///< of poses; `between` says whose
  std::vector<std::string> notices;               ///< for the user, a sentence each
  std::vector<std::string> losses;                ///< as LoadedMesh::losses
  std::vector<std::filesystem::path> otherFiles;  ///< that were read besides the one named
};

/// Reads a mechanism (docs/mechanism.md; JSON Schema in formats/motion/mechanism.schema.json):
/// bodies with their solids, joints and motions, and robots (urdf_reader.h). Files that it names
/// are relative to its folder.
///
/// Fails, with the member, on what the schema does not allow, bodies of one name, parents that do
/// not exist or hang on each other, motions that do not fit their joint, solids that cannot be
/// read, columns that a table does not have, and values whose unit is not known. Values beyond the
/// limits of a joint are a notice.
Result<LoadedMechanism> readMechanism(const std::filesystem::path& path);
Result<LoadedMechanism> readMechanism(const InputFile& file);

/// Adds the links, solids and joints of another mechanism in the same units, whose names get `name`
/// and a blank before them, unless it is "". Its links without a parent hang on the link `parent`.
/// Returns a name of a solid that there is already, or "".
std::string addMechanism(LoadedMechanism more, const std::string& name, std::size_t parent,
                         LoadedMechanism& into);

/// The most bodies of a mechanism, or links of a robot.
inline constexpr std::size_t kMostLinks = 4096;

/// Reads the mesh of a solid, and collects its notices.
Result<model::TriangleMesh> readSolid(const std::filesystem::path& path, MechanismSolid& solid,
                                      LoadedMechanism& into);

/// Describes values that are beyond the limits of a joint; empty if none is. `values` and the
/// limits have the unit that is named.
std::string noticeOfLimits(const std::string& joint, std::span<const double> times,
                           std::span<const double> values, double lower, double upper,
                           const std::string& unit);

/// An order in which each link comes after its parent; kWorld is not a parent. If the parents form
/// a cycle, `cycle` gets the numbers of the links in one.
std::vector<std::size_t> parentsFirst(std::span<const std::size_t> parents,
                                      std::vector<std::size_t>& cycle);

}  // namespace t4d::formats
