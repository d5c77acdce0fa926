#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "t4d/file.h"
#include "tools/t4d/observer.h"

namespace t4d::tools {

class Members;

/// The id of .t4d, which is none of formats::mesh4dFormats.
inline constexpr std::string_view kT4dFormat = "t4d";

/// Formats are named by their ids: kT4dFormat, or those of formats::mesh4dFormats.
struct ConvertOptions {
  std::string input = {};   ///< a path; of a .t4d also a URL
  std::string output = {};  ///< the file to write
  std::string from = {};    ///< format of the input; "" for what its content tells
  std::string to = {};      ///< format of the output; "" for what its extension tells
  /// Number of slabs to cut each body into, where its vertices have enough different times;
  /// tetrahedra are split. Without it, a body for a .t4d is cut where none is split. Not for a
  /// .t4d as input, which has slabs.
  std::optional<std::uint64_t> slabs = {};
  /// The tolerance edit::Mend4dOptions::weld. Not for a .t4d as input, which is not mended.
  std::optional<double> weld = {};
  bool allowOpen = false;                      ///< as edit::Mend4dOptions::allowOpen
  std::optional<std::uint64_t> maxCells = {};  ///< of a .t4d, as T4dReader::open takes it
  std::string generator =
      {};  ///< program and version, for the metadata of an input other than .t4d
};

struct ConvertReport {
  std::string from;     ///< format of the input
  std::string dialect;  ///< as formats::LoadedMesh4d
  std::string to;       ///< format of the output
  std::uint64_t bodies = 0;
  std::uint64_t vertices = 0;  ///< of all bodies; those on a seam counted once
  std::uint64_t tetrahedra = 0;
  bool closed = true;  ///< all bodies; where not, or not oriented, slices and volumes mean nothing
  bool oriented = true;
  double seconds = 0;  ///< with reading and writing
  std::vector<std::string> losses = {};
  /// Changes made in reading, mending and cutting, a sentence each.
  std::vector<std::string> notices = {};
};

/// Whether the input is read as .t4d: by `from`, or else by its name or content.
bool isFromT4d(const ConvertOptions& options);

/// The format to write: `to`, or else by the extension; "" if none that is written has it.
std::string formatToWrite(const ConvertOptions& options);

/// Writes a 4D mesh in another format. A mesh without slabs is mended (edit::mendMesh4d) and cut
/// into slabs (edit::cutIntoSlabs); a .t4d is checked first. Errors name the file and body at
/// fault. Fails for an input that is open or cannot be oriented, unless that is allowed; and
/// (Options) if the output is a file that is read, for a format that is not read or not written,
/// and for options that a .t4d as input excludes.
Result<ConvertReport> convert(const ConvertOptions& options, Observer& observer = nobody());

void describe(Members& members, const ConvertReport& report);

}  // namespace t4d::tools
