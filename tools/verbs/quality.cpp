#include "tools/verbs/quality.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <tuple>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "tools/verbs/exact_json.h"
#include "tools/verbs/json_text.h"
#include "tools/verbs/quality_parts.h"
#include "tools/verbs/time_scale.h"

namespace t4d::verbs {
namespace {

using measure::kQualityMeasures;
using nlohmann::ordered_json;

/// Infinite numbers become null.
ordered_json numberOrNull(double value) {
  return std::isfinite(value) ? ordered_json(value) : ordered_json();
}

ordered_json jsonOf(const measure::Distribution& values) {
  const auto ofCells = [&](double value) {
    return values.count() == 0 ? ordered_json() : numberOrNull(value);
  };
  return {{"min", ofCells(values.min())},
          {"p01", ofCells(values.quantile(0.01))},
          {"p50", ofCells(values.quantile(0.5))},
          {"p99", ofCells(values.quantile(0.99))},
          {"max", ofCells(values.max())}};
}

ordered_json jsonOf(const measure::MeshQuality& quality, const std::vector<std::string>& bodies) {
  ordered_json value = {{"cells", quality.cells()},
                        {"flat", quality.flat},
                        {"time_scale", quality.timeScale},
                        {"measures", ordered_json::object()},
                        {"sides", {{"cells", quality.sides[0].count()}}},
                        {"caps", {{"cells", quality.caps[0].count()}}},
                        {"worst", ordered_json::array()}};
  for (std::size_t k = 0; k < kQualityMeasures.size(); ++k) {
    const std::string name(kQualityMeasures[k].name);
    value["measures"][name] = jsonOf(quality.all(k));
    value["sides"]["measures"][name] = jsonOf(quality.sides[k]);
    value["caps"]["measures"][name] = jsonOf(quality.caps[k]);
  }
  for (const measure::RankedCell& cell : quality.worst) {
    ordered_json one = {{"body", bodies[cell.body]},
                        {"slab", cell.slab},
                        {"cell", cell.cell},
                        {"time", cell.center[3]},
                        {"point", {cell.center[0], cell.center[1], cell.center[2]}}};
    for (const auto& [name, member] : kQualityMeasures) {
      one[std::string(name)] = numberOrNull(cell.quality.*member);
    }
    value["worst"].push_back(std::move(one));
  }
  return value;
}

/// Whether float32 takes the smallest or the largest value for 0 or for infinite.
bool exceedsSingle(const measure::Distribution& values) {
  const measure::Distribution some = values.positiveAndFinite();
  return some.count() > 0 && (some.min() < std::numeric_limits<float>::min() ||
                              some.max() > std::numeric_limits<float>::max());
}

/// The measures to write, with a note for each that float32 cannot hold.
Result<std::vector<measure::QualityMeasure>> measuresToWrite(const QualityOptions& options,
                                                             const measure::MeshQuality& quality,
                                                             Observer& observer) {
  std::vector<std::string> wanted = options.attributes;
  if (wanted.empty()) wanted.emplace_back("radius_ratio");
  std::vector<measure::QualityMeasure> measures;
  for (std::size_t k = 0; k < kQualityMeasures.size(); ++k) {
    const measure::QualityMeasure& one = kQualityMeasures[k];
    if (std::erase(wanted, one.name) == 0) continue;
    measures.push_back(one);
    if (exceedsSingle(quality.all(k))) {
      observer.note(
          fmt::format("{}: some values are too small or too large for float32; they are "
                      "written as 0 or as infinite",
                      one.name));
    }
  }
  if (!wanted.empty()) {
    return fail(ErrorCode::Options, fmt::format("no measure has the name '{}'", wanted.front()));
  }
  return measures;
}

/// Writes the mesh with measures as attributes.
Result<void> write(const QualityOptions& options, const Input& input, QualityReport& report,
                   Observer& observer) {
  const auto measures = measuresToWrite(options, report.quality, observer);
  if (!measures) return measures.error();
  auto writer = formats::T4dWriter::create(options.output, metadataOf(input, options.generator),
                                           {.compression = options.compression});
  if (!writer) return writer.error();
  const auto stage =
      observer.stage("writing " + options.output, slabCountOf(input.bodies), "slabs");
  std::set<std::string> replaced;
  for (std::size_t b = 0; b < input.bodies.size(); ++b) {
    const model::Source& source = *input.bodies[b].source;
    measure::QualitySink with(*measures, report.quality.timeScale, writer->body(b));
    if (auto put = model::pump(source, with, stage->part(source.slabCount())); !put) return put;
    replaced.insert(with.replaced().begin(), with.replaced().end());
  }
  if (!replaced.empty()) {
    observer.note(fmt::format("the file had {}; {} replaced", fmt::join(replaced, ", "),
                              replaced.size() == 1 ? "it is" : "they are"));
  }
  const auto bytes = finishEdited(*writer, input);
  if (!bytes) return bytes.error();
  report.bytes = *bytes;
  report.losses = writer->losses();
  return {};
}

Result<QualityReport> measureAndWrite(const Input& input, const QualityOptions& options,
                                      Observer& observer) {
  const auto scale = timeScaleOf(options.timeScale, input, observer);
  if (!scale) return scale.error();
  const auto part = partOf(input, options.part);
  if (!part) return part.error();
  auto quality = [&] {
    const auto stage = observer.stage("measuring cells", slabCountOf(part->bodies), "slabs");
    return measure::measureQuality(
        part->bodies, {.timeScale = scale->value, .worst = options.worst}, stage->callback());
  }();
  if (!quality) return quality.error();
  for (measure::RankedCell& cell : quality->worst) {
    cell.slab += options.part.of(input.bodies[cell.body].source->slabCount()).begin;
  }
  QualityReport report{std::move(*quality), scale->reason, {}};
  for (const model::Body& body : input.bodies) report.bodies.push_back(body.name);
  if (!options.output.empty()) {
    if (auto done = write(options, *part, report, observer); !done) return done.error();
  }
  return report;
}

}  // namespace

Result<QualityReport> quality(const Input& input, const QualityOptions& options,
                              Observer& observer) {
  auto report = measureAndWrite(input, options, observer);
  if (!report) return inInput(report.error(), input);
  return report;
}

namespace {

ordered_json stateOf(const measure::Distribution& values) {
  auto bins = ordered_json::array();
  for (const auto& [number, count] : values.bins()) bins.push_back({number, count});
  return {{"min", exact(values.min())}, {"max", exact(values.max())}, {"bins", std::move(bins)}};
}

measure::Distribution distributionOf(const ordered_json& state) {
  std::vector<measure::Distribution::Bin> bins;
  for (const ordered_json& bin : state.at("bins")) bins.push_back({bin.at(0), bin.at(1)});
  const auto made =
      measure::Distribution::of(bins, exactDouble(state.at("min")), exactDouble(state.at("max")));
  if (!made) throw ordered_json::other_error::create(600, "a bin that there is not", &state);
  return *made;
}

/// Larger ratios first, of which null is infinite; equal ones as in the file.
bool isWorse(const ordered_json& a, const ordered_json& b, const std::vector<std::string>& bodies) {
  const auto keyOf = [&](const ordered_json& cell) {
    const ordered_json& ratio = cell.at("radius_ratio");
    const double value =
        ratio.is_null() ? std::numeric_limits<double>::infinity() : ratio.get<double>();
    const auto body = std::ranges::find(bodies, cell.at("body").get<std::string>());
    return std::tuple(-value, body - bodies.begin(), cell.at("slab").get<std::uint64_t>(),
                      cell.at("cell").get<std::uint64_t>());
  };
  return keyOf(a) < keyOf(b);
}

}  // namespace

std::string partStateOf(const QualityReport& report) {
  ordered_json state = {
      {"bodies", report.bodies}, {"sides", ordered_json::array()}, {"caps", ordered_json::array()}};
  for (std::size_t k = 0; k < kQualityMeasures.size(); ++k) {
    state["sides"].push_back(stateOf(report.quality.sides[k]));
    state["caps"].push_back(stateOf(report.quality.caps[k]));
  }
  return state.dump(-1, ' ', false, ordered_json::error_handler_t::replace);
}

ordered_json joinedQuality(const std::vector<ordered_json>& reports, std::uint64_t worst) {
  measure::MeshQuality all;
  std::vector<ordered_json> cells;
  const std::vector<std::string> bodies = reports.front().at("part").at("state").at("bodies");
  for (const ordered_json& report : reports) {
    const ordered_json& state = report.at("part").at("state");
    for (std::size_t k = 0; k < kQualityMeasures.size(); ++k) {
      all.sides[k].add(distributionOf(state.at("sides").at(k)));
      all.caps[k].add(distributionOf(state.at("caps").at(k)));
    }
    all.flat += report.at("flat").get<std::uint64_t>();
    for (const ordered_json& cell : report.at("worst")) cells.push_back(cell);
  }
  std::ranges::stable_sort(
      cells, [&](const ordered_json& a, const ordered_json& b) { return isWorse(a, b, bodies); });
  if (cells.size() > worst) cells.resize(worst);
  ordered_json value = jsonOf(all, bodies);
  value["time_scale"] = reports.front().at("time_scale");
  value["worst"] = cells;
  value["bytes"] = nullptr;
  return value;
}

std::string jsonOf(const QualityReport& report) {
  ordered_json value = jsonOf(report.quality, report.bodies);
  value["bytes"] = orNull(report.bytes);
  return jsonText(value);
}

}  // namespace t4d::verbs
