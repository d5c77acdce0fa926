#include "t4d/verbs/measure.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "t4d/model/times.h"
#include "t4d/verbs/json_text.h"

namespace t4d::verbs {
namespace {

constexpr std::uint64_t kDefaultMeasures = 60;

nlohmann::ordered_json coordinatesOf(const model::Point3& point) {
  return {point.x(), point.y(), point.z()};
}

}  // namespace

Result<MeasureReport> measure(const Input& input, const MeasureOptions& options,
                              Observer& observer) {
  std::vector<double> times = options.times;
  if (times.empty()) times = model::evenTimes(model::timeSpanOf(input.bodies), kDefaultMeasures);
  const model::PartRange range = options.part.of(times.size());
  const auto share = std::span(times).subspan(range.begin, range.end - range.begin);
  const auto stage = observer.stage("measuring", share.size(), "times");
  auto samples = measure::measuresAt(input.bodies, share, stage->callback());
  if (!samples) return inInput(samples.error(), input);
  return MeasureReport{std::move(*samples)};
}

std::string measuresCsv(const MeasureReport& report) {
  std::string csv =
      "time,volume,area,cx,cy,cz,components,genus,cavities,min_x,min_y,min_z,max_x,max_y,max_z\n";
  for (const measure::SolidMeasures& sample : report.samples) {
    const bool any = !sample.bounds.empty();
    const auto place = [&](const model::Point3& point) {
      return any ? fmt::format("{},{},{}", point.x(), point.y(), point.z()) : std::string(",,");
    };
    csv += fmt::format("{},{},{},{},{},{},{},{},{}\n", sample.time, sample.volume, sample.area,
                       place(sample.centroid), sample.components, sample.genus, sample.cavities,
                       place(sample.bounds.min), place(sample.bounds.max));
  }
  return csv;
}

std::string jsonOf(const MeasureReport& report) {
  nlohmann::ordered_json value = {{"samples", nlohmann::ordered_json::array()}};
  for (const measure::SolidMeasures& sample : report.samples) {
    const bool any = !sample.bounds.empty();
    value["samples"].push_back(
        {{"time", sample.time},
         {"volume", sample.volume},
         {"area", sample.area},
         {"centroid", any ? coordinatesOf(sample.centroid) : nlohmann::ordered_json()},
         {"components", sample.components},
         {"cavities", sample.cavities},
         {"genus", sample.genus},
         {"min", any ? coordinatesOf(sample.bounds.min) : nlohmann::ordered_json()},
         {"max", any ? coordinatesOf(sample.bounds.max) : nlohmann::ordered_json()}});
  }
  return jsonText(value);
}

}  // namespace t4d::verbs
