#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <utility>

namespace t4d::platform {

/// An open file, pipe or process of the system, which the destructor closes. What fails sets errno;
/// interrupted calls are repeated.
class Descriptor {
 public:
  explicit Descriptor(int number = -1) : number_(number) {}
  Descriptor(Descriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(number_, other.number_);
    return *this;
  }
  ~Descriptor() { close(); }

  explicit operator bool() const { return number_ >= 0; }
  int number() const { return number_; }
  /// Whether the system closed it without an error; an error may be that of an earlier write.
  bool close() noexcept;

  /// Waits for the next bytes and puts them at the beginning of `into`. Returns how many: 0 at the
  /// end, -1 if it failed.
  std::ptrdiff_t read(std::span<std::byte> into) const;
  /// Sets `into` to the bytes from `offset` on. Returns how many there are: fewer only at the end,
  /// -1 if it failed. Safe to call from several threads at once.
  std::ptrdiff_t readAt(std::uint64_t offset, std::span<std::byte> into) const;
  /// Writes all of the bytes; false if it failed.
  bool write(std::string_view bytes) const;
  bool writeAt(std::uint64_t offset, std::string_view bytes) const;

 private:
  int number_;
};

}  // namespace t4d::platform
