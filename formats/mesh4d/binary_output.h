#pragma once

#include <bit>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>

#include "formats/output_file.h"

namespace t4d::formats {

/// A binary file in the making; numbers are little-endian.
class BinaryOutput {
 public:
  static Result<BinaryOutput> create(const std::filesystem::path& path) {
    auto file = OutputFile::create(path);
    if (!file) return file.error();
    return BinaryOutput(std::move(*file));
  }

  template <class T>
  void add(T number) {
    static_assert(std::endian::native == std::endian::little);
    bytes_.append(reinterpret_cast<const char*>(&number), sizeof(T));
  }
  void addText(std::string_view text) { bytes_ += text; }

  /// Writes what was added; to be called every few thousand elements.
  Result<void> flush() {
    auto done = file_.write(bytes_.data(), bytes_.size());
    bytes_.clear();
    return done;
  }

  Result<void> commit() {
    if (auto done = flush(); !done) return done;
    return file_.commit();
  }

 private:
  explicit BinaryOutput(OutputFile file) : file_(std::move(file)) {}

  OutputFile file_;
  std::string bytes_;
};

}  // namespace t4d::formats
