#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <functional>
#include <optional>
#include <ranges>
#include <span>
#include <type_traits>
#include <vector>

#include "platform/scratch_file.h"

namespace t4d::formats {

/// Rows that are made when they are asked for. `read` sets `into` to those from number `first` on,
/// for several threads at a time.
template <class Row>
struct Rows {
  std::size_t count = 0;
  std::function<void(std::size_t first, std::span<Row> into)> read;
};

/// The rows of a vector.
template <class Row>
Rows<Row> rowsOf(const std::vector<Row>& rows) {
  return {rows.size(), [&rows](std::size_t first, std::span<Row> into) {
            std::copy_n(rows.begin() + static_cast<std::ptrdiff_t>(first), into.size(),
                        into.begin());
          }};
}

/// A list that need not fit into memory: all but its last rows are in a file for temporary data,
/// unless there is no room for that. `Stored` is how a row is kept there.
template <class Row, class Stored = Row>
class LongList {
  static_assert(std::is_trivially_copyable_v<Stored>);

 public:
  void push_back(const Row& row) {
    last_.push_back(Stored(row));
    if (last_.size() >= kMostInMemory && !noFile_) moveToFile();
  }
  std::size_t size() const { return inFile_ + last_.size(); }
  bool empty() const { return size() == 0; }

  /// Only one thread may call it at a time.
  Row operator[](std::size_t index) const {
    if (index >= inFile_) return Row(last_[index - inFile_]);
    if (index < firstKnown_ || index - firstKnown_ >= known_.size()) {
      firstKnown_ = index - index % kReadAtOnce;
      known_.resize(std::min(kReadAtOnce, inFile_ - firstKnown_));
      readFile(firstKnown_, known_);
    }
    return Row(known_[index - firstKnown_]);
  }
  Row front() const { return (*this)[0]; }
  Row back() const { return (*this)[size() - 1]; }
  /// All rows, as a range of values; valid as long as this object is where it is.
  auto all() const {
    return std::views::iota(std::size_t{0}, size()) |
           std::views::transform([this](std::size_t index) { return (*this)[index]; });
  }

  /// Valid as long as this object is where it is, and until the next row is added.
  Rows<Row> rows() const {
    return {size(), [this](std::size_t first, std::span<Row> into) {
              const std::size_t stored =
                  first < inFile_ ? std::min(into.size(), inFile_ - first) : 0;
              std::vector<Stored> some(stored);
              readFile(first, some);
              for (std::size_t i = 0; i < into.size(); ++i) {
                into[i] = Row(i < stored ? some[i] : last_[first + i - inFile_]);
              }
            }};
  }

  /// Whether some rows could not be read again and were taken as zeros: the disk for temporary data
  /// fails.
  bool failed() const { return failed_; }

 private:
  static constexpr std::size_t kMostInMemory = 16384;
  static constexpr std::size_t kReadAtOnce = 1024;

  void moveToFile() {
    if (!file_) {
      auto made = platform::ScratchFile::create();
      if (made) file_.emplace(std::move(*made));
    }
    if (!file_ || !file_->append(std::as_bytes(std::span(last_)))) {
      noFile_ = true;
      return;
    }
    inFile_ += last_.size();
    last_.clear();
  }

  void readFile(std::size_t first, std::span<Stored> into) const {
    if (into.empty() || file_->read(first * sizeof(Stored), std::as_writable_bytes(into))) return;
    std::ranges::fill(into, Stored{});
    std::atomic_ref<bool>{failed_}.store(true);
  }

  std::optional<platform::ScratchFile> file_;
  bool noFile_ = false;
  std::size_t inFile_ = 0;
  std::vector<Stored> last_;  // the rows that are not in the file
  mutable std::vector<Stored> known_;
  mutable std::size_t firstKnown_ = 0;
  mutable bool failed_ = false;
};

}  // namespace t4d::formats
