#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "t4d/check.h"

namespace t4d::tools {

class Members;

/// Result of validating a .t4d file: its bytes and its meshes.
struct Validation {
  /// The report on all bodies together; empty if the file cannot be read that far.
  std::optional<measure::MeshReport> mesh;
  /// All findings, with the slab and its offset in the file if they concern a single one.
  measure::IssueList issues;
  bool deep = false;  ///< whether vertex links were to be checked

  bool valid() const { return issues.errors == 0; }
};

/// The finding that a file cannot be read further. It names the place if that is in another file: a
/// part of this one.
measure::Issue damageOf(const Error& error, const std::filesystem::path& file);
/// Adds the report on one of `bodies` bodies. If there are several, its findings begin with `name`.
void addBody(Validation& validation, measure::MeshReport one, const std::string& name,
             std::size_t bodies);

/// Checks a file against all rules of SPEC.md (as checkT4dFile) and every body as a 4D mesh
/// (measure::MeshChecker). Keeps two slabs in memory. Problems with the file are findings; only a
/// file that cannot be opened at all is an error, and one with more than `maxCells` cells (as
/// T4dReader::open takes them). A pipe, or `-` for the standard input, is checked as it comes
/// (T4dStream).
Result<Validation> validate(const std::filesystem::path& path,
                            const measure::CheckOptions& options = {},
                            const model::Progress& progress = {},
                            std::optional<std::uint64_t> maxCells = {});

void describe(Members& members, const Validation& validation);

}  // namespace t4d::tools
