#pragma once

#include <filesystem>
#include <fstream>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <openvdb/io/Archive.h>
#include <openvdb/io/GridDescriptor.h>
#include <openvdb/io/io.h>
#include <openvdb/openvdb.h>

#include "model/error.h"

namespace t4d::voxel4d {

/// Reads a .vdb grid by grid, and distrusts it: OpenVDB's own io::File takes files that are cut off
/// or damaged for good ones. Here every read must succeed, each grid must lie within the file and
/// end where the file says, and its counts must be those of its metadata.
///
/// OpenVDB 10 writes the values of a leaf node to where it has room for them before it compares
/// their announced size with that room. So each grid is gone through twice: first all leaf nodes
/// are skipped, which compares only.
class VdbFile : private openvdb::io::Archive {
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
  struct Place {
    openvdb::io::GridDescriptor descriptor;
    std::int64_t begin = 0;
    std::int64_t end = 0;
  };

  VdbFile() = default;
  void readDirectory();
  void readEntry();
  openvdb::GridBase::Ptr readTree(std::size_t index);
  void tie(std::istream& stream);

  std::filesystem::path path_;
  std::ifstream stream_;
  openvdb::io::StreamMetadata::Ptr metadata_;  // the stream points to this
  std::int64_t size_ = 0;
  std::vector<Entry> entries_;
  std::vector<Place> places_;
};

}  // namespace t4d::voxel4d
