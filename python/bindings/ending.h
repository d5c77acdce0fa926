#pragma once

#include <cstdint>
#include <utility>

#include <cxxabi.h>

#include "python/bindings/errors.h"

namespace t4d::python {

// Threads may be at work in the library when the interpreter ends: daemon threads of Python, and
// those of slabs(). If they went on, they would crash in what is torn down, and leave files that
// are half written. So endWork, which Python calls before it ends, stops each of them where it next
// reports its progress, puts a slab or asks for the GIL. There it sleeps for the rest of the
// process, as daemon threads of Python do.

/// Counts the calls of endWork.
using Era = std::uint32_t;
Era currentEra();
/// Returns only if endWork was not called since `begun`. Call it without the GIL.
void goOn(Era begun);

/// Stops all work of other threads, waits for that (10 s at most; 1 s for Python code that was
/// called in it) and removes the files that they were writing. This thread may go on to work. Needs
/// the GIL.
void endWork();
/// In the child of a fork: it has none of the other threads.
void forgetWork();

/// Sleeps for the rest of the process.
[[noreturn]] void sleepForEver();

/// Calls `use`, which may take the GIL. When the interpreter ends, Python unwinds threads that do
/// so; through functions that must not throw, that would abort the process.
template <class Use>
auto usingPython(Use use) {
  try {
    return use();
  } catch (abi::__forced_unwind&) {
    sleepForEver();
  }
}

/// Work of this thread, in a scope that has no GIL in it.
class Working {
 public:
  Working();
  ~Working();
  Working(const Working&) = delete;
  Working& operator=(const Working&) = delete;
};

/// Work that waits for another thread, in a scope.
class Waiting {
 public:
  Waiting();
  ~Waiting();
  Waiting(const Waiting&) = delete;
  Waiting& operator=(const Waiting&) = delete;
};

/// The scope of work without the GIL, in a thread that has it.
class Unlocked {
 public:
  Unlocked();
  ~Unlocked();
  Unlocked(const Unlocked&) = delete;
  Unlocked& operator=(const Unlocked&) = delete;

 private:
  Era begun_ = currentEra();
  PyThreadState* state_;
};

/// A scope with the GIL in work that began at `begun`.
class Locked {
 public:
  explicit Locked(Era begun);
  ~Locked();
  Locked(const Locked&) = delete;
  Locked& operator=(const Locked&) = delete;

 private:
  PyGILState_STATE state_;
};

}  // namespace t4d::python
