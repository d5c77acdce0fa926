#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "t4d/edit/close_runs.h"
#include "t4d/formats/t4d/salvage.h"
#include "t4d/measure/validate.h"

namespace t4d::edit {

struct RecoverOptions {
  std::string generator;  ///< program and version, for the file's metadata
};

/// A layer of a recovered body that a cap closes.
struct RecoverCap {
  std::string body;
  RunEnd end;
};

struct RecoverReport {
  std::uint64_t slabsSaved = 0;
  std::optional<std::uint64_t> slabsKnown;  ///< as formats::T4dSalvage
  bool metadataSaved = false;
  /// By offset; empty where the file was valid. Of a file that was not damaged, caps that were
  /// added because the mesh was open.
  std::vector<formats::T4dLoss> lost;
  std::vector<RecoverCap> closed;
  /// Of the file written; nothing where no slab could be saved, and no file was written.
  std::optional<measure::T4dValidation> validation;
};

/// Writes the whole slabs of a damaged or truncated .t4d (formats::T4dSalvage) to `output`, their
/// numbers unchanged; closes the mesh where slabs are missing (RunCloser); and judges what it has
/// written. The details of the metadata get a member "recovered" that says where it comes from.
/// Fails where `input` is no .t4d at all, or `output` cannot be written.
Result<RecoverReport> recoverT4d(const std::filesystem::path& input,
                                 const std::filesystem::path& output,
                                 const RecoverOptions& options = {},
                                 const model::Progress& progress = {});

}  // namespace t4d::edit
