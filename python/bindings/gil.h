#pragma once

#include <chrono>
#include <shared_mutex>
#include <thread>

#include <cxxabi.h>

#include "python/bindings/errors.h"

namespace t4d::python {

// Work in the library runs without the GIL. When the interpreter ends, daemon threads may still be
// at work. The function `end` below, which Python calls at exit, tells them to stop: from then on
// their work ends with an error, and the thread with a SystemExit, which Python does not print.

/// Tells the work of other threads to stop, waits until it has, for two seconds at most, and
/// removes the files that work which did not stop was writing. Needs the GIL.
void end();

/// Work that a thread begins. It is told to stop by `end`, unless the thread is the one that has
/// called `end`, whose other exit handlers may use the library, too.
class Work {
 public:
  Work();
  /// Whether the interpreter ends. In threads of the library, too.
  bool mustStop() const;
  /// Raises SystemExit if it does. Needs the GIL.
  void exitIfEnding() const;

 private:
  bool begunByEnder_;
};

/// Calls `use`, which asks for the GIL or runs Python code. Python before 3.14 ends a thread that
/// asks for the GIL too late by unwinding its stack; through functions of the library, which must
/// not throw, that would abort the process. Such a thread sleeps here, as it does in Python 3.14.
/// The thread that ends the interpreter is never one of them.
template <class Use>
auto inPython(Use use) {
  try {
    return use();
  } catch (abi::__forced_unwind&) {
    while (true) std::this_thread::sleep_for(std::chrono::hours(1));
  }
}

/// A scope without the GIL, in a thread that has it.
class Released {
 public:
  Released() : state_(PyEval_SaveThread()) {}
  ~Released() {
    inPython([&] { PyEval_RestoreThread(state_); });
  }
  Released(const Released&) = delete;
  Released& operator=(const Released&) = delete;

 private:
  PyThreadState* state_;
};

/// A scope of work without the GIL, for which `end` waits. Raises SystemExit if it must not begin.
class Unlocked {
 public:
  Unlocked();

 private:
  std::shared_lock<std::shared_timed_mutex> working_;
  Released released_;
};

/// A scope with the GIL within work, in any thread.
class Locked {
 public:
  Locked() : state_(inPython([] { return PyGILState_Ensure(); })) {}
  ~Locked() { PyGILState_Release(state_); }
  Locked(const Locked&) = delete;
  Locked& operator=(const Locked&) = delete;

 private:
  PyGILState_STATE state_;
};

}  // namespace t4d::python
