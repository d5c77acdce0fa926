#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <istream>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>

#include <fmt/format.h>

#include "t4d/error.h"

/// Bytes of an untrusted .vdb file. For the sources of this folder only.
namespace t4d::voxel4d {

/// A fault of a file; callers prepend its name.
struct VdbDamage : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A failure that is not the file's.
struct VdbFailure : std::runtime_error {
  explicit VdbFailure(Error of) : std::runtime_error(of.message), error(std::move(of)) {}
  Error error;
};

/// The value; throws VdbFailure if there is none.
template <class T>
T orThrow(Result<T> result) {
  if (!result) throw VdbFailure(std::move(result.error()));
  if constexpr (!std::is_void_v<T>) return std::move(*result);
}

/// Throws VdbDamage unless `condition` holds.
template <class... Values>
void require(bool condition, fmt::format_string<Values...> otherwise, Values&&... values) {
  if (!condition) throw VdbDamage(fmt::format(otherwise, std::forward<Values>(values)...));
}

/// Reads values from a stream up to an end; throws VdbDamage for values beyond it.
class VdbStream {
 public:
  VdbStream(std::istream& stream, std::int64_t end) : stream_(stream), end_(end) {}

  /// OpenVDB reads from it what has been checked.
  std::istream& stream() { return stream_; }
  std::int64_t position() const { return stream_.tellg(); }
  std::int64_t left() const { return end_ - position(); }
  void seek(std::int64_t position) { stream_.seekg(position); }

  /// Called before memory is allocated; `bytes` may be any number from a file.
  void need(std::uint64_t bytes) const {
    require(bytes <= static_cast<std::uint64_t>(std::max<std::int64_t>(left(), 0)),
            "is cut off or damaged: it announces {} bytes where {} are left", bytes, left());
  }
  void bytes(void* into, std::size_t size) {
    stream_.read(static_cast<char*>(into), static_cast<std::streamsize>(size));
  }
  template <class T>
  T take() {
    T value{};
    bytes(&value, sizeof value);
    return value;
  }
  void skip(std::uint64_t bytes) {
    need(bytes);
    stream_.seekg(static_cast<std::streamoff>(bytes), std::ios::cur);
  }
  /// A 32-bit length and that many bytes.
  std::string text() {
    const auto size = take<std::uint32_t>();
    need(size);
    std::string text(size, '\0');
    bytes(text.data(), size);
    return text;
  }

 private:
  std::istream& stream_;  // throws where it ends
  std::int64_t end_;
};

}  // namespace t4d::voxel4d
