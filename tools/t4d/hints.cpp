#include "tools/t4d/hints.h"

#include <algorithm>
#include <filesystem>
#include <set>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "formats/file_extension.h"
#include "formats/mesh4d/mesh4d_formats.h"
#include "formats/t4d/salvage.h"
#include "formats/t4d/url.h"
#include "formats/triangle/triangle_mesh_formats.h"
#include "t4d/file.h"
#include "t4d/frames.h"
#include "tools/t4d/python_inputs.h"
#include "tools/t4d/shell_word.h"
#include "tools/t4d/t4d_file.h"
#include "tools/t4d/t4d_output.h"
#include "voxel4d/frame_formats.h"

namespace t4d::tools {
namespace {

namespace fs = std::filesystem;

/// How much of a file is searched for slabs, so that the hint appears at once.
constexpr std::uint64_t kSearchedBytes = std::uint64_t{256} << 20;

/// A path as one word of a shell command that is not mistaken for an option.
std::string quoted(std::string word) {
  if (word.starts_with('-')) word.insert(0, "./");
  return shellWord(word);
}

/// `PATH` with another suffix, such that no file of that name exists.
std::string freeName(const std::string& path, const std::string& suffix,
                     const std::string& extension) {
  std::string name = nameWithoutExtension(path);
  // Part files left behind are hidden.
  name.erase(0, name.find_first_not_of('.'));
  const std::string base = (fs::path(path).parent_path() / (name + suffix)).string();
  std::string free = base + extension;
  std::error_code ignored;
  for (int i = 2; fs::exists(free, ignored); ++i) free = fmt::format("{}-{}{}", base, i, extension);
  return quoted(free);
}

/// How to recover a damaged .t4d file; empty if no slab would be saved.
std::string recoveryHint(const std::string& path) {
  if (!formats::T4dSalvage::finds(path, kSearchedBytes)) return {};
  return fmt::format("try: t4d recover {} -o {}", quoted(path),
                     freeName(path, "-recovered", ".t4d"));
}

/// The hint for the extension of a file.
std::string exportHintFor(const std::string& extension) {
  struct Row {
    std::vector<std::string_view> extensions;
    const char* hint;
  };
  static const Row kRows[] = {
      {{".step", ".stp", ".iges", ".igs", ".brep", ".fcstd"},
       "it is a CAD model; in FreeCAD, mesh it and export it as .stl, .obj or .ply"},
      {{".xml", ".mjcf"},
       "a robot of MuJoCo (MJCF) is swept by Python: python3 -m t4d sweep robot.xml --motion "
       "joints.csv"},
      {{".sdf", ".world"},
       "a robot or world of Gazebo (SDF) is swept by Python: python3 -m t4d sweep robot.sdf "
       "--motion joints.csv"},
      {{".3mf", ".amf"}, "a program for 3D printing (a slicer) exports it as .stl"},
      {{".ma", ".mb", ".max", ".c4d", ".hip", ".lwo", ".3dm", ".skp"},
       "export it as glTF 2.0 (.glb), .fbx or .obj in the program that made it"}};
  for (const Row& row : kRows) {
    if (std::ranges::find(row.extensions, extension) != row.extensions.end()) return row.hint;
  }
  return {};
}

/// Animations and meshes that libraries of Python and Blender read.
std::string animationHint(const std::string& path) {
  const std::string extension = formats::lowerCaseExtension(path);
  static const std::set<std::string_view> kExtensions = {".fbx", ".dae",  ".abc",  ".blend",
                                                         ".usd", ".usda", ".usdc", ".usdz"};
  if (!kExtensions.contains(extension)) return {};
  return fmt::format("try: t4d-blender {} -o {}, or -o {} for the solid at rest", quoted(path),
                     freeName(path, "", ".t4d"), freeName(path, "", ".glb"));
}

/// A hint on converting a file of one kind to the required kind.
std::string conversionHint(const std::string& path) {
  const std::string extension = formats::lowerCaseExtension(path);
  if (std::string hint = exportHint(path); !hint.empty()) return hint;
  if (const std::string kind = pythonInput(path); !kind.empty()) {
    return fmt::format("it is {}; make a 4D mesh of frames: {} {} -o {}", kind, kPythonWeave,
                       quoted(path), freeName(path, "", ".t4d"));
  }
  const auto* format = formats::triangleMeshFormat(path);
  if (formats::mesh4dFormatOfFile(path) != nullptr) {
    return fmt::format("it is a 4D mesh in another format; convert it first: t4d convert {} {}",
                       quoted(path), freeName(path, "", ".t4d"));
  }
  if (format != nullptr) {
    return fmt::format(
        "it is a triangle mesh; sweep it first: t4d sweep {} --motion MOTION.json -o {}",
        quoted(path), freeName(path, "", ".t4d"));
  }
  if (extension == ".json" || extension == ".csv") {  // other tables of poses may be any text
    return fmt::format("if it is a motion, sweep a solid by it: t4d sweep SOLID --motion {} -o {}",
                       quoted(path), freeName(path, "", ".t4d"));
  }
  if (formats::isOneOf(voxel4d::vdbFormats(), path)) {
    return fmt::format("it is a VDB file; make a 4D mesh of frames: t4d weave {} -o {}",
                       quoted(path), freeName(path, "", ".t4d"));
  }
  if (voxel4d::isVolumeFile(path)) {
    return fmt::format("it is a volume; make a 4D mesh of frames: t4d weave {} -o {}", quoted(path),
                       freeName(path, "", ".t4d"));
  }
  const auto mesh = formats::T4dReader::open(path, formats::T4dOpen::Whole, {}, formats::kAnyCells);
  if (!mesh) return {};
  return fmt::format("it is a 4D mesh; slice it first: t4d slice {} --time {} -o {}", quoted(path),
                     mesh->summary(0).time.begin, freeName(path, "-slice", ".ply"));
}

/// How to mend the triangle mesh of an error; empty if it does not name the file.
std::string mendingHint(const std::string& path) {
  if (formats::triangleMeshFormat(path) == nullptr) return {};
  // An .obj keeps what a .ply has no room for, such as the names of materials.
  const char* extension = formats::lowerCaseExtension(path) == ".obj" ? ".obj" : ".ply";
  return fmt::format("t4d mend {} -o {}", quoted(path), freeName(path, "-mended", extension));
}

/// The file that an error refers to; empty if it refers to a part, such as a file that this one
/// names.
std::string fileOf(const Error& error) {
  return error.offset || error.where == error.where.file ? error.where.file : std::string();
}

}  // namespace

std::string exportHint(const std::string& path) {
  const std::string hint = animationHint(path);
  return hint.empty() ? exportHintFor(formats::lowerCaseExtension(path)) : hint;
}

std::string hintForFile(const std::string& path) {
  if (!formats::schemeOf(path).empty() || formats::isPipe(path)) return {};
  const std::string hint = recoveryHint(path);
  // What has the signature is a .t4d file, however damaged: nothing converts it.
  return hint.empty() && !formats::isT4d(path) ? conversionHint(path) : hint;
}

std::string hintFor(const Error& error) {
  switch (error.remedy) {
    case Remedy::OtherFormat: {
      const std::string file = fileOf(error);
      if (!formats::schemeOf(file).empty()) return {};
      const std::string hint = conversionHint(file);
      return hint.empty() ? recoveryHint(file) : hint;
    }
    case Remedy::IsoValue:
      if (formats::isOneOf(voxel4d::vdbFormats(), error.where.file)) {
        return "try: --iso VALUE, if the grids hold densities; inside is where they are above it";
      }
      return "try: --iso VALUE, if the samples are densities (inside is where they are above it), "
             "or --label N, if they are labels (inside is where they are exactly N)";
    case Remedy::FrameTime:
      return "try: --frame-time TIME, the time between two frames";
    case Remedy::GridName:
      return "try: --grid NAME, to use only grids of that name";
    case Remedy::ConeCaps: {
      const std::string hint = mendingHint(fileOf(error));
      return hint.empty() ? "try: --caps cone" : fmt::format("try: {}, or --caps cone", hint);
    }
    case Remedy::ConeCapsAlone:
      return "try: --caps cone";
    case Remedy::Mend: {
      const std::string hint = mendingHint(fileOf(error));
      return hint.empty() ? hint : "try: " + hint;
    }
    case Remedy::Remesh:
      return "try: --remesh SIZE, to make a new surface from voxels of that size";
    case Remedy::Thicken:
      return "try: --thicken DISTANCE, to give sheets a thickness";
    case Remedy::RemeshSize:
      return "try: another --remesh";
    case Remedy::MaxHole:
      return "try: a larger --max-hole";
    case Remedy::MaxMove:
      return "try: a larger --max-move";
    case Remedy::StepRule:
      return "try: --steps N, the number of steps of each segment, or a larger --max-steps";
    case Remedy::VoxelSize:
      return "try: another --voxel-size";
    case Remedy::VoxelSizeOrParts:
      return "try: another --voxel-size, or --part K/N, to make parts of the fields";
    case Remedy::VoxelSizeOrOutside:
      return "try: another --voxel-size, or --outside, which needs no voxels as small";
    case Remedy::VoxelSizeOrExact:
      return "try: another --voxel-size, or --exact or --outside, which need no voxels as small";
    case Remedy::NotExact:
      return "try: without --exact, to find it on a lattice";
    case Remedy::Center:
      return "try: --center, to write coordinates about the middle";
    case Remedy::MoreCells:
      return "try: --max-cells N, if the file is worth the work";
    case Remedy::OpenMesh:
      return "try: --weld DISTANCE, if vertices are doubled, or --allow-open";
    case Remedy::Recover:
      return "try: t4d recover, which closes an open mesh, or t4d convert --weld DISTANCE, if "
             "vertices are doubled";
    case Remedy::Units:
      return "try: t4d transform --scale FACTOR --length-unit NAME, --time-scale FACTOR "
             "--time-unit "
             "NAME, or --rotate 1 0 0 90 --up AXIS, to convert one of them; or --ignore-units, to "
             "take the numbers as they are";
    case Remedy::FieldParts:
      return "try: files that t4d envelope writes with --part K/N";
    case Remedy::PartReports:
      return "try: reports that verbs print with --part K/N --json";
    case Remedy::EachTool:
      return "try: --tool N=SPEC, for each tool N";
    case Remedy::AnyTool:
      return "try: --tool SPEC without a number, to mill with one tool, whatever is mounted";
    case Remedy::ToolTable:
      return "try: --tool-table FILE, which has the lengths of tools";
    case Remedy::Origin:
      return "try: --offset ORIGIN=x,y,z, as in --offset G55=100,0,-20";
    case Remedy::MachineZero:
      return "try: --offset G53=x,y,z, the machine's zero in the frame of the stock";
    case Remedy::RotaryAxis:
      return "try: --rotary AXIS=table:x,y,z or AXIS=head:x,y,z, as in --rotary A=table:0,0,0";
    case Remedy::PlainGltf: {
      const std::string file = error.where.file;
      if (!formats::schemeOf(file).empty()) return {};
      return fmt::format("try: gltf-transform copy {} {}, which writes it without compression",
                         quoted(file), freeName(file, "-plain", ".glb"));
    }
    case Remedy::GiveMotion:
      return "try: --motion FILE, to move it as a whole";
    case Remedy::OtherBodies:
    case Remedy::Motion:
    case Remedy::FrameFormat:
    case Remedy::MoreFrames:
    case Remedy::None:
      break;
  }
  if (std::string hint = exportHint(error.where.file); !hint.empty()) return hint;
  const bool damaged = error.code == ErrorCode::InvalidInput && error.offset;
  return damaged ? recoveryHint(fileOf(error)) : std::string();
}

}  // namespace t4d::tools
