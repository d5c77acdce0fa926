#pragma once

#include <filesystem>
#include <map>
#include <string>

#include <Eigen/Core>

#include "t4d/error.h"

namespace t4d::formats {

struct InputFile;

/// A tool of a tool table.
struct TableTool {
  Eigen::Vector3d length =
      Eigen::Vector3d::Zero();  ///< X, Y, Z; how far the tip is below the spindle
  std::string remark;
};

/// Reads a tool table of LinuxCNC, a tool a line, in mm:
///
///     T1 P1 Z50.8 D6 ;flat:d=6,l=20
///
/// T is the number, and X, Y and Z are offsets of the length (G43). P, D, I, J, Q and offsets of
/// other axes are skipped. The remark after a semicolon is kept. Fails, with the line, for other
/// words, malformed numbers, a line without T and a tool that comes twice.
Result<std::map<int, TableTool>> readToolTable(const InputFile& file);
Result<std::map<int, TableTool>> readToolTable(const std::filesystem::path& path);

}  // namespace t4d::formats
