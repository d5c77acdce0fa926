#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <utility>

#include "model/parallel.h"
#include "t4d/error.h"

namespace t4d::model {

/// Parts that several slabs share, by keys. A part is made by the thread that needs it first, while
/// others wait. It is kept while somebody holds a pointer to it; the part requested last is kept
/// longer.
template <class Key, class Part>
class SharedParts {
 public:
  using Pointer = std::shared_ptr<const Part>;

  /// `make` returns a Result<Part>. After an error the next call makes it again.
  template <class Make>
  Result<Pointer> get(Key key, Make make) {
    const std::shared_ptr<Entry> entry = entryAt(key);
    const std::scoped_lock lock(entry->mutex);
    if (!entry->made) {
      // A thread that waits here must not start on another slab, which could need the same part.
      auto made = isolate(make);
      if (!made) return made.error();
      entry->part = std::move(*made);
      entry->made = true;
    }
    return Pointer(entry, &entry->part);
  }

  /// The part requested last, if it has this key and is complete.
  Pointer last(Key key) const {
    std::shared_ptr<Entry> entry;
    {
      const std::scoped_lock lock(mutex_);
      if (!last_ || lastKey_ != key) return nullptr;
      entry = last_;
    }
    const std::scoped_lock lock(entry->mutex);
    return entry->made ? Pointer(entry, &entry->part) : nullptr;
  }

 private:
  struct Entry {
    std::mutex mutex;
    bool made = false;
    Part part;
  };

  std::shared_ptr<Entry> entryAt(Key key) {
    const std::scoped_lock lock(mutex_);
    if (last_ && lastKey_ == key) return last_;
    last_.reset();  // avoids two parts in memory while the next is made
    std::erase_if(known_, [](const auto& known) { return known.second.expired(); });
    std::weak_ptr<Entry>& known = known_[key];
    std::shared_ptr<Entry> entry = known.lock();
    if (!entry) known = entry = std::make_shared<Entry>();
    last_ = entry;
    lastKey_ = key;
    return entry;
  }

  mutable std::mutex mutex_;
  std::map<Key, std::weak_ptr<Entry>> known_;
  std::shared_ptr<Entry> last_;
  Key lastKey_ = {};
};

}  // namespace t4d::model
