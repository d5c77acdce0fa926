#include <exception>
#include <new>

#include <fmt/format.h>

#include "tools/commands.h"
#include "tools/console.h"
#include "tools/signals.h"
#include "tools/version.h"

int main(int argc, char** argv) try {
  using namespace t4d::tools;
  cleanUpOnSignals();
  CLI::App app(
      "t4d: 4D meshes, the boundary of a moving solid in space-time (x, y, z, t).\n"
      "Sweep a solid along a motion, keep the result as .t4d, slice it, play it, prove it right.");
  app.name("t4d");
  app.require_subcommand(1);
  app.get_formatter()->column_width(34);
  app.set_version_flag("--version", std::string(versionText()));
  app.footer(
      "Example:\n"
      "  t4d sweep bolt.obj --motion screw-in.json -o bolt.t4d\n"
      "  t4d slice bolt.t4d --time 2.5 -o bolt-at-2.5.glb\n\n"
      "Exit codes: 0 done, 1 failed, 2 wrong usage, 3 done with loss, 4 the input is invalid.\n"
      "`t4d VERB --help` says more.");
  int exitCode = kDone;
  addSweep(app, exitCode);
  addWeave(app, exitCode);
  addVoxelize(app, exitCode);
  addRasterize(app, exitCode);
  addSlice(app, exitCode);
  addFlipbook(app, exitCode);
  addInfo(app, exitCode);
  addValidate(app, exitCode);
  addRecover(app, exitCode);
  addCompare(app, exitCode);
  addConform(app, exitCode);
  addVersion(app, exitCode);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    // Of a mistyped verb or option CLI11 only says that one is missing.
    if (error.get_exit_code() != 0 && error.get_name() != "ExtrasError") {
      for (const std::string& word : app.remaining(true)) {
        fmt::print(stderr, "t4d: not understood: {}\n", word);
      }
    }
    return app.exit(error) == 0 ? kDone : kUsage;
  }
  return exitCode;
} catch (const std::bad_alloc&) {
  fmt::print(stderr, "t4d: out of memory\n");
  return t4d::tools::kFailed;
} catch (const std::exception& error) {
  fmt::print(stderr, "t4d: {}\n", error.what());
  return t4d::tools::kFailed;
}
