#include "tools/program/signals.h"

#include <csignal>

#include <unistd.h>

#include "t4d/system/cleanup.h"

namespace t4d::tools {
namespace {

extern "C" void cleanUpAndDie(int signal) {
  system::cleanUp();
  // Whoever closed the other end of a pipe has read enough, as `head` does.
  if (signal == SIGPIPE) _exit(0);
  // Restore the default action and raise it again, so that our parent sees this signal.
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

}  // namespace

void cleanUpOnSignals() {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGPIPE}) {
    struct sigaction action {};
    if (sigaction(signal, nullptr, &action) != 0 || action.sa_handler == SIG_IGN) continue;
    action = {};
    action.sa_handler = cleanUpAndDie;
    sigfillset(&action.sa_mask);
    sigaction(signal, &action, nullptr);
  }
  std::signal(SIGXFSZ, SIG_IGN);
}

}  // namespace t4d::tools
