#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <istream>
#include <stdexcept>
#include <string>

#include <fmt/format.h>

/// Bytes of a .vdb, of which nothing is believed. For the sources of this folder alone.
namespace t4d::voxel4d {

/// What is wrong with a file: a sentence that needs nothing before it.
struct VdbDamage : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Throws VdbDamage.
template <class... Values>
void require(bool condition, fmt::format_string<Values...> otherwise, Values&&... values) {
  if (!condition) throw VdbDamage(fmt::format(otherwise, std::forward<Values>(values)...));
}

/// Takes values from a stream up to an end; throws VdbDamage where they would lie behind it.
class VdbStream {
 public:
  VdbStream(std::istream& stream, std::int64_t end) : stream_(stream), end_(end) {}

  /// For OpenVDB's functions that read what has been judged.
  std::istream& stream() { return stream_; }
  std::int64_t position() const { return stream_.tellg(); }
  std::int64_t left() const { return end_ - position(); }
  void seek(std::int64_t position) { stream_.seekg(position); }

  /// Before memory is asked for; `bytes` may be any number of a file.
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
  /// A length of 32 bits and as many bytes.
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
