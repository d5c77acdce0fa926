#pragma once

#include <filesystem>
#include <iterator>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "formats/output_file.h"

namespace t4d::formats {

/// A text file in the making. Numbers formatted with "{}" are the shortest decimals that read back
/// as the same doubles.
class TextOutput {
 public:
  static Result<TextOutput> create(const std::filesystem::path& path) {
    auto file = OutputFile::create(path);
    if (!file) return file.error();
    return TextOutput(std::move(*file));
  }

  template <class... Values>
  void add(fmt::format_string<Values...> format, Values&&... values) {
    fmt::format_to(std::back_inserter(text_), format, std::forward<Values>(values)...);
  }

  /// Writes what was added; to be called every few thousand lines.
  Result<void> flush() {
    auto done = file_.write(text_.data(), text_.size());
    text_.clear();
    return done;
  }

  Result<void> commit() {
    if (auto done = flush(); !done) return done;
    return file_.commit();
  }

 private:
  explicit TextOutput(OutputFile file) : file_(std::move(file)) {}

  OutputFile file_;
  fmt::memory_buffer text_;
};

}  // namespace t4d::formats
