#include "python/bindings/ending.h"

#include <atomic>
#include <chrono>
#include <thread>

#include <unistd.h>

#include "t4d/system/cleanup.h"

namespace t4d::python {
namespace {

std::atomic<Era> era = 0;
std::atomic<int> works = 0;  ///< threads at work, but for those that sleep
std::atomic<int> calls = 0;  ///< those of them that call Python code
thread_local int locks = 0;  ///< of this thread, in work
std::thread::id ender;       ///< the thread that has called endWork; guarded by the GIL

[[noreturn]] void endThread() {
  --works;
  sleepForEver();
}

}  // namespace

Era currentEra() { return era; }

void goOn(Era begun) {
  if (begun != era) endThread();
}

void sleepForEver() {
  while (true) ::pause();
}

void endWork() {
  using namespace std::chrono_literals;
  ++era;
  ender = std::this_thread::get_id();
  PyThreadState* const state = PyEval_SaveThread();
  system::cleanUp();  // a thread may wait for a process
  const auto begin = std::chrono::steady_clock::now();
  while (works > 0 && std::chrono::steady_clock::now() - begin < (works > calls ? 10s : 3s)) {
    std::this_thread::sleep_for(2ms);
  }
  system::cleanUp();
  PyEval_RestoreThread(state);
}

void forgetWork() {
  works = 0;
  calls = 0;
  ender = {};
}

Working::Working() { ++works; }
Working::~Working() { --works; }

Waiting::Waiting() { --works; }
Waiting::~Waiting() { ++works; }

Unlocked::Unlocked() {
  // Work that begins after the end; not work that the ender has begun in another thread.
  const bool late = locks == 0 && ender != std::thread::id{} && ender != std::this_thread::get_id();
  ++works;
  state_ = PyEval_SaveThread();
  if (late) endThread();
}

Unlocked::~Unlocked() {
  goOn(begun_);
  usingPython([&] { PyEval_RestoreThread(state_); });
  --works;
}

Locked::Locked(Era begun) {
  goOn(begun);
  ++calls;
  state_ = usingPython([] { return PyGILState_Ensure(); });
  ++locks;
}

Locked::~Locked() {
  --locks;
  PyGILState_Release(state_);
  --calls;
}

}  // namespace t4d::python
