#include "tools/t4d/signals.h"

#include <csignal>
#include <filesystem>
#include <string>

#include <sys/prctl.h>
#include <unistd.h>

#include "platform/cleanup.h"

namespace t4d::tools {
namespace {

extern "C" void cleanUpAndDie(int signal) {
  platform::cleanUp();
  // Restore the default action and raise it again, so that our parent sees this signal.
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

/// The executable of a process; empty if it is not known.
std::filesystem::path programOf(const std::string& process) {
  std::error_code ignored;
  return std::filesystem::read_symlink("/proc/" + process + "/exe", ignored);
}

/// If `t4d compare` runs this process, it ends with it, even by SIGKILL.
void endWithOwnParent() {
  const pid_t parent = getppid();
  const auto program = programOf("self");
  if (program.empty() || programOf(std::to_string(parent)) != program) return;
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (getppid() != parent) std::raise(SIGTERM);
}

}  // namespace

void cleanUpOnSignals() {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGQUIT}) {
    struct sigaction action {};
    if (sigaction(signal, nullptr, &action) != 0 || action.sa_handler == SIG_IGN) continue;
    action = {};
    action.sa_handler = cleanUpAndDie;
    sigfillset(&action.sa_mask);
    sigaction(signal, &action, nullptr);
  }
  endWithOwnParent();
  // These become errors of writing.
  std::signal(SIGXFSZ, SIG_IGN);
  std::signal(SIGPIPE, SIG_IGN);
}

}  // namespace t4d::tools
