#pragma once

#include <bit>
#include <cstdint>
#include <string_view>

#include <fmt/format.h>

#include "formats/input_file.h"

namespace t4d::formats {

/// Reads binary numbers one after the other, and keeps the offset for errors. The file must outlive
/// the scanner.
class ByteScanner {
 public:
  ByteScanner(const InputFile& file, std::size_t begin, std::endian order)
      : file_(file), at_(begin), order_(order) {}

  /// Reads a number; `what` is for the error when the file ends.
  template <class T>
  Result<T> number(std::string_view what) {
    if (auto good = checkLeft(1, sizeof(T), what); !good) return good.error();
    return next<T>();
  }

  /// The next number, which checkLeft or checkCount found to be there.
  template <class T>
  T next() {
    const T value = loadNumber<T>(file_.bytes.data() + at_, order_);
    at_ += sizeof(T);
    return value;
  }

  /// Fails if fewer than `count` times `each` bytes follow, where `what` was expected.
  Result<void> checkLeft(std::uint64_t count, std::uint64_t each, std::string_view what) const {
    if (each == 0 || count <= bytesLeft() / each) return {};
    return invalid(fmt::format("the file ends, expected {}", what),
                   file_.atByte(file_.bytes.size()));
  }

  /// Fails if fewer than `count` elements of `each` bytes follow; the count was read before here.
  Result<void> checkCount(std::uint64_t count, std::uint64_t each, std::string_view what) const {
    if (each == 0 || count <= bytesLeft() / each) return {};
    return invalidHere(fmt::format("declares {} {} of {} bytes, but {} bytes follow", count, what,
                                   each, bytesLeft()));
  }

  /// The caller has checked that as many bytes follow.
  void skip(std::uint64_t bytes) { at_ += bytes; }
  void setOrder(std::endian order) { order_ = order; }
  void goTo(std::size_t offset) { at_ = offset; }

  std::size_t at() const { return at_; }
  std::size_t bytesLeft() const { return file_.bytes.size() - at_; }
  Error invalidHere(std::string message) const {
    return invalid(std::move(message), file_.atByte(at_));
  }

 private:
  const InputFile& file_;
  std::size_t at_;
  std::endian order_;
};

}  // namespace t4d::formats
