#include "platform/cleanup.h"

#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <string>
#include <utility>

#include <fcntl.h>
#include <poll.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

namespace t4d::platform {

/// An element of a list that only grows, so that a signal handler can walk along it at any time.
/// Entries are used again, but never one that a handler has begun to remove.
struct Cleanup::Entry {
  enum class State : std::uint8_t { Free, Filling, Used, Removing };
  enum class Kind : std::uint8_t { Process, File, Folder, EmptyFolder };
  std::atomic<State> state = State::Filling;
  Kind kind = Kind::File;
  pid_t process = 0;
  pid_t owner = 0;  ///< a fork has the list, too, but nothing in it is its own
  std::unique_ptr<char[]> path;
  std::size_t capacity = 0;
  Entry* next = nullptr;
};

namespace {

using Entry = Cleanup::Entry;
using State = Entry::State;
using Kind = Entry::Kind;

std::atomic<Entry*> entries = nullptr;
std::atomic<bool> cleaning = false;
std::atomic<int> holders = 0;  // how many HeldCleanup there are
static_assert(std::atomic<Entry*>::is_always_lock_free && std::atomic<State>::is_always_lock_free &&
                  std::atomic<bool>::is_always_lock_free && std::atomic<int>::is_always_lock_free,
              "signal handlers read these");

constexpr int kLookMilliseconds = 5;
/// What a process has to end itself, or a thread to make and register something.
constexpr int kPatienceMilliseconds = 1000;

/// The signals that the thread of a HeldCleanup blocked before.
thread_local sigset_t blockedBefore{};

bool change(Entry& entry, State from, State to) {
  return entry.state.compare_exchange_strong(from, to);
}

/// While a handler cleans up, the other threads must not start anew what it has just ended.
void waitWhileCleaning() {
  while (cleaning) ::poll(nullptr, 0, kLookMilliseconds);
}

Entry* addEntry(Kind kind, const std::string& path, pid_t process = 0) {
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
  entry->kind = kind;
  entry->process = process;
  entry->owner = ::getpid();
  entry->state.store(State::Used);
  return entry;
}

/// Waits until `holds` does, but not for ever.
template <class Condition>
void await(Condition holds) {
  for (int waited = 0; waited < kPatienceMilliseconds && !holds(); waited += kLookMilliseconds) {
    ::poll(nullptr, 0, kLookMilliseconds);
  }
}

/// Waits for a child to end, and leaves it to be waited for.
void awaitEnd(pid_t child) {
  await([=] {
    siginfo_t ended{};
    const int failed =
        ::waitid(P_PID, static_cast<id_t>(child), &ended, WEXITED | WNOHANG | WNOWAIT);
    return failed != 0 || ended.si_pid != 0;
  });
}

void removeFolder(int parent, const char* name, int depth);

/// Removes what is in an open folder, read by the system's own call: readdir may allocate.
void removeEntries(int folder, int depth) {
  struct Name {
    std::uint64_t inode;
    std::int64_t offset;
    std::uint16_t size;
    std::uint8_t type;
    char text[1];
  };
  alignas(Name) std::array<char, 4096> buffer;
  while (true) {
    const long size = ::syscall(SYS_getdents64, folder, buffer.data(), buffer.size());
    if (size <= 0) return;
    for (long at = 0; at < size;) {
      const auto* name = reinterpret_cast<const Name*>(buffer.data() + at);
      at += name->size;
      const char* text = name->text;
      if (std::strcmp(text, ".") == 0 || std::strcmp(text, "..") == 0) continue;
      if (::unlinkat(folder, text, 0) != 0 && depth > 0) removeFolder(folder, text, depth - 1);
    }
  }
}

void removeFolder(int parent, const char* name, int depth) {
  // Another thread may be writing into it.
  constexpr int kAttempts = 20;
  for (int i = 0; i < kAttempts; ++i) {
    const int folder = ::openat(parent, name, O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
    if (folder < 0) return;
    removeEntries(folder, depth);
    ::close(folder);
    if (::unlinkat(parent, name, AT_REMOVEDIR) == 0 || errno != ENOTEMPTY) return;
  }
}

void remove(const Entry& entry) {
  constexpr int kDepth = 16;
  switch (entry.kind) {
    case Kind::Process:
      awaitEnd(std::abs(entry.process));
      ::kill(entry.process, SIGKILL);
      awaitEnd(std::abs(entry.process));
      break;
    case Kind::File:
      ::unlink(entry.path.get());
      break;
    case Kind::Folder:
      removeFolder(AT_FDCWD, entry.path.get(), kDepth);
      break;
    case Kind::EmptyFolder:
      ::rmdir(entry.path.get());
      break;
  }
}

}  // namespace

HeldCleanup::HeldCleanup() {
  sigset_t all;
  sigfillset(&all);
  pthread_sigmask(SIG_BLOCK, &all, &blockedBefore);
  while (true) {
    ++holders;
    if (!cleaning) return;
    --holders;
    waitWhileCleaning();
  }
}

HeldCleanup::~HeldCleanup() {
  --holders;
  pthread_sigmask(SIG_SETMASK, &blockedBefore, nullptr);
}

Cleanup Cleanup::file(const std::filesystem::path& path) {
  return Cleanup(addEntry(Kind::File, path.string()));
}

Cleanup Cleanup::folder(const std::filesystem::path& path) {
  return Cleanup(addEntry(Kind::Folder, path.string()));
}

Cleanup Cleanup::emptyFolder(const std::filesystem::path& path) {
  return Cleanup(addEntry(Kind::EmptyFolder, path.string()));
}

Cleanup Cleanup::process(const HeldCleanup& /*held*/, int number) {
  return Cleanup(addEntry(Kind::Process, {}, number));
}

Cleanup::Cleanup(Cleanup&& other) noexcept : entry_(std::exchange(other.entry_, nullptr)) {}

Cleanup& Cleanup::operator=(Cleanup&& other) noexcept {
  if (this == &other) return *this;
  release();
  entry_ = std::exchange(other.entry_, nullptr);
  return *this;
}

void Cleanup::release() noexcept {
  if (entry_ == nullptr) return;
  waitWhileCleaning();
  change(*std::exchange(entry_, nullptr), State::Used, State::Free);
}

void cleanUp() noexcept {
  const int reason = errno;
  const pid_t self = ::getpid();
  cleaning = true;
  await([] { return holders == 0; });
  // All processes end at a time: each has the same second then.
  for (const Entry* entry = entries.load(); entry != nullptr; entry = entry->next) {
    if (entry->kind == Kind::Process && entry->owner == self && entry->state == State::Used) {
      ::kill(entry->process, SIGTERM);
    }
  }
  // What writes files goes before them, and files before the folder that is to be empty.
  for (const Kind kind : {Kind::Process, Kind::File, Kind::Folder, Kind::EmptyFolder}) {
    for (Entry* entry = entries.load(); entry != nullptr; entry = entry->next) {
      if (entry->kind == kind && entry->owner == self &&
          change(*entry, State::Used, State::Removing)) {
        remove(*entry);
      }
    }
  }
  cleaning = false;
  errno = reason;
}

}  // namespace t4d::platform
