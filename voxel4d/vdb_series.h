#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <openvdb/openvdb.h>

#include "platform/cleanup.h"
#include "platform/part_file.h"
#include "t4d/error.h"
#include "t4d/mesh.h"

namespace t4d::voxel4d {

/// Writes a grid to a file; returns the bytes. Equal grids make equal bytes.
Result<std::uint64_t> writeVdb(const std::filesystem::path& path,
                               const openvdb::GridBase::Ptr& grid);

/// Fails unless a .vdb file has the bytes that writeVdb wrote: its UUID is made of them.
Result<void> checkVdbContents(const std::filesystem::path& path);

/// Writes grids as frame_0000.vdb, frame_0001.vdb, ... into a folder. Files get their names in
/// `commit`; without it nothing remains.
class VdbSeries {
 public:
  /// Creates the folder if it is missing. Fails for a folder with .vdb files of other names,
  /// or with files of these names that t4d did not write.
  /// The frames of other parts may be there, too.
  static Result<VdbSeries> create(const std::filesystem::path& folder, std::size_t frames,
                                  const model::Part& part = {});

  VdbSeries(VdbSeries&& other) noexcept;
  VdbSeries& operator=(VdbSeries&&) = delete;
  ~VdbSeries();

  /// The name of the next frame's file in the folder.
  const std::string& nextName() const { return names_.at(parts_.size()); }

  /// The next frame; returns the bytes of its file.
  Result<std::uint64_t> put(const openvdb::GridBase::Ptr& grid);
  Result<void> commit();

 private:
  VdbSeries() = default;
  std::filesystem::path folder_;
  platform::Cleanup madeFolder_;  // none if it existed
  std::vector<std::string> names_;
  std::vector<platform::PartFile> parts_;  // of the frames written
};

}  // namespace t4d::voxel4d
