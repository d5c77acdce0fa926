#pragma once

#include <filesystem>
#include <span>

#include "t4d/model/error.h"
#include "t4d/system/cleanup.h"

namespace t4d::system {

/// A file on its way to its name: it is written to a hidden file beside it, `.NAME.PID.part`, and
/// renamed when it is whole. So there is never half a file under the name, whatever happens; a part
/// that is not put in place is removed at the end of its life here, or by cleanUp.
class PartFile {
 public:
  /// None.
  PartFile() = default;
  /// Makes no file yet.
  explicit PartFile(std::filesystem::path target);

  PartFile(PartFile&& other) noexcept;
  PartFile& operator=(PartFile&& other) noexcept;
  ~PartFile() { remove(); }

  explicit operator bool() const { return static_cast<bool>(note_); }
  /// Where to write.
  const std::filesystem::path& path() const { return path_; }

  /// Gives files of one folder, written and closed, their names. Waits until they are on the disk
  /// before, and until the names are after: else a crash of the machine could leave names without
  /// content. Parts that have no name yet when something fails stay parts.
  static Result<void> putInPlace(std::span<PartFile> parts);

  void remove() noexcept;

 private:
  Result<void> sync() const;
  Result<void> rename();

  std::filesystem::path target_;
  std::filesystem::path path_;
  Cleanup note_;
};

}  // namespace t4d::system
