#pragma once

#include <filesystem>

#include <sys/types.h>

namespace t4d::system {

/// A note of something that must not outlive this process: where a signal ends it, no destructor
/// runs, and cleanUp does away with what notes there are of. The owner itself does that in all
/// other cases, and then lets go of the note.
class Cleanup {
 public:
  /// None.
  Cleanup() = default;
  static Cleanup file(const std::filesystem::path& path);
  /// A folder with all that is in it.
  static Cleanup folder(const std::filesystem::path& path);
  /// A folder that stays where there is something in it.
  static Cleanup emptyFolder(const std::filesystem::path& path);
  /// A child process, or with a negative number the process group that a child leads. To be
  /// released before the child is waited for: then its number cannot be another's.
  static Cleanup process(pid_t number);

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

/// Ends the processes and removes the files and folders that there are notes of. Processes may end
/// themselves within a second (SIGTERM). For handlers of signals that end the process: it is
/// async-signal-safe. This library installs no handlers.
void cleanUp() noexcept;

}  // namespace t4d::system
