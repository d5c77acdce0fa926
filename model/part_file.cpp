#include "model/part_file.h"

#include <atomic>
#include <cerrno>
#include <cstring>
#include <memory>
#include <string>
#include <utility>

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

namespace t4d::model {

/// An element of a list that only grows, so that a signal handler can walk along it at any time.
/// Entries are used again, but never one that a handler has begun to remove.
struct PartFile::Entry {
  enum class State : std::uint8_t { Free, Filling, Used, Removing };
  std::atomic<State> state = State::Filling;
  std::unique_ptr<char[]> path;
  std::size_t capacity = 0;
  Entry* next = nullptr;
};

namespace {

using Entry = PartFile::Entry;
using State = Entry::State;

std::atomic<Entry*> entries = nullptr;
static_assert(std::atomic<Entry*>::is_always_lock_free && std::atomic<State>::is_always_lock_free,
              "signal handlers read these");

bool change(Entry& entry, State from, State to) {
  return entry.state.compare_exchange_strong(from, to);
}

Entry* addEntry(const std::string& path) {
  const std::size_t size = path.size() + 1;
  Entry* entry = entries.load();
  while (entry != nullptr &&
         !(entry->capacity >= size && change(*entry, State::Free, State::Filling))) {
    entry = entry->next;
  }
  if (entry == nullptr) {
    entry = new Entry;
    entry->path = std::make_unique<char[]>(size);
    entry->capacity = size;
    entry->next = entries.load();
    while (!entries.compare_exchange_weak(entry->next, entry)) {
    }
  }
  std::memcpy(entry->path.get(), path.c_str(), size);
  entry->state.store(State::Used);
  return entry;
}

tl::unexpected<Error> ioError(const std::filesystem::path& target, const char* doing) {
  return fail(ErrorCode::Io, fmt::format("cannot {}: {}", doing, std::strerror(errno)),
              target.string());
}

/// Waits until all of an open file or folder is on the disk, and closes it. Where a file system
/// cannot do that there is nothing to wait for.
bool syncAndClose(int descriptor) {
  const bool done =
      ::fsync(descriptor) == 0 || errno == EINVAL || errno == ENOTSUP || errno == ENOSYS;
  const int reason = errno;
  ::close(descriptor);
  errno = reason;
  return done;
}

}  // namespace

PartFile::PartFile(std::filesystem::path target)
    : target_(std::move(target)),
      path_(target_.parent_path() /
            fmt::format(".{}.{}.part", target_.filename().string(), ::getpid())),
      entry_(addEntry(path_.string())) {}

PartFile::PartFile(PartFile&& other) noexcept { *this = std::move(other); }

PartFile& PartFile::operator=(PartFile&& other) noexcept {
  if (this == &other) return *this;
  remove();
  target_ = std::move(other.target_);
  path_ = std::move(other.path_);
  entry_ = std::exchange(other.entry_, nullptr);
  return *this;
}

Result<void> PartFile::sync() const {
  const int descriptor = ::open(path_.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0 || !syncAndClose(descriptor)) return ioError(target_, "write");
  return {};
}

Result<void> PartFile::rename() {
  if (::rename(path_.c_str(), target_.c_str()) != 0) return ioError(target_, "put in place");
  change(*std::exchange(entry_, nullptr), State::Used, State::Free);
  return {};
}

Result<void> PartFile::putInPlace(std::span<PartFile> parts) {
  if (parts.empty()) return {};
  for (const PartFile& part : parts) {
    if (auto synced = part.sync(); !synced) return synced;
  }
  for (PartFile& part : parts) {
    if (auto renamed = part.rename(); !renamed) return renamed;
  }
  const std::filesystem::path& target = parts.back().target_;
  const std::filesystem::path folder = target.has_parent_path() ? target.parent_path() : ".";
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  // A folder may be writable and not readable.
  if (descriptor < 0 || syncAndClose(descriptor)) return {};
  return ioError(target, "have the new name kept on the disk");
}

void PartFile::remove() noexcept {
  if (entry_ == nullptr) return;
  ::unlink(path_.c_str());
  change(*std::exchange(entry_, nullptr), State::Used, State::Free);
}

void removePartFiles() noexcept {
  const int reason = errno;
  for (Entry* entry = entries.load(); entry != nullptr; entry = entry->next) {
    if (change(*entry, State::Used, State::Removing)) ::unlink(entry->path.get());
  }
  errno = reason;
}

}  // namespace t4d::model
