#include "python/bindings/gil.h"

#include <atomic>
#include <chrono>
#include <thread>

#include <pthread.h>

#include "platform/cleanup.h"

namespace t4d::python {
namespace {

std::atomic<bool> ending = false;
std::thread::id ender;  ///< is set before `ending`

/// Threads at work share it. In the child of a fork it is a new one: nobody is at work there.
std::shared_timed_mutex* working = [] {
  ::pthread_atfork(nullptr, nullptr, [] { working = new std::shared_timed_mutex; });
  return new std::shared_timed_mutex;
}();

}  // namespace

void end() {
  ender = std::this_thread::get_id();
  ending = true;
  PyThreadState* const state = PyEval_SaveThread();
  // Only a look: who begins to work from now on stops at once.
  if (working->try_lock_for(std::chrono::seconds(2))) working->unlock();
  platform::cleanUp();
  PyEval_RestoreThread(state);
}

Work::Work() : begunByEnder_(ending && std::this_thread::get_id() == ender) {}

bool Work::mustStop() const { return ending && !begunByEnder_; }

void Work::exitIfEnding() const {
  if (!mustStop()) return;
  PyErr_SetNone(PyExc_SystemExit);
  throw py::error_already_set();
}

// With the GIL, so that `end` either waits for this work or keeps it from beginning.
Unlocked::Unlocked() : working_(*working), released_((Work().exitIfEnding(), Released())) {}

}  // namespace t4d::python
