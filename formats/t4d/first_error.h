#pragma once

#include <cstddef>
#include <mutex>
#include <optional>
#include <utility>

#include "t4d/error.h"

namespace t4d::formats {

/// The error of the first of several pieces at which threads work, in whichever order they do.
class FirstError {
 public:
  void add(std::size_t piece, const Result<void>& done) {
    if (done) return;
    const std::scoped_lock lock(mutex_);
    if (!error_ || piece < piece_) {
      piece_ = piece;
      error_ = done.error();
    }
  }
  /// The result when all are finished.
  Result<void> result() const { return error_ ? *error_ : Result<void>(); }

 private:
  std::mutex mutex_;
  std::size_t piece_ = 0;
  std::optional<Error> error_;
};

}  // namespace t4d::formats
