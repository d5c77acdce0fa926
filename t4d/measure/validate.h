#pragma once

#include <filesystem>
#include <optional>

#include "t4d/measure/mesh_check.h"

namespace t4d::measure {

/// The judgement of a .t4d file: its bytes, and what they mean.
struct T4dValidation {
  /// Of all bodies together; nothing where the file cannot be read as far as that.
  std::optional<MeshReport> mesh;
  /// All findings, with the slab and its offset in the file where they belong to one.
  IssueList issues;

  bool valid() const { return issues.errors == 0; }
};

/// Judges a file by all rules of SPEC.md (as checkT4dFile) and every body as a 4D mesh
/// (MeshChecker). Memory is that of two slabs. What is wrong with the file is a
/// finding; only a file that cannot be opened at all is an error.
Result<T4dValidation> validateT4dFile(const std::filesystem::path& path,
                                      const CheckOptions& options = {},
                                      const model::Progress& progress = {});

}  // namespace t4d::measure
