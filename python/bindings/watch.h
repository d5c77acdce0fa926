#pragma once

#include <atomic>
#include <chrono>
#include <mutex>
#include <optional>

#include "python/bindings/ending.h"
#include "t4d/model/slab.h"

namespace t4d::python {

/// Long work as Python sees it: it runs without the GIL, reports its progress to a callable, and
/// ends early on Ctrl-C or where the callable raises. The library has no way to stop work but an
/// error of the sink, so that is what it gets, before the next slab.
class Watch {
 public:
  /// `callback` is None, or a callable that takes the fraction done, from 0 to 1.
  explicit Watch(py::object callback) : callback_(std::move(callback)) {}

  /// Runs `work`, a function of a Progress, without the GIL, and returns the value of its Result.
  template <class Work>
  auto run(Work work) {
    auto result = [&] {
      const Unlocked unlocked;
      return work(progress());
    }();
    if (raised_) throw *std::exchange(raised_, std::nullopt);
    return valueOf(std::move(result));
  }

  /// A sink before another one: it passes on slabs until the work is to stop.
  class Sink : public model::Sink {
   public:
    Sink(Watch& watch, model::Sink& next) : watch_(watch), next_(next) {}

    Result<void> put(const model::Slab& slab) override {
      if (watch_.stops()) return fail(ErrorCode::Failed, "interrupted");
      return next_.put(slab);
    }
    std::unique_ptr<Prepared> prepare(const model::Slab& slab) const override {
      return next_.prepare(slab);
    }
    Result<void> putPrepared(const model::Slab& slab, Prepared* prepared) override {
      if (watch_.stops()) return fail(ErrorCode::Failed, "interrupted");
      return next_.putPrepared(slab, prepared);
    }
    Result<void> putStreamed(const model::StreamedSlab& slab) override {
      if (watch_.stops()) return fail(ErrorCode::Failed, "interrupted");
      return next_.putStreamed(slab);
    }

   private:
    Watch& watch_;
    model::Sink& next_;
  };

 private:
  model::Progress progress() {
    return [this](double fraction) {
      goOn(begun_);
      if (callback_.is_none() || !isDue(fraction >= 1)) return;
      const Locked locked(begun_);
      try {
        if (!raised_) usingPython([&] { callback_(fraction); });
      } catch (py::error_already_set& error) {
        raised_ = error;
        stop_ = true;
      }
    };
  }

  bool stops() {
    goOn(begun_);
    if (!stop_ && isDue(false)) {
      const Locked locked(begun_);
      if (usingPython(PyErr_CheckSignals) != 0) {
        raised_ = py::error_already_set();
        stop_ = true;
      }
    }
    return stop_;
  }

  /// Twenty times a second.
  bool isDue(bool always) {
    const std::lock_guard lock(mutex_);
    const auto now = std::chrono::steady_clock::now();
    if (!always && now - last_ < std::chrono::milliseconds(50)) return false;
    last_ = now;
    return true;
  }

  const Era begun_ = currentEra();
  py::object callback_;
  std::optional<py::error_already_set> raised_;
  std::atomic<bool> stop_ = false;
  std::mutex mutex_;
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

}  // namespace t4d::python
