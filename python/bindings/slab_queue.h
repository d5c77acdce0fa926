#pragma once

#include <condition_variable>
#include <exception>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include <unistd.h>

#include "python/bindings/producers.h"

namespace t4d::python {

/// Slabs one by one, as they are made in a thread of their own, which waits until each is taken.
class SlabQueue {
 public:
  explicit SlabQueue(std::shared_ptr<const Producer> producer)
      : thread_([shared = shared_, producer = std::move(producer)]() mutable {
          const Working working;
          try {
            auto done = producer->run(*shared, {});
            if (!done) shared->error = done.error();
          } catch (const std::exception&) {  // there is no memory
            shared->exception = std::current_exception();
          }
          producer.reset();
          shared->end();
        }) {}

  /// Call it without the GIL, which the producer may need.
  ~SlabQueue() {
    const bool inChild = process_ != ::getpid();  // of a fork, where the thread is not
    if (!inChild) shared_->abandon();
    // A thread that has been stopped does not end.
    if (inChild || shared_->begun != currentEra()) {
      thread_.detach();
    } else {
      const Waiting waiting;
      thread_.join();
    }
  }
  SlabQueue(const SlabQueue&) = delete;
  SlabQueue& operator=(const SlabQueue&) = delete;

  /// The next slab, null after the last. Call it without the GIL.
  Result<std::shared_ptr<model::Slab>> take() { return shared_->take(); }

 private:
  /// What both threads know.
  struct Shared : model::Sink {
    Result<void> put(const model::Slab& slab) override {
      auto copy = std::make_shared<model::Slab>(slab);
      goOn(begun);
      {
        const Waiting waiting;
        std::unique_lock lock(mutex);
        changed.wait(lock, [&] { return abandoned || !next; });
        if (!abandoned) next = std::move(copy);
      }
      goOn(begun);
      if (copy) return fail(ErrorCode::Failed, "nobody takes the slabs any more");
      changed.notify_all();
      return {};
    }

    Result<std::shared_ptr<model::Slab>> take() {
      const Waiting waiting;
      std::unique_lock lock(mutex);
      changed.wait(lock, [&] { return next || ended; });
      if (!next && exception) std::rethrow_exception(exception);
      if (!next && error) return *error;
      auto taken = std::exchange(next, nullptr);
      changed.notify_all();
      return taken;
    }

    void end() {
      const std::lock_guard lock(mutex);
      ended = true;
      changed.notify_all();
    }

    void abandon() {
      const std::lock_guard lock(mutex);
      abandoned = true;
      changed.notify_all();
    }

    const Era begun = currentEra();
    std::mutex mutex;
    std::condition_variable changed;
    std::shared_ptr<model::Slab> next;
    std::optional<Error> error;
    std::exception_ptr exception;
    bool ended = false;
    bool abandoned = false;
  };

  std::shared_ptr<Shared> shared_ = std::make_shared<Shared>();
  const pid_t process_ = ::getpid();
  std::thread thread_;  // last: it uses the others
};

}  // namespace t4d::python
