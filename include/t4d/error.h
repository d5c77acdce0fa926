#pragma once

/// Results and errors of functions that can fail.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <tl/expected.hpp>

namespace t4d {

/// The kind of error; it determines the program's exit code.
enum class ErrorCode {
  InvalidInput,  ///< the data violates a requirement (exit 4)
  Io,            ///< a file cannot be opened or read (exit 4)
  Unsupported,   ///< valid, but beyond what this build or version can do (exit 4)
  Failed,        ///< a failure on valid input, or in writing the output (exit 1)
  Options,       ///< what was asked for cannot be done with this input (exit 2)
};

/// What a caller can change to avoid an error. Messages name no option and no verb; a program adds
/// its own wording for these.
enum class Remedy : std::uint8_t {
  None,
  OtherFormat,         ///< read the file as another format
  IsoValue,            ///< give an iso value: the grids hold densities
  FrameTime,           ///< give the time between frames: the grids have none
  GridName,            ///< choose a grid by its name: there are several
  ConeCaps,            ///< mend the triangle mesh, or close the ends with cones
  ConeCapsAlone,       ///< close the ends with cones: the mesh has been mended
  StepRule,            ///< allow larger steps
  Motion,              ///< change the motion: it is at fault, not the solid
  VoxelSize,           ///< choose voxels of another size
  VoxelSizeOrParts,    ///< choose larger voxels, or make the field in parts
  VoxelSizeOrOutside,  ///< choose others, or make an envelope that contains the motion for certain
  VoxelSizeOrExact,    ///< either of these, or make the envelope without voxels
  NotExact,            ///< make the envelope with voxels
  Center,              ///< write coordinates about the middle of the solid
  OtherBodies,         ///< choose other bodies
  MoreCells,           ///< allow more work than the size of the file suggests
  OpenMesh,            ///< merge vertices, or accept a mesh that is not closed
  Mend,                ///< mend the triangle mesh
  Remesh,              ///< mend it through voxels
  Thicken,             ///< give sheets a thickness
  RemeshSize,          ///< mend it through voxels of another size
  MaxHole,             ///< allow wider holes to be filled
  MaxMove,             ///< allow the surface to move farther
  Recover,             ///< close the 4D mesh, or merge its vertices
  FrameFormat,         ///< give frames of another format: the file has no grids
  MoreFrames,          ///< give two frames or more, or velocities that need no playback
  Units,               ///< convert one of two inputs, or ignore that their units or axes differ
  FieldParts,          ///< give files of parts of a field
  PartReports,         ///< give reports of parts
  EachTool,            ///< give each tool with its number
  AnyTool,             ///< give one tool for all numbers
  ToolTable,           ///< give the lengths of the tools
  Origin,              ///< give an origin in the frame of the stock
  MachineZero,         ///< give the zero of the machine in the frame of the stock
  RotaryAxis,          ///< say how the machine turns
  PlainGltf,           ///< write the glTF without compression
  GiveMotion,          ///< give a motion: the file has none
};

/// The place of an error. Members are empty where the caller knows them, or where they do not
/// apply.
struct Place {
  std::string file;        ///< as it was named: a path, a URL, or the name of an input
  std::uint64_t line = 0;  ///< of the file, from 1; 0 if there is none
  /// The place in the file or the mesh: `slab 3`, `byte 84`, `bodies[2].joint`; or the place in an
  /// inner file that the file names.
  std::string part;
  std::optional<std::uint64_t> key;  ///< of a motion, from 0, where `part` names it

  Place() = default;
  Place(std::string fileName, std::uint64_t lineNumber = 0)
      : file(std::move(fileName)), line(lineNumber) {}
  Place(const char* fileName) : file(fileName) {}
  Place(const std::filesystem::path& path) : file(path.string()) {}

  bool operator==(const Place&) const = default;
  bool empty() const { return file.empty() && line == 0 && part.empty(); }

  /// `file:line: part`, of those that there are.
  std::string text() const {
    const std::string begin = line == 0 ? file : file + ":" + std::to_string(line);
    if (begin.empty() || part.empty()) return begin + part;
    return begin + ": " + part;
  }
};

/// A part of a place. With no file, `placeIn({}, "slab 3")`, it is a part of what the caller knows.
[[nodiscard]] inline Place placeIn(Place place, const std::string& part) {
  place.part += place.part.empty() || part.empty() ? part : ": " + part;
  return place;
}

/// The place of a byte of a file, counted from 0.
[[nodiscard]] inline Place placeOfByte(Place file, std::uint64_t offset) {
  return placeIn(std::move(file), "byte " + std::to_string(offset));
}

/// Every public function that can fail returns one of these instead of throwing.
struct Error {
  ErrorCode code = ErrorCode::Failed;
  /// States what was found, what was expected, and what to do.
  std::string message = {};
  Place where = {};
  /// Byte offset in the file, if there is one.
  std::optional<std::uint64_t> offset = {};
  Remedy remedy = Remedy::None;
  /// Other errors found in the same run: those of other bodies or files.
  std::vector<Error> others = {};

  /// `where: message`, on one line.
  std::string text() const { return where.empty() ? message : where.text() + ": " + message; }
};

/// A value or an Error, of which either is returned as it is: a tl::expected with a compiler
/// warning if it is ignored.
template <class T>
class [[nodiscard]] Result : public tl::expected<T, Error> {
 public:
  using tl::expected<T, Error>::expected;
  Result(tl::expected<T, Error> other) : tl::expected<T, Error>(std::move(other)) {}
  Result(Error error) : tl::expected<T, Error>(tl::unexpect, std::move(error)) {}
  Result() = default;
  Result(const Result&) = default;
  /// Copies a variable. Without this, a Result<bool> would be converted to its value.
  Result(Result& other) : Result(std::as_const(other)) {}
  Result(Result&&) = default;
  Result& operator=(const Result&) = default;
  Result& operator=(Result&&) = default;
};

}  // namespace t4d

/// Lets and_then take functions that return a Result.
template <class T>
struct tl::detail::is_expected_impl<t4d::Result<T>> : std::true_type {};

namespace t4d {

[[nodiscard]] inline Error fail(ErrorCode code, std::string message, Place where = {},
                                Remedy remedy = Remedy::None) {
  return Error{code, std::move(message), std::move(where), {}, remedy, {}};
}

/// The first of one or more errors, with the others.
[[nodiscard]] inline Error allErrors(std::vector<Error> errors) {
  Error all = std::move(errors.front());
  for (std::size_t i = 1; i < errors.size(); ++i) all.others.push_back(std::move(errors[i]));
  return all;
}

[[nodiscard]] inline Error invalid(std::string message, Place where = {},
                                   Remedy remedy = Remedy::None) {
  return fail(ErrorCode::InvalidInput, std::move(message), std::move(where), remedy);
}

}  // namespace t4d
