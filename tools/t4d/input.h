#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <CLI/CLI.hpp>

#include "measure/chord_bound.h"
#include "t4d/file.h"
#include "t4d/mesh.h"

namespace t4d::tools {
/// The 4D meshes that a verb reads: bodies of a .t4d file, or of memory.
struct Input {
  std::string name;  ///< for messages
  formats::Metadata metadata;
  /// Some or all of those that `metadata` names.
  std::vector<model::Body> bodies;
  std::shared_ptr<formats::T4dReader> reader = nullptr;  ///< owns the bodies; null in memory
  /// Bodies that are parts of others.
  std::vector<std::shared_ptr<const model::Source>> parts = {};
};

/// The choice of bodies of a .t4d file.
struct InputOptions {
  std::vector<std::string> bodies = {};        ///< only the bodies of these names; none for all
  std::optional<std::uint64_t> maxCells = {};  ///< as T4dReader::open takes it

  /// Adds `--body` and `--max-cells`.
  void addTo(CLI::App& command);
};

/// Opens a .t4d file, a path or a URL. An unknown name of a body is an error that lists those that
/// there are.
Result<Input> openInput(const std::string& path, const InputOptions& options = {});

/// Into how many parts the bodies can be divided, such that some body has a slab in each; or, if
/// `ofEach`, each body.
std::uint64_t mostParts(const Input& input, bool ofEach = false);

/// The input with its bodies' share of slabs (model::Part::of): valid as long as `input`. Fails
/// (Options) if there are more parts than mostParts.
Result<Input> partOf(const Input& input, const model::Part& part, bool ofEach = false);

/// All slabs of these bodies.
std::uint64_t slabCountOf(std::span<const model::Body> bodies);

/// The metadata for a file that has only the bodies of this input; made by `generator`, a program
/// and its version. A body whose parent is not among them has none.
formats::Metadata metadataOf(const Input& input, std::string_view generator);

/// Keeps what may be kept of the chunks of the input that this version does not know, and finishes
/// the file, which has all bodies of the input. Returns its size in bytes.
Result<std::uint64_t> finishEdited(formats::T4dWriter& writer, const Input& input);

/// The error with the name of the input as its place, unless it has one.
Error inInput(Error error, const Input& input);

/// Fails (Remedy::Units) if lengths, times or up axes of two inputs mean different things.
Result<void> checkSameUnits(const Input& a, const Input& b);

/// The known facts about the motion of a body between two layers. In a sweep of an animation, nodes
/// may move along curves there.
measure::MotionBetweenLayers motionOf(const Input& input, const std::string& body);

/// Bounds in space of the bodies, at all times. Reads the slabs of a mesh in memory.
Result<model::Bounds3> boundsOf(const Input& input);

/// Help of an argument that takes a .t4d file as T4dReader::open does.
inline constexpr const char* kT4dFileHelp =
    "Input file (.t4d, .t4dm): path or URL (http://, https://)";

/// Added where it can be a pipe, too.
inline constexpr const char* kOrPipeHelp = ", or - for standard input";

/// Adds `--max-cells`.
void addMaxCellsOption(CLI::App& command, std::optional<std::uint64_t>& maxCells);

}  // namespace t4d::tools
