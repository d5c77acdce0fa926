#include "platform/signals.h"

#include <array>
#include <csignal>
#include <filesystem>
#include <string>

#include <sys/prctl.h>
#include <unistd.h>

#include "platform/cleanup.h"
#include "platform/process.h"

namespace t4d::platform {
namespace {

extern "C" void cleanUpAndDie(int signal) {
  cleanUp();
  // Restore the default action and raise it again, so that our parent sees this signal.
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

/// If `t4d compare` runs this process, it ends with it, even by SIGKILL.
void endWithOwnParent() {
  const pid_t parent = ::getppid();
  const auto program = executablePath();
  std::error_code ignored;
  const auto itsProgram =
      std::filesystem::read_symlink("/proc/" + std::to_string(parent) + "/exe", ignored);
  if (program.empty() || itsProgram != program) return;
  ::prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (::getppid() != parent) std::raise(SIGTERM);
}

constexpr std::array kInterrupting = {SIGINT, SIGTERM, SIGHUP};
std::array<struct sigaction, kInterrupting.size()> before{};  // an Interruptible
std::atomic<bool> signalArrived = false;
volatile std::sig_atomic_t arrivedSignal = 0;

extern "C" void keepSignal(int signal) {
  arrivedSignal = signal;
  signalArrived = true;
}

}  // namespace

void cleanUpOnSignals() {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGQUIT}) {
    struct sigaction action {};
    if (::sigaction(signal, nullptr, &action) != 0 || action.sa_handler == SIG_IGN) continue;
    action = {};
    action.sa_handler = cleanUpAndDie;
    sigfillset(&action.sa_mask);
    ::sigaction(signal, &action, nullptr);
  }
  endWithOwnParent();
  // These become errors of writing.
  std::signal(SIGXFSZ, SIG_IGN);
  std::signal(SIGPIPE, SIG_IGN);
}

Interruptible::Interruptible() {
  for (std::size_t i = 0; i < kInterrupting.size(); ++i) {
    ::sigaction(kInterrupting[i], nullptr, &before[i]);
    if (before[i].sa_handler == SIG_IGN) continue;
    struct sigaction action {};
    action.sa_handler = keepSignal;
    ::sigaction(kInterrupting[i], &action, nullptr);
  }
}

Interruptible::~Interruptible() {
  for (std::size_t i = 0; i < kInterrupting.size(); ++i) {
    ::sigaction(kInterrupting[i], &before[i], nullptr);
  }
}

const std::atomic<bool>& Interruptible::interrupted() { return signalArrived; }

void Interruptible::endIfInterrupted() {
  if (signalArrived) std::raise(arrivedSignal);
}

}  // namespace t4d::platform
