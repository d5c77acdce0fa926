#pragma once

#include <cstdint>

namespace t4d::model {

/// Numbers from `begin` up to, not including, `end`.
struct PartRange {
  std::uint64_t begin = 0;
  std::uint64_t end = 0;

  std::uint64_t size() const { return end - begin; }
};

/// One of several consecutive parts of a whole, each worked on alone.
struct Part {
  std::uint64_t number = 1;  ///< from 1 to count
  std::uint64_t count = 1;

  bool isFirst() const { return number == 1; }
  bool isLast() const { return number == count; }

  /// Its share of `all` things in a row, such as steps: the first parts have one more where they do
  /// not divide evenly. Empty for some parts if there are fewer things than parts.
  PartRange of(std::uint64_t all) const { return {before(number - 1, all), before(number, all)}; }

 private:
  std::uint64_t before(std::uint64_t parts, std::uint64_t all) const {
    return parts * (all / count) + (parts < all % count ? parts : all % count);
  }
};

}  // namespace t4d::model
