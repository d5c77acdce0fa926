#pragma once

#include <array>
#include <atomic>
#include <csignal>
#include <string>

#include "t4d/model/error.h"

/// Shared by the verbs that run readers and writers under test.
namespace t4d::tools {

/// While it exists, a signal that would end this program stops those under test instead.
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

 private:
  static constexpr std::array kSignals = {SIGINT, SIGTERM, SIGHUP};
  std::array<struct sigaction, kSignals.size()> before_{};
};

/// Without this, a program that crashes a hundred times would leave a hundred core dumps.
void disableCoreDumps();

Result<void> writeReport(const std::string& path, const std::string& text);

}  // namespace t4d::tools
