#include "tools/t4d/mending.h"

#include "tools/t4d/option_checks.h"

namespace t4d::tools {

void MendingOptions::addTo(CLI::App& command) {
  command
      .add_option("--weld", limits.weld,
                  "Merge vertices within this distance per axis (default: only equal ones)")
      ->type_name("DISTANCE")
      ->check(numberAboveZero());
  command
      .add_option("--max-hole", limits.maxHole,
                  "Maximum width of holes to fill (default: fill all)")
      ->type_name("WIDTH")
      ->check(numberAboveZero());
  command
      .add_option(
          "--thicken", limits.thicken,
          "Give sheets this thickness: open parts that enclose nothing when they are closed")
      ->type_name("DISTANCE")
      ->check(numberAboveZero());
  command
      .add_option("--max-move", limits.maxMove,
                  "Fail if the result is farther than this from the input surface")
      ->type_name("DISTANCE")
      ->check(numberAboveZero());
  command
      .add_option("--remesh", limits.remesh,
                  "Remesh with voxels of this size if nothing else helps")
      ->type_name("SIZE")
      ->check(numberAboveZero());
}

void MendingOptions::addTo(CLI::App& command, bool& mend) {
  auto* flag = command.add_flag("--mend", mend, "Mend the solid first (see t4d mend)");
  addTo(command);
  for (const char* name : {"--weld", "--max-hole", "--thicken", "--max-move", "--remesh"}) {
    command.get_option(name)->needs(flag);
  }
}

std::optional<edit::MendSurfaceOptions> MendingOptions::given(bool mend) const {
  return mend ? std::optional(limits) : std::nullopt;
}

}  // namespace t4d::tools
