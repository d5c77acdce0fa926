#pragma once

#include <filesystem>

#include "model/cleanup.h"
#include "model/error.h"

namespace t4d::conformance {

/// A folder for files that nobody is to see; gone with the object, and all in it; also where a
/// signal ends the process (model::cleanUp).
class TemporaryFolder {
 public:
  static Result<TemporaryFolder> create();

  TemporaryFolder(TemporaryFolder&& other) noexcept;
  TemporaryFolder& operator=(TemporaryFolder&& other) noexcept;
  ~TemporaryFolder();

  const std::filesystem::path& path() const { return path_; }

 private:
  explicit TemporaryFolder(const std::filesystem::path& path)
      : path_(path), note_(model::Cleanup::folder(path)) {}
  std::filesystem::path path_;
  model::Cleanup note_;
};

}  // namespace t4d::conformance
