#pragma once

#include <atomic>

/// The handling of signals in a program. The library calls none of this.
namespace t4d::platform {

/// From here on, a signal that ends the program (Ctrl-C, say) first removes partly written files
/// and ends the processes that the program has started (cleanUp); then the program ends by that
/// signal. A signal that is ignored stays ignored (nohup). Exceeding the file size limit is a write
/// error, not a signal. A process that this program runs as another copy of itself ends with it.
void cleanUpOnSignals();

/// While it exists, SIGINT, SIGTERM and SIGHUP set a flag and do nothing else. There can be one at
/// a time.
class Interruptible {
 public:
  Interruptible();
  ~Interruptible();
  Interruptible(const Interruptible&) = delete;
  Interruptible& operator=(const Interruptible&) = delete;

  /// Becomes true when such a signal arrives.
  static const std::atomic<bool>& interrupted();
  /// Ends this program as the signal would have, if one has arrived.
  static void endIfInterrupted();
};

}  // namespace t4d::platform
