#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "t4d/error.h"

namespace t4d::platform {

/// The resources that isolated work may use in addition to what this process already uses.
struct WorkLimits {
  std::uint64_t memoryBytes = 0;
  std::uint64_t cpuSeconds = 0;
};

/// The end of isolated work.
struct IsolatedWork {
  enum class End : std::uint8_t {
    Returned,
    Crashed,      ///< by the signal `signal`, for example an assertion
    OutOfTime,    ///< after WorkLimits::cpuSeconds
    OutOfMemory,  ///< more than WorkLimits::memoryBytes
  };
  End end = End::Returned;
  int signal = 0;
  std::string result;
};

/// Runs `work` in a fork of this process and returns its result, for foreign code that may abort,
/// run forever or take all memory. Its output is dropped. `work` must not use threads of this
/// process. Safe to call from many threads. Fails if no process can be started, or if its result
/// cannot be stored.
Result<IsolatedWork> runIsolated(const std::function<std::string()>& work,
                                 const WorkLimits& limits);

}  // namespace t4d::platform
