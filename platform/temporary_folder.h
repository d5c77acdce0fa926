#pragma once

#include <filesystem>
#include <string>

#include "platform/cleanup.h"
#include "t4d/error.h"

namespace t4d::platform {

/// A folder for temporary files. The destructor removes it with its contents; so does cleanUp if a
/// signal ends the process.
class TemporaryFolder {
 public:
  /// Creates a folder in the system's folder for temporary files.
  static Result<TemporaryFolder> create();
  /// Creates a folder in `parent`, which must exist, with a name that begins so.
  static Result<TemporaryFolder> createIn(const std::filesystem::path& parent,
                                          const std::string& prefix = "t4d-");

  TemporaryFolder(TemporaryFolder&& other) noexcept;
  TemporaryFolder& operator=(TemporaryFolder&& other) noexcept;
  ~TemporaryFolder();

  const std::filesystem::path& path() const { return path_; }

 private:
  static Result<TemporaryFolder> make(const std::filesystem::path& parent,
                                      const std::string& prefix, const char* hint);
  explicit TemporaryFolder(const std::filesystem::path& path)
      : path_(path), note_(Cleanup::folder(path)) {}
  std::filesystem::path path_;
  Cleanup note_;
};

}  // namespace t4d::platform
