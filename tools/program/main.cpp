#include <cerrno>
#include <cstdio>
#include <cstring>
#include <exception>
#include <new>

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include "tools/program/commands.h"
#include "tools/program/console.h"
#include "tools/program/signals.h"
#include "tools/program/version.h"

namespace t4d::tools {
namespace {

/// Prevents files that we open from getting the number of a closed standard stream: messages would
/// be written to them. Writing to a closed stream stays an error.
void keepStandardStreams() {
  for (const int number : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (fcntl(number, F_GETFD) >= 0) continue;
    // open() returns the lowest free number, which is this one.
    const int opened = open("/dev/null", number == STDIN_FILENO ? O_WRONLY : O_RDONLY);
    if (opened < 0) return;
  }
}

/// The last verb recognised in the arguments.
const CLI::App& lastCommand(const CLI::App& app) {
  const std::vector<CLI::App*> chosen = app.get_subcommands();
  return chosen.empty() ? app : lastCommand(*chosen.front());
}

int run(int argc, char** argv) {
  CLI::App app(
      "t4d: 4D meshes, the boundary of a moving solid in space-time (x, y, z, t).\n"
      "Sweep a solid along a motion, save the result as .t4d, slice it, animate it, check it.");
  app.name("t4d");
  app.require_subcommand(1);
  app.get_formatter()->column_width(34);
  app.set_version_flag("--version", std::string(versionText()));
  app.footer(
      "Example:\n"
      "  t4d sweep bolt.obj --motion screw-in.json -o bolt.t4d\n"
      "  t4d slice bolt.t4d --time 2.5 -o bolt-at-2.5.glb\n\n"
      "Exit codes: 0 done, 1 failed, 2 wrong usage, 3 done with loss, 4 the input is invalid.\n"
      "`t4d VERB --help` prints the options of a verb.");
  int exitCode = kDone;
  addVerbs(app, exitCode);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() != 0) {
      const std::vector<std::string> unknown = app.remaining(true);
      const CLI::App& last = lastCommand(app);
      const bool isVerb = unknown.empty() || !unknown.front().starts_with('-');
      if (last.get_require_subcommand_min() > 0 && isVerb) {
        return wrongUsage(wrongVerb(last, unknown.empty() ? std::string() : unknown.front()));
      }
      // If something else is missing, CLI11 reports only that.
      if (error.get_name() != "ExtrasError") {
        for (const std::string& word : unknown) say("not understood: " + word);
      }
    }
    return app.exit(error) == 0 ? kDone : kUsage;
  }
  return exitCode;
}

/// A run whose results did not reach standard output has failed.
int exitCodeOf(int exitCode) {
  errno = 0;
  const bool flushed = std::fflush(stdout) == 0;
  if (flushed && std::ferror(stdout) == 0) return exitCode;
  say(errno == 0 ? "cannot write to standard output"
                 : fmt::format("cannot write to standard output: {}", std::strerror(errno)));
  return exitCode == kDone || exitCode == kLoss ? kFailed : exitCode;
}

}  // namespace
}  // namespace t4d::tools

int main(int argc, char** argv) {
  using namespace t4d::tools;
  keepStandardStreams();
  cleanUpOnSignals();
  int exitCode = kFailed;
  try {
    exitCode = run(argc, argv);
  } catch (const std::bad_alloc&) {
    say("out of memory");
  } catch (const std::exception& error) {
    if (std::ferror(stdout) == 0) say(error.what());
  }
  return exitCodeOf(exitCode);
}
