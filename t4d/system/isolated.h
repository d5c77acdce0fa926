#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "t4d/model/error.h"

namespace t4d::system {

/// What isolated work may use beyond what this process uses already.
struct WorkLimits {
  std::uint64_t memoryBytes = 0;
  std::uint64_t cpuSeconds = 0;
};

/// How isolated work ended.
struct IsolatedWork {
  enum class End : std::uint8_t {
    Returned,
    Crashed,      ///< by the signal `signal`: an assertion, say
    OutOfTime,    ///< after WorkLimits::cpuSeconds
    OutOfMemory,  ///< more than WorkLimits::memoryBytes
  };
  End end = End::Returned;
  int signal = 0;
  std::string result;
};

/// Runs `work` in a fork of this process and returns its result: for code of others that may abort,
/// run for ever or take all memory. What it prints is dropped. `work` must not use threads of this
/// process. Safe to call from many threads. Errors: no process can be started, or its result cannot
/// be kept.
Result<IsolatedWork> runIsolated(const std::function<std::string()>& work,
                                 const WorkLimits& limits);

}  // namespace t4d::system
