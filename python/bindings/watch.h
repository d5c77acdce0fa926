#pragma once

#include <atomic>
#include <chrono>
#include <mutex>
#include <optional>

#include "python/bindings/gil.h"
#include "t4d/mesh.h"

namespace t4d::python {

/// Long work as Python sees it: it runs without the GIL, reports its progress to a callable, and
/// ends early on Ctrl-C, where the callable raises, and where the interpreter ends. The library has
/// no way to stop work but an error of the sink, so that is what it gets, before the next slab.
class Watch {
 public:
  /// `callback` is None, or a callable that takes the fraction done, from 0 to 1.
  explicit Watch(py::object callback) : callback_(std::move(callback)) {}

  /// Runs `work`, a function of a Progress, without the GIL, and returns the value of its Result.
  template <class Do>
  auto run(Do work) {
    auto result = [&] {
      const Unlocked unlocked;
      return work(model::Progress([this](double fraction) { report(fraction); }));
    }();
    if (raised_) throw *std::exchange(raised_, std::nullopt);
    work_.exitIfEnding();
    return valueOf(std::move(result));
  }

  /// An error if the work is to stop. Call it without the GIL.
  Result<void> goOn() {
    if (!stop_ && !work_.mustStop() && isDue(false)) {
      const Locked locked;
      if (inPython(PyErr_CheckSignals) != 0) stopWithException();
    }
    if (stop_ || work_.mustStop()) return fail(ErrorCode::Failed, "interrupted");
    return {};
  }

  /// A sink before another one: it passes on slabs until the work is to stop.
  class Sink : public model::Sink {
   public:
    Sink(Watch& watch, model::Sink& next) : watch_(watch), next_(next) {}

    Result<void> put(const model::Slab& slab) override {
      if (auto stopped = watch_.goOn(); !stopped) return stopped;
      return next_.put(slab);
    }
    std::unique_ptr<Prepared> prepare(const model::Slab& slab) const override {
      return next_.prepare(slab);
    }
    Result<void> putPrepared(const model::Slab& slab, Prepared* prepared) override {
      if (auto stopped = watch_.goOn(); !stopped) return stopped;
      return next_.putPrepared(slab, prepared);
    }
    Result<void> putStreamed(const model::StreamedSlab& slab) override {
      if (auto stopped = watch_.goOn(); !stopped) return stopped;
      return next_.putStreamed(slab);
    }

   private:
    Watch& watch_;
    model::Sink& next_;
  };

  /// A sink that calls `callback` with each slab.
  class Caller : public model::Sink {
   public:
    explicit Caller(Watch& watch) : watch_(watch) {}

    Result<void> put(const model::Slab& slab) override {
      auto copy = std::make_shared<model::Slab>(slab);
      if (auto stopped = watch_.goOn(); !stopped) return stopped;
      const Locked locked;
      watch_.call(py::cast(std::move(copy)));
      return watch_.stop_ ? Result<void>(fail(ErrorCode::Failed, "interrupted")) : Result<void>();
    }

   private:
    Watch& watch_;
  };

 private:
  void report(double fraction) {
    if (work_.mustStop() || callback_.is_none() || !isDue(fraction >= 1)) return;
    const Locked locked;
    if (!stop_) call(py::float_(fraction));
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
