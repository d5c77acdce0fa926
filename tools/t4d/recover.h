#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "formats/t4d/salvage.h"
#include "t4d/edit.h"
#include "tools/t4d/validation.h"

namespace t4d::tools {

class Members;

struct RecoverOptions {
  std::string generator = {};  ///< program and version, for the file's metadata
};

/// A layer of a recovered body that was closed by a cap.
struct RecoverCap {
  std::string body;
  edit::RunEnd end;
};

struct RecoverReport {
  std::string input;   ///< as it was given
  std::string output;  ///< as it was given
  std::uint64_t slabsSaved = 0;
  std::optional<std::uint64_t> slabsKnown;  ///< see formats::T4dSalvage
  bool metadataSaved = false;
  /// Ordered by offset: the losses of the file, layers that stay open and, if the file was not
  /// damaged, caps added because the mesh was open. Empty if the file was valid and closed.
  std::vector<formats::T4dLoss> lost;
  std::vector<RecoverCap> closed;
  /// The validation of the written file; empty if no slab could be saved, in which case no file was
  /// written.
  std::optional<Validation> validation;
};

/// Writes the intact slabs of a damaged or truncated .t4d (formats::T4dSalvage) to `output`, with
/// their numbers unchanged; closes the mesh where slabs are missing (edit::RunCloser); and
/// validates the result. The details of the metadata get a member "recovered" that names the origin
/// of the data. Fails if `input` is not a .t4d file or `output` cannot be written.
Result<RecoverReport> recover(const std::filesystem::path& input,
                              const std::filesystem::path& output,
                              const RecoverOptions& options = {},
                              const model::Progress& progress = {});

void describe(Members& members, const RecoverReport& report);

}  // namespace t4d::tools
