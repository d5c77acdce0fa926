#include "tools/t4d/input_options.h"

#include "tools/t4d/option_checks.h"

namespace t4d::tools {

void InputOptions::addTo(CLI::App& command) {
  command.add_option("--body", bodies, "Use only this body; repeatable (default: all)")
      ->type_name("NAME")
      ->allow_extra_args(false)
      ->check(someName());
  addMaxCellsOption(command, maxCells);
}

void addMaxCellsOption(CLI::App& command, std::optional<std::uint64_t>& maxCells) {
  command
      .add_option("--max-cells", maxCells,
                  "Maximum number of cells to accept (default: see docs/limits.md)")
      ->type_name("N");
}

}  // namespace t4d::tools
