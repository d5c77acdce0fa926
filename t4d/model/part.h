#pragma once

#include <cstdint>

namespace t4d::model {

/// One of several consecutive parts of a whole, each worked on alone.
struct Part {
  std::uint64_t number = 1;  ///< from 1 to count
  std::uint64_t count = 1;

  bool isFirst() const { return number == 1; }
  bool isLast() const { return number == count; }
};

}  // namespace t4d::model
