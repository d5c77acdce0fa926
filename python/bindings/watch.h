#pragma once

#include <atomic>
#include <chrono>
#include <mutex>
#include <optional>

#include "python/bindings/gil.h"
#include "t4d/mesh.h"

namespace t4d::python {

/// Long work as Python sees it: it runs without the GIL, reports its progress to a callable, and
/// ends at its next report on Ctrl-C, where the callable raises, and where the interpreter ends.
class Watch {
 public:
  /// `callback` is None, or a callable that takes the fraction done, from 0 to 1.
  explicit Watch(py::object callback) : callback_(std::move(callback)) {}

  /// Runs `work`, a function of a Progress, without the GIL, and returns the value of its Result.
  template <class Do>
  auto run(Do work) {
    auto result = [&] {
      const Unlocked unlocked;
      return work(model::Progress([this](double fraction) { return report(fraction); }));
    }();
    if (raised_) throw *std::exchange(raised_, std::nullopt);
    work_.exitIfEnding();
    return valueOf(std::move(result));
  }

  /// A sink that calls `callback` with each slab.
  class Caller : public model::Sink {
   public:
    explicit Caller(Watch& watch) : watch_(watch) {}

    Result<void> put(const model::Slab& slab) override {
      auto copy = std::make_shared<model::Slab>(slab);
      if (watch_.goesOn()) {
        const Locked locked;
        watch_.call(py::cast(std::move(copy)));
      }
      return watch_.goesOn() ? Result<void>() : fail(ErrorCode::Failed, "interrupted");
    }

   private:
    Watch& watch_;
  };

 private:
  bool goesOn() const { return !stop_ && !work_.mustStop(); }

  /// Whether the work shall go on. Call it without the GIL.
  bool report(double fraction) {
    if (!goesOn() || !isDue(fraction >= 1)) return goesOn();
    const Locked locked;
    if (inPython(PyErr_CheckSignals) != 0) stopWithException();
    if (!stop_ && !callback_.is_none()) call(py::float_(fraction));
    return goesOn();
  }

  /// Needs the GIL. No destructor runs within inPython: it might, without the GIL.
  void call(const py::object& argument) {
    PyObject* const returned = inPython(
        [&] { return PyObject_CallFunctionObjArgs(callback_.ptr(), argument.ptr(), nullptr); });
    if (returned == nullptr) stopWithException();
    Py_XDECREF(returned);
  }

  void stopWithException() {
    raised_ = py::error_already_set();
    stop_ = true;
  }

  /// Twenty times a second.
  bool isDue(bool always) {
    const std::lock_guard lock(mutex_);
    const auto now = std::chrono::steady_clock::now();
    if (!always && now - last_ < std::chrono::milliseconds(50)) return false;
    last_ = now;
    return true;
  }

  const Work work_;
  py::object callback_;
  std::optional<py::error_already_set> raised_;
  std::atomic<bool> stop_ = false;
  std::mutex mutex_;
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

}  // namespace t4d::python
