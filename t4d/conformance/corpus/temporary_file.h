#pragma once

#include <filesystem>
#include <fstream>
#include <string>

#include <unistd.h>

namespace t4d::conformance {

/// A file with the given content, removed at the end of the scope.
class TemporaryFile {
 public:
  explicit TemporaryFile(const std::string& bytes)
      : path_(std::filesystem::temp_directory_path() /
              ("t4d_corpus_" + std::to_string(::getpid()) + ".t4d")) {
    std::ofstream(path_, std::ios::binary) << bytes;
  }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  ~TemporaryFile() { std::filesystem::remove(path_); }

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace t4d::conformance
