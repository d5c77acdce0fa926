#pragma once

#include <csignal>
#include <filesystem>

#include <sys/types.h>

namespace t4d::system {

/// Held from before a process is started until it is registered, so that none is forgotten: a
/// cleanUp in another thread waits for that, and this thread takes no signals meanwhile.
class StartingProcess {
 public:
  StartingProcess();
  ~StartingProcess();
  StartingProcess(const StartingProcess&) = delete;
  StartingProcess& operator=(const StartingProcess&) = delete;

 private:
  sigset_t before_{};
};

/// Registers something that must not outlive this process, for cleanUp: no destructor runs if a
/// signal ends the process. In all other cases the owner removes it, and then releases the note.
class Cleanup {
 public:
  /// Registers nothing.
  Cleanup() = default;
  static Cleanup file(const std::filesystem::path& path);
  /// A folder with its contents.
  static Cleanup folder(const std::filesystem::path& path);
  /// A folder that is removed only if it is empty.
  static Cleanup emptyFolder(const std::filesystem::path& path);
  /// A child process or, if the number is negative, the process group that a child leads. Release
  /// it before waiting for the child, after which the number may belong to another process.
  static Cleanup process(const StartingProcess& held, pid_t number);

  Cleanup(Cleanup&& other) noexcept;
  Cleanup& operator=(Cleanup&& other) noexcept;
  ~Cleanup() { release(); }

  explicit operator bool() const { return entry_ != nullptr; }
  void release() noexcept;

  struct Entry;  // what cleanUp knows

 private:
  explicit Cleanup(Entry* entry) : entry_(entry) {}

  Entry* entry_ = nullptr;
};

/// Ends all registered processes and removes all registered files and folders. Processes get a
/// second to end by themselves after SIGTERM. Async-signal-safe, for the handlers of signals that
/// end the process; this library installs none.
void cleanUp() noexcept;

}  // namespace t4d::system
