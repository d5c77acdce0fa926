#pragma once

#include <filesystem>
#include <fstream>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <openvdb/openvdb.h>

#include "t4d/model/error.h"
#include "t4d/voxel4d/vdb_stream.h"

namespace t4d::voxel4d {

/// Reads a .vdb of the format's versions 222 to 224 (OpenVDB from 1.0 on) grid by grid, and
/// distrusts it: OpenVDB's own io::File takes files that are cut off or damaged for good ones, or
/// crashes. Here every number is judged before it is used, each grid must lie within the file and
/// end where the file says, and its counts must be those of its metadata.
class VdbFile {
 public:
  struct Entry {
    std::string name;               ///< as the grid calls itself
    std::string label;              ///< unique in the file: `name` or `name[2]`
    std::string where;              ///< for errors: file and grid
    openvdb::GridBase::Ptr header;  ///< metadata and transform, without the tree
  };

  /// Reads what stands before the trees. A file that was streamed has no offsets: it is read
  /// through once.
  static Result<std::unique_ptr<VdbFile>> open(const std::filesystem::path& path);

  /// In the file's order.
  std::span<const Entry> grids() const { return entries_; }

  /// The whole grid.
  Result<openvdb::GridBase::Ptr> read(std::size_t index);

 private:
  /// What the file says of a grid before it begins.
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
  openvdb::GridBase::Ptr readWhole(std::size_t index);

  std::filesystem::path path_;
  std::ifstream stream_;
  std::int64_t size_ = 0;
  bool hasOffsets_ = false;
  std::vector<Entry> entries_;
  std::vector<Place> places_;
};

}  // namespace t4d::voxel4d
