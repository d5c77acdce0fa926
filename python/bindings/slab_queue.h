#pragma once

#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>

#include "python/bindings/producers.h"

namespace t4d::python {

/// Slabs one by one, as they are made in a thread of their own, which waits until each is taken.
class SlabQueue : public model::Sink {
 public:
  explicit SlabQueue(std::shared_ptr<const Producer> producer)
      : thread_([this, producer = std::move(producer)] {
          auto done = producer->run(*this, {});
          const std::lock_guard lock(mutex_);
          if (!done) error_ = done.error();
          ended_ = true;
          changed_.notify_all();
        }) {}

  /// Call it without the GIL, which the producer may need.
  ~SlabQueue() override {
    {
      const std::lock_guard lock(mutex_);
      abandoned_ = true;
    }
    changed_.notify_all();
    thread_.join();
  }

  Result<void> put(const model::Slab& slab) override {
    auto copy = std::make_shared<model::Slab>(slab);
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return abandoned_ || !next_; });
    if (abandoned_) return fail(ErrorCode::Failed, "nobody takes the slabs any more");
    next_ = std::move(copy);
    changed_.notify_all();
    return {};
  }

  /// The next slab, null after the last. Call it without the GIL.
  Result<std::shared_ptr<model::Slab>> take() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return next_ || ended_; });
    if (!next_ && error_) return t4d::pass(*error_);
    auto taken = std::move(next_);
    next_ = nullptr;
    changed_.notify_all();
    return taken;
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::shared_ptr<model::Slab> next_;
  std::optional<Error> error_;
  bool ended_ = false;
  bool abandoned_ = false;
  std::thread thread_;  // last: it uses the others
};

}  // namespace t4d::python
