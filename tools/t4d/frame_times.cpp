#include "tools/t4d/frame_times.h"

#include <algorithm>

#include <nlohmann/json.hpp>

namespace t4d::tools {

std::vector<double> frameTimesOf(const Input& input) {
  std::vector<double> times;
  for (const model::Body& body : input.bodies) {
    for (std::size_t i = 0; i < body.source->slabCount(); ++i) {
      const model::TimeSpan span = body.source->timeSpan(i);
      times.push_back(span.begin);
      times.push_back(span.end);
    }
  }
  std::ranges::sort(times);
  times.erase(std::ranges::unique(times).begin(), times.end());
  const auto details = nlohmann::json::parse(input.metadata.detailsJson, nullptr, false);
  if (!details.is_object() || !details.contains("parameters")) return times;
  const nlohmann::json& parameters = details["parameters"];
  if (!parameters.is_object()) return times;
  if (parameters.value("caps", nlohmann::json()) == "half-step" && times.size() > 3) {
    times.erase(times.begin());
    times.pop_back();
  }
  const nlohmann::json steps = parameters.value("substeps", nlohmann::json());
  if (!steps.is_number_unsigned() || steps.get<std::size_t>() < 2) return times;
  std::vector<double> frames;
  for (std::size_t i = 0; i < times.size(); i += steps.get<std::size_t>()) {
    frames.push_back(times[i]);
  }
  return frames;
}

}  // namespace t4d::tools
