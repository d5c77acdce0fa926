#pragma once

#include <filesystem>
#include <fstream>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <openvdb/openvdb.h>

#include "t4d/error.h"
#include "voxel4d/vdb_grid.h"
#include "voxel4d/vdb_stream.h"
#include "voxel4d/vdb_tree.h"

namespace t4d::voxel4d {

/// Reads a .vdb file of format version 222 to 224 (OpenVDB 1.0 and later) grid by grid, as
/// untrusted input: OpenVDB's own io::File accepts truncated or damaged files as valid, or crashes.
/// Here every number is checked before it is used, each grid must lie within the file and end where
/// the file says, and its counts must match its metadata.
class VdbFile {
 public:
  struct Entry {
    std::string name;               ///< of the grid
    std::string label;              ///< unique in the file: `name` or `name[2]`
    t4d::Place where;               ///< for errors: file and grid
    openvdb::GridBase::Ptr header;  ///< metadata and transform, without the tree
  };

  /// Reads everything before the trees. A streamed file has no offsets, so it is read completely
  /// once.
  static Result<std::unique_ptr<VdbFile>> open(const std::filesystem::path& path);

  /// The grids in file order.
  std::span<const Entry> grids() const { return entries_; }

  /// The grid, with the background outside the region if one is given.
  Result<VdbGrid> read(std::size_t index, const VdbTreeOptions& options = {});

 private:
  /// The directory entry of a grid.
  struct Place {
    std::string uniqueName;
    std::string gridType;
    std::string parent;  ///< unique name of the grid whose tree it shares; "" for none
    std::int64_t begin = 0;
    std::int64_t end = 0;
  };

  VdbFile() = default;
  void readDirectory();
  void readEntry(VdbStream& stream);
  VdbGrid readGrid(std::size_t index, const VdbTreeOptions& options);

  std::filesystem::path path_;
  std::ifstream stream_;
  std::int64_t size_ = 0;
  bool hasOffsets_ = false;
  std::vector<Entry> entries_;
  std::vector<Place> places_;
};

}  // namespace t4d::voxel4d
