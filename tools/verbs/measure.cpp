#include "tools/verbs/measure.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "t4d/mesh.h"
#include "tools/verbs/csv_field.h"
#include "tools/verbs/json_text.h"

namespace t4d::verbs {
namespace {

constexpr std::uint64_t kDefaultMeasures = 60;

nlohmann::ordered_json coordinatesOf(const model::Point3& point) {
  return {point.x(), point.y(), point.z()};
}

/// All but the time.
nlohmann::ordered_json jsonOf(const measure::SolidMeasures& sample) {
  const bool any = !sample.bounds.empty();
  return {{"volume", sample.volume},
          {"area", sample.area},
          {"centroid", any ? coordinatesOf(sample.centroid) : nlohmann::ordered_json()},
          {"components", sample.components},
          {"cavities", sample.cavities},
          {"genus", sample.genus},
          {"min", any ? coordinatesOf(sample.bounds.min) : nlohmann::ordered_json()},
          {"max", any ? coordinatesOf(sample.bounds.max) : nlohmann::ordered_json()}};
}

/// A row of the table; `before` and `behind` are fields with their commas.
std::string rowOf(const measure::SolidMeasures& sample, const std::string& before,
                  const std::string& behind) {
  const bool any = !sample.bounds.empty();
  const auto place = [&](const model::Point3& point) {
    return any ? fmt::format("{},{},{}", point.x(), point.y(), point.z()) : std::string(",,");
  };
  return fmt::format("{}{},{},{},{},{},{},{},{},{}{}\n", sample.time, before, sample.volume,
                     sample.area, place(sample.centroid), sample.components, sample.genus,
                     sample.cavities, place(sample.bounds.min), place(sample.bounds.max), behind);
}

}  // namespace

Result<MeasureReport> measure(const Input& input, const MeasureOptions& options,
                              Observer& observer) {
  std::vector<double> times = options.times;
  if (times.empty()) times = model::evenTimes(model::timeSpanOf(input.bodies), kDefaultMeasures);
  const model::PartRange range = options.part.of(times.size());
  const auto share = std::span(times).subspan(range.begin, range.end - range.begin);
  const auto stage = observer.stage("measuring", share.size(), "times");
  auto each = measure::measuresOfEach(input.bodies, share, stage->callback());
  if (!each) return inInput(each.error(), input);
  MeasureReport report{
      measure::addedUp(*each), {}, input.metadata.lengthUnit, input.metadata.timeUnit};
  for (std::size_t b = 0; options.eachBody && each->size() > 1 && b < each->size(); ++b) {
    report.bodies.push_back({input.bodies[b].name, std::move((*each)[b])});
  }
  return report;
}

std::string measuresCsv(const MeasureReport& report) {
  const bool several = !report.bodies.empty();
  std::string csv = fmt::format(
      "time,{}volume,area,cx,cy,cz,components,genus,cavities,min_x,min_y,min_z,max_x,max_y,max_z,"
      "length_unit,time_unit\n",
      several ? "body," : "");
  const std::string units =
      fmt::format(",{},{}", csvField(report.lengthUnit), csvField(report.timeUnit));
  for (std::size_t i = 0; i < report.samples.size(); ++i) {
    if (!several) csv += rowOf(report.samples[i], "", units);
    for (const BodyMeasures& body : report.bodies) {
      csv += rowOf(body.samples[i], "," + csvField(body.name), units);
    }
  }
  return csv;
}

std::string jsonOf(const MeasureReport& report) {
  using nlohmann::ordered_json;
  ordered_json value = {{"length_unit", report.lengthUnit},
                        {"time_unit", report.timeUnit},
                        {"samples", ordered_json::array()}};
  for (std::size_t i = 0; i < report.samples.size(); ++i) {
    ordered_json sample = {{"time", report.samples[i].time}};
    sample.update(jsonOf(report.samples[i]));
    for (const BodyMeasures& body : report.bodies) {
      ordered_json one = {{"name", body.name}};
      one.update(jsonOf(body.samples[i]));
      sample["bodies"].push_back(std::move(one));
    }
    value["samples"].push_back(std::move(sample));
  }
  return jsonText(value);
}

}  // namespace t4d::verbs
