#include "tools/t4d/origin.h"

#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "model/units.h"

namespace t4d::tools {
namespace {

constexpr const char* kOriginKey = "origin";

}  // namespace

model::Point3 roundCenterOf(const model::Bounds3& bounds) {
  model::Point3 center = model::Point3::Zero();
  if (bounds.empty()) return center;
  const double extent = (bounds.max - bounds.min).maxCoeff();
  if (!(extent > 0)) return center;
  // Divided rather than multiplied by a fraction, which has no exact double.
  const double power = std::floor(std::log10(extent)) - 1;
  const double unit = std::pow(10.0, std::abs(power));
  for (int axis = 0; axis < 3; ++axis) {
    const double middle = bounds.min[axis] / 2 + bounds.max[axis] / 2;
    center[axis] =
        power < 0 ? std::nearbyint(middle * unit) / unit : std::nearbyint(middle / unit) * unit;
    if (!std::isfinite(center[axis])) center[axis] = middle;
  }
  return center;
}

model::Point3 originOf(const formats::Metadata& metadata) {
  const auto details = nlohmann::json::parse(metadata.detailsJson, nullptr, false);
  model::Point3 origin = model::Point3::Zero();
  if (!details.is_object() || !details.contains(kOriginKey)) return origin;
  const auto& numbers = details[kOriginKey];
  if (!numbers.is_array() || numbers.size() != 3) return origin;
  for (int axis = 0; axis < 3; ++axis) {
    const auto& number = numbers[static_cast<std::size_t>(axis)];
    if (!number.is_number()) return model::Point3::Zero();
    origin[axis] = number.get<double>();
  }
  return origin;
}

std::string withOrigin(const std::string& detailsJson, const model::Point3& origin) {
  if (origin.isZero(0)) return detailsJson;
  auto details = nlohmann::ordered_json::parse(detailsJson);
  details[kOriginKey] = {origin.x(), origin.y(), origin.z()};
  return details.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

formats::GltfPlacement placementOf(const formats::Metadata& metadata,
                                   std::vector<std::string>& notices) {
  formats::GltfPlacement placement;
  placement.zUp = metadata.up == "z";
  if (!metadata.lengthUnit.empty()) {
    if (const auto metres = model::metresPer(metadata.lengthUnit)) {
      placement.metresPerUnit = *metres;
    } else {
      notices.push_back(
          fmt::format("the length unit '{}' is unknown; it is written to glTF as a metre",
                      metadata.lengthUnit));
    }
  }
  nlohmann::ordered_json extras;
  if (!metadata.lengthUnit.empty()) extras["length_unit"] = metadata.lengthUnit;
  if (!metadata.timeUnit.empty()) extras["time_unit"] = metadata.timeUnit;
  if (!extras.empty()) placement.extras = extras.dump();
  return placement;
}

}  // namespace t4d::tools
