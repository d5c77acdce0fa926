#include "tools/t4d/motion_options.h"

#include <utility>

#include "model/units.h"

namespace t4d::tools {
namespace {

CLI::Validator knownUnit(bool ofLength) {
  return {[ofLength](const std::string& unit) {
            const bool known = ofLength ? model::metresPer(unit).has_value()
                                        : model::timeConversion(unit, "s").has_value();
            return known ? std::string()
                         : "'" + unit + "' is not a unit of " + (ofLength ? "length" : "time") +
                               (ofLength ? ": nm, um, mm, cm, dm, m, km, in, ft, yd"
                                         : ": ns, us, ms, s, min, h, d");
          },
          ""};
}

}  // namespace

void MotionOptions::addTo(CLI::App& command) {
  command
      .add_option(
          "--angles", table.angles,
          "Angles in a table of poses: roll, pitch, yaw or rotation vectors, and their unit")
      ->check(CLI::IsMember({"rpy:deg", "rpy:rad", "rotvec:deg", "rotvec:rad"}));
  command
      .add_option("--quaternion", table.quaternion,
                  "Order of quaternions in a table of poses whose columns do not name it")
      ->check(CLI::IsMember({"xyzw", "wxyz"}));
  command
      .add_option("--length-unit", table.lengthUnit,
                  "Unit of the solid and of positions in a table; columns that name one are "
                  "converted")
      ->type_name("UNIT")
      ->check(knownUnit(true));
  command
      .add_option("--time-unit", table.timeUnit,
                  "Unit of times in a table; columns that name one are converted")
      ->type_name("UNIT")
      ->check(knownUnit(false));
}

std::vector<std::string> MotionOptions::arguments() const {
  std::vector<std::string> all;
  for (const auto& [option, value] :
       {std::pair{"--angles", &table.angles}, std::pair{"--quaternion", &table.quaternion},
        std::pair{"--length-unit", &table.lengthUnit}, std::pair{"--time-unit", &table.timeUnit}}) {
    if (value->empty()) continue;
    all.emplace_back(option);
    all.push_back(*value);
  }
  return all;
}

}  // namespace t4d::tools
