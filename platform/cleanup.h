#pragma once

#include <filesystem>

namespace t4d::platform {

/// Held from before something is made until it is registered, so that cleanUp misses none: cleanUp
/// in another thread waits for it, and this thread receives no signals meanwhile. One at a time in
/// each thread.
class HeldCleanup {
 public:
  HeldCleanup();
  ~HeldCleanup();
  HeldCleanup(const HeldCleanup&) = delete;
  HeldCleanup& operator=(const HeldCleanup&) = delete;
};

/// Registers something that must not outlive this process. If a signal ends the process, no
/// destructor runs, but cleanUp removes what is registered. In all other cases the owner removes
/// it, and then releases the registration.
class Cleanup {
 public:
  /// Registers nothing.
  Cleanup() = default;
  static Cleanup file(const std::filesystem::path& path);
  /// Registers a folder with its contents.
  static Cleanup folder(const std::filesystem::path& path);
  /// Registers a folder that is removed only if it is empty.
  static Cleanup emptyFolder(const std::filesystem::path& path);
  /// Registers a child process or, if the number is negative, the process group that a child leads.
  /// Release the registration before waiting for the child, since the number may then belong to
  /// another process.
  static Cleanup process(const HeldCleanup& held, int number);

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

/// Ends all registered processes and removes all registered files and folders. Processes have a
/// second to end by themselves after SIGTERM. Async-signal-safe, so that handlers of signals that
/// end the process can call it; this library installs no handlers.
void cleanUp() noexcept;

}  // namespace t4d::platform
