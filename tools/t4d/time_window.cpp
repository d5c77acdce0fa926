#include "tools/t4d/time_window.h"

#include <fmt/format.h>

#include "tools/t4d/option_checks.h"

namespace t4d::tools {

void TimeWindow::addTo(CLI::App& command) {
  command.add_option("--from", from, "Start time (default: start of the mesh)")
      ->type_name("TIME")
      ->check(finiteNumber());
  command.add_option("--to", to, "End time (default: end of the mesh)")
      ->type_name("TIME")
      ->check(finiteNumber());
}

std::optional<std::string> TimeWindow::misuse() const {
  if (!from || !to || *from < *to) return std::nullopt;
  return fmt::format("--from {} is not before --to {}", *from, *to);
}

}  // namespace t4d::tools
