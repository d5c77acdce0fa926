#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <openvdb/openvdb.h>

#include "t4d/error.h"
#include "voxel4d/vdb_file.h"
#include "voxel4d/vdb_grid.h"

namespace t4d::voxel4d {

/// A grid in a file, without its tree.
struct VdbPlace {
  std::filesystem::path file;
  std::size_t grid = 0;  ///< in the file
  Place where;           ///< for errors: file and grid
  openvdb::GridBase::ConstPtr header;
  double time = 0;  ///< of the frame
};

/// The files in the order given. A folder stands for its .vdb files, except hidden ones, in natural
/// order of their names.
Result<std::vector<std::filesystem::path>> vdbFilesOf(
    std::span<const std::filesystem::path> inputs);

/// The grids with a name, or all if it is empty, except those named `without`: one of each of
/// several files, or those of one file in natural order. Times are not set.
Result<std::vector<VdbPlace>> vdbPlacesOf(std::span<const std::filesystem::path> files,
                                          const std::string& grid,
                                          std::span<const std::string> without = {});

/// Reads grids, and keeps the file of the last one open.
class VdbPlaceReader {
 public:
  /// Reads a grid, as VdbFile::read does.
  Result<VdbGrid> read(const VdbPlace& place, const VdbTreeOptions& how);

 private:
  std::unique_ptr<VdbFile> file_;
  std::filesystem::path path_;
};

}  // namespace t4d::voxel4d
