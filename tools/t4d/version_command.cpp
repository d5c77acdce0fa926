#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "formats/t4d/layout.h"
#include "tools/t4d/commands.h"
#include "tools/t4d/console.h"
#include "tools/t4d/version.h"

namespace t4d::tools {

void addVersion(CLI::App& app, int& exitCode) {
  auto* command = app.add_subcommand("version", "Print the version and how the program was built");
  auto json = std::make_shared<bool>(false);
  command->add_flag("--json", *json, "Print JSON");
  command->footer("Example:\n  t4d version");
  command->callback([=, &exitCode] {
    const std::string format = fmt::format("{}.{}", formats::t4d_layout::kMajorVersion,
                                           formats::t4d_layout::kMinorVersion);
    const bool tetgen = T4D_WITH_TETGEN != 0;
    if (*json) {
      printJson({{"version", kVersion}, {"format_version", format}, {"tetgen", tetgen}});
    } else {
      print("{}\nformat .t4d {}\n{}\n", versionText(), format,
            tetgen ? "with TetGen: this binary as a whole is under AGPL-3.0"
                   : "without TetGen: close ends with --caps cone");
    }
    exitCode = kDone;
  });
}

}  // namespace t4d::tools
