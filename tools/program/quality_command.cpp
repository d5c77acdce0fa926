#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "t4d/formats/t4d/writer.h"
#include "t4d/measure/mesh_quality.h"
#include "tools/program/commands.h"
#include "tools/program/console.h"
#include "tools/program/input_bodies.h"
#include "tools/program/option_checks.h"
#include "tools/program/or_null.h"
#include "tools/program/progress_bar.h"
#include "tools/program/t4d_output.h"

namespace t4d::tools {
namespace {

using measure::kQualityMeasures;
using nlohmann::ordered_json;

struct QualityArguments {
  std::string input;
  InputOptions only;
  std::optional<double> timeScale;
  std::uint64_t worst = 10;
  std::string output;
  std::vector<std::string> attributes = {"radius_ratio"};
  int compression = 3;
  bool json = false;
};

/// Infinite numbers become null.
ordered_json numberOrNull(double value) {
  return std::isfinite(value) ? ordered_json(value) : ordered_json();
}

ordered_json jsonOf(const measure::Distribution& values) {
  return {{"min", numberOrNull(values.min())},
          {"p01", numberOrNull(values.quantile(0.01))},
          {"p50", numberOrNull(values.quantile(0.5))},
          {"p99", numberOrNull(values.quantile(0.99))},
          {"max", numberOrNull(values.max())}};
}

ordered_json jsonOf(const measure::MeshQuality& quality, const InputBodies& input) {
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
    ordered_json one = {{"body", input.bodies[cell.body].name},
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

void printTableOf(const std::string& title,
                  const std::array<measure::Distribution, kQualityMeasures.size()>& distributions) {
  const std::uint64_t cells = distributions[0].count();
  if (cells == 0) return;
  print("  {} of {}\n", counted(cells, "cell", "cells"), title);
  static constexpr std::array kTitles = {"volume",         "edge ratio",    "radius ratio",
                                         "smallest angle", "largest angle", "height"};
  std::vector<std::vector<std::string>> rows = {{"  ", "min", "1 %", "50 %", "99 %", "max"}};
  for (std::size_t k = 0; k < distributions.size(); ++k) {
    const measure::Distribution& values = distributions[k];
    std::vector<std::string> row = {std::string("  ") + kTitles[k]};
    for (const double number : {values.min(), values.quantile(0.01), values.quantile(0.5),
                                values.quantile(0.99), values.max()}) {
      row.push_back(fmt::format("{:.4g}", number));
    }
    rows.push_back(std::move(row));
  }
  printTable(rows, "l");
}

void printText(const measure::MeshQuality& quality, const std::string& scale,
               const InputBodies& input) {
  print("{}: {}, 1 unit of time as {:.4g} of length ({})\n", input.reader.name(),
        counted(quality.cells(), "cell", "cells"), quality.timeScale, scale);
  printTableOf("slabs that last", quality.sides);
  printTableOf("caps", quality.caps);
  if (quality.flat > 0) {
    print("  {} without volume\n", counted(quality.flat, "cell", "cells"));
  }
  if (quality.worst.empty()) return;
  print("  largest radius ratios\n");
  std::vector<std::vector<std::string>> rows = {
      {"  ratio", "body", "slab", "cell", "time", "point"}};
  for (const measure::RankedCell& cell : quality.worst) {
    rows.push_back(
        {fmt::format("  {:.4g}", cell.quality.radiusRatio), input.bodies[cell.body].name,
         grouped(cell.slab), grouped(cell.cell), fmt::format("{:.6g}", cell.center[3]),
         fmt::format("({:.4g}, {:.4g}, {:.4g})", cell.center[0], cell.center[1], cell.center[2])});
  }
  printTable(rows, "lllllr");
}

/// The scale between space and time: as asked for, or from the speed of the solid.
struct Scale {
  double value = 1;
  std::string reason;
};
Result<Scale> scaleOf(const QualityArguments& options, const InputBodies& input) {
  if (options.timeScale) return Scale{*options.timeScale, "--time-scale"};
  ProgressBar bar("measuring the speed", slabCountOf(input.bodies), "slabs");
  const auto speed = measure::meanNormalSpeed(input.bodies, bar.callback());
  if (!speed) return pass(speed.error());
  if (*speed > 0) return Scale{*speed, "the mean normal speed"};
  const model::TimeSpan span = model::timeSpanOf(input.bodies);
  const model::Bounds3 bounds = boundsOf(input);
  const double size = bounds.empty() ? 0 : (bounds.max - bounds.min).norm();
  if (!(span.end > span.begin && size > 0)) return Scale{1, "nothing moves or lasts"};
  return Scale{size / (span.end - span.begin), "nothing moves; the size divided by the duration"};
}

/// Adds the measures to slabs, and passes them on.
class QualitySink : public model::Sink {
 public:
  QualitySink(std::span<const measure::QualityMeasure> measures, double timeScale,
              model::Sink& next)
      : measures_(measures), timeScale_(timeScale), next_(next) {}
  Result<void> put(const model::Slab& slab) override {
    return next_.put(measure::withQuality(slab, measures_, timeScale_));
  }

 private:
  std::span<const measure::QualityMeasure> measures_;
  double timeScale_;
  model::Sink& next_;
};

/// Writes the mesh with the measures as attributes. Returns the size of the file.
Result<std::uint64_t> write(const QualityArguments& options, const InputBodies& input,
                            double timeScale) {
  std::vector<measure::QualityMeasure> measures;
  for (const measure::QualityMeasure& one : kQualityMeasures) {
    if (std::ranges::find(options.attributes, one.name) != options.attributes.end()) {
      measures.push_back(one);
    }
  }
  auto writer = formats::T4dWriter::create(options.output, metadataOf(input),
                                           {.compression = options.compression});
  if (!writer) return pass(writer.error());
  ProgressBar bar("writing " + options.output, slabCountOf(input.bodies), "slabs");
  for (std::size_t b = 0; b < input.bodies.size(); ++b) {
    const model::Source& source = *input.bodies[b].source;
    QualitySink with(measures, timeScale, writer->body(b));
    if (auto put = model::pump(source, with, bar.part(source.slabCount())); !put) {
      return pass(put.error());
    }
  }
  return writer->finish();
}

int run(const QualityArguments& options) {
  if (!options.output.empty()) {
    if (const auto misuse = misuseOfOutput(options.output, {&options.input, 1})) {
      return wrongUsage(*misuse);
    }
  }
  const auto input = openBodies(options.input, options.only);
  if (!input) return report(input.error());
  const auto scale = scaleOf(options, *input);
  if (!scale) return report(inInput(scale.error(), *input));
  const auto quality = [&] {
    ProgressBar bar("measuring cells", slabCountOf(input->bodies), "slabs");
    return measure::measureQuality(
        input->bodies, {.timeScale = scale->value, .worst = options.worst}, bar.callback());
  }();
  if (!quality) return report(inInput(quality.error(), *input));
  std::optional<std::uint64_t> bytes;
  if (!options.output.empty()) {
    const auto written = write(options, *input, scale->value);
    if (!written) return report(inInput(written.error(), *input));
    bytes = *written;
  }
  if (options.json) {
    ordered_json value = jsonOf(*quality, *input);
    value["bytes"] = orNull(bytes);
    printJson(value);
    return kDone;
  }
  printText(*quality, scale->reason, *input);
  if (bytes) print("  {}: {}\n", options.output, sizeText(*bytes));
  return kDone;
}

}  // namespace

void addQuality(CLI::App& app, int& exitCode) {
  auto* command = app.add_subcommand("quality", "Measure the shape of the cells of a 4D mesh");
  auto options = std::make_shared<QualityArguments>();
  command->add_option("FILE", options->input, kT4dFileHelp)->required();
  command
      ->add_option("--time-scale", options->timeScale,
                   "The length that one unit of time counts as (default: the mean speed of the "
                   "surface along its normal)")
      ->check(numberAboveZero());
  command->add_option("--worst", options->worst, "How many cells to name, the worst first")
      ->check(wholeNumber(0, 100000))
      ->capture_default_str();
  command
      ->add_option("-o,--output", options->output,
                   "A .t4d file to write, the mesh with measures as attributes of its cells")
      ->check(someName())
      ->check(noOtherFormat());
  std::vector<std::string> names;
  for (const auto& one : kQualityMeasures) names.emplace_back(one.name);
  command
      ->add_option("--attributes", options->attributes,
                   "Which measures to write (default: radius_ratio)")
      ->delimiter(',')
      ->check(CLI::IsMember(names));
  addCompressionOption(*command, options->compression);
  options->only.addTo(*command);
  command->add_flag("--json", options->json, "Print JSON");
  command->footer(
      "Example:\n  t4d quality bolt.t4d -o shaped.t4d\n"
      "  t4d slice shaped.t4d --time 2.5 --color attribute:radius_ratio -o shaped.glb");
  command->callback([=, &exitCode] { exitCode = run(*options); });
}

}  // namespace t4d::tools
