#include "tools/t4d/version.h"

#include <fmt/format.h>

#include "formats/t4d/layout.h"
#include "tools/t4d/commands.h"
#include "tools/t4d/console.h"
#include "tools/t4d/json_option.h"

namespace t4d::tools {
namespace {

struct BuildReport {
  std::string version = std::string(kVersion);
  std::string format =
      fmt::format("{}.{}", formats::t4d_layout::kMajorVersion, formats::t4d_layout::kMinorVersion);
  bool tetgen = T4D_WITH_TETGEN != 0;
};

void describe(Members& members, const BuildReport& build) {
  members("version", build.version, "Version of the program (Semantic Versioning).")
      .pattern("^[0-9]+\\.[0-9]+\\.[0-9]+");
  members("format_version", build.format, "Version of the .t4d files that this program writes.")
      .pattern("^[0-9]+\\.[0-9]+$");
  members("tetgen", build.tetgen,
          "Whether the program was built with TetGen, which can close the ends of a sweep; the "
          "binary as a whole is then under AGPL-3.0.");
}

}  // namespace

void addVersion(CLI::App& app, int& exitCode) {
  auto* command = app.add_subcommand("version", "Print the version and how the program was built");
  auto json = std::make_shared<bool>(false);
  addJsonOption<BuildReport>(*command, *json, "The version of the program and how it was built.");
  command->footer("Example:\n  t4d version");
  command->callback([=, &exitCode] {
    const BuildReport build;
    if (*json) {
      printAsJson(build);
    } else {
      print("{}\nformat .t4d {}\n{}\n", versionText(), build.format,
            build.tetgen ? "with TetGen: this binary as a whole is under AGPL-3.0"
                         : "without TetGen: close ends with --caps cone");
    }
    exitCode = kDone;
  });
}

}  // namespace t4d::tools
