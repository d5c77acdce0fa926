#include "tools/t4d/centering.h"

#include <algorithm>

#include "tools/t4d/console.h"

namespace t4d::tools {

void addCenterOption(CLI::App& command, bool& center) {
  command.add_flag("--center", center,
                   "Center the solid at the origin (for coordinates too large for float32)");
}

int reportLosses(const std::vector<std::string>& losses, bool centered) {
  const int code = reportLosses(losses);
  const auto ofShape = [](const std::string& loss) { return loss.starts_with("shape: "); };
  if (!centered && std::ranges::any_of(losses, ofShape)) sayHint("try: --center");
  return code;
}

}  // namespace t4d::tools
