#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "t4d/formats/output_file.h"
#include "t4d/formats/t4d/writer.h"
#include "t4d/measure/mesh_quality.h"
#include "t4d/slice/slab_at_time.h"
#include "t4d/slice/slice.h"
#include "tools/program/commands.h"
#include "tools/program/console.h"
#include "tools/program/input_bodies.h"
#include "tools/program/option_checks.h"
#include "tools/program/or_null.h"
#include "tools/program/progress_bar.h"
#include "tools/program/quality_page.h"
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
  std::vector<std::string> attributes;  // none for radius_ratio
  int compression = 3;
  std::string html;
  bool json = false;
};

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

constexpr std::array kTitles = {"volume",         "edge ratio",    "radius ratio",
                                "smallest angle", "largest angle", "height"};

std::vector<std::string> rowOf(const std::string& title, const measure::Distribution& values) {
  std::vector<std::string> row = {title};
  for (const double number : {values.min(), values.quantile(0.01), values.quantile(0.5),
                              values.quantile(0.99), values.max()}) {
    row.push_back(fmt::format("{:.4g}", number));
  }
  return row;
}

void printTableOf(const std::string& title,
                  const std::array<measure::Distribution, kQualityMeasures.size()>& distributions) {
  const std::uint64_t cells = distributions[0].count();
  if (cells == 0) return;
  print("  {} of {}\n", counted(cells, "cell", "cells"), title);
  std::vector<std::vector<std::string>> rows = {{"  ", "min", "1 %", "50 %", "99 %", "max"}};
  for (std::size_t k = 0; k < distributions.size(); ++k) {
    rows.push_back(rowOf(std::string("  ") + kTitles[k], distributions[k]));
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

/// The solids at the times of the worst cells, with the radius ratio of each triangle.
Result<std::vector<QualityView>> viewsOf(const measure::MeshQuality& quality,
                                         const InputBodies& input) {
  constexpr std::size_t kMostViews = 3;
  const std::span<const measure::QualityMeasure> ratio(&kQualityMeasures[2], 1);
  std::vector<QualityView> views;
  for (const measure::RankedCell& cell : quality.worst) {
    const double time = cell.center[3];
    const auto isShown = [&](const QualityView& view) { return view.time == time; };
    if (std::ranges::any_of(views, isShown)) continue;
    const model::Source& source = *input.bodies[cell.body].source;
    const auto at = slice::slabAtTime(source, time);
    if (!at) return pass(at.error());
    if (!at->slab) continue;
    const auto slab = source.slab(*at->slab);
    if (!slab) return pass(slab.error());
    slice::Slicer slicer(slice::Hyperplane::atTime(at->time),
                         at->atEnd ? slice::OnHyperplane::Above : slice::OnHyperplane::Below);
    measure::QualitySink with(ratio, quality.timeScale, slicer);
    if (auto put = with.put(**slab); !put) return pass(put.error());
    views.push_back({time, cell.center.head<3>(), slicer.finish().mesh});
    if (views.size() == kMostViews) break;
  }
  return views;
}

Result<void> writePage(formats::OutputFile& file, const measure::MeshQuality& quality,
                       const std::string& scale, const InputBodies& input) {
  auto views = viewsOf(quality, input);
  if (!views) return pass(views.error());
  const formats::Metadata& metadata = input.reader.metadata();
  QualityPage page{fmt::format("Cells of {}", input.reader.name()),
                   fmt::format("{}, of which {} of caps; 1 unit of time as {:.4g} of length ({}).",
                               counted(quality.cells(), "cell"), grouped(quality.caps[0].count()),
                               quality.timeScale, scale),
                   metadata.timeUnit,
                   metadata.up == "z",
                   {{"", "min", "1 %", "50 %", "99 %", "max"}},
                   std::move(*views)};
  for (std::size_t k = 0; k < kQualityMeasures.size(); ++k) {
    page.table.push_back(rowOf(kTitles[k], quality.all(k)));
  }
  const std::string html = qualityPage(page, quality);
  if (auto done = file.write(html.data(), html.size()); !done) return done;
  return file.commit();
}

/// Why cells would be flat up to rounding with this scale.
std::optional<std::string> misuseOfScale(double scale, const InputBodies& input) {
  constexpr double kLongest = 1e12;  // of length to size; beyond it, rounding errors decide
  const model::TimeSpan span = model::timeSpanOf(input.bodies);
  const model::Bounds3 bounds = boundsOf(input);
  if (bounds.empty() || !(span.end > span.begin)) return std::nullopt;
  const double size = (bounds.max - bounds.min).norm();
  const double even = size / (span.end - span.begin);
  const double ratio = scale / even;
  if (!(size > 0) || (ratio >= 1 / kLongest && ratio <= kLongest)) return std::nullopt;
  return fmt::format(
      "--time-scale {}: the mesh would be {:.3g} long in time and {:.3g} wide in space, and "
      "volumes would {}; choose a scale from {:.2g} to {:.2g}",
      scale, scale * (span.end - span.begin), size, ratio < 1 ? "vanish" : "overflow",
      even / kLongest, even * kLongest);
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

/// Whether float32 takes the smallest or the largest value for 0 or for infinite.
bool exceedsSingle(const measure::Distribution& values) {
  const measure::Distribution some = values.positiveAndFinite();
  return some.count() > 0 && (some.min() < std::numeric_limits<float>::min() ||
                              some.max() > std::numeric_limits<float>::max());
}

/// Writes the mesh with the measures as attributes. Returns the size of the file.
Result<std::uint64_t> write(const QualityArguments& options, const InputBodies& input,
                            const measure::MeshQuality& quality, std::vector<std::string>& losses) {
  std::set<std::string> replaced;
  std::vector<measure::QualityMeasure> measures;
  for (std::size_t k = 0; k < kQualityMeasures.size(); ++k) {
    const measure::QualityMeasure& one = kQualityMeasures[k];
    const bool asked =
        options.attributes.empty()
            ? one.name == "radius_ratio"
            : std::ranges::find(options.attributes, one.name) != options.attributes.end();
    if (!asked) continue;
    measures.push_back(one);
    if (exceedsSingle(quality.all(k))) {
      printNotices(
          {fmt::format("{}: some values are too small or too large for float32; they are "
                       "written as 0 or as infinite",
                       one.name)});
    }
  }
  auto writer = formats::T4dWriter::create(options.output, metadataOf(input),
                                           {.compression = options.compression});
  if (!writer) return pass(writer.error());
  ProgressBar bar("writing " + options.output, slabCountOf(input.bodies), "slabs");
  for (std::size_t b = 0; b < input.bodies.size(); ++b) {
    const model::Source& source = *input.bodies[b].source;
    measure::QualitySink with(measures, quality.timeScale, writer->body(b));
    if (auto put = model::pump(source, with, bar.part(source.slabCount())); !put) {
      return pass(put.error());
    }
    replaced.insert(with.replaced().begin(), with.replaced().end());
  }
  if (!replaced.empty()) {
    printNotices({fmt::format("the file had {}; {} replaced", fmt::join(replaced, ", "),
                              replaced.size() == 1 ? "it is" : "they are")});
  }
  auto bytes = finishEdited(*writer, input);
  losses = writer->losses();
  return bytes;
}

int run(const QualityArguments& options) {
  if (!options.output.empty()) {
    if (const auto misuse = misuseOfOutput(options.output, {&options.input, 1})) {
      return wrongUsage(*misuse);
    }
  }
  if (!options.attributes.empty() && options.output.empty()) {
    return wrongUsage("--attributes are written to a file; name it with -o");
  }
  if (!options.html.empty()) {
    if (const auto misuse = misuseOfOutput(options.html, {&options.input, 1})) {
      return wrongUsage(*misuse);
    }
  }
  if (const auto misuse = misuseOfOutputs(std::array{options.output, options.html})) {
    return wrongUsage(*misuse);
  }
  if (auto writable = checkWritable({{options.output}}); !writable) {
    return report(writable.error());
  }
  const auto input = openBodies(options.input, options.only);
  if (!input) return report(input.error());
  if (options.timeScale) {
    if (const auto misuse = misuseOfScale(*options.timeScale, *input)) return wrongUsage(*misuse);
  }
  std::optional<formats::OutputFile> html;
  if (!options.html.empty()) {
    auto created = formats::OutputFile::create(options.html);
    if (!created) return report(created.error());
    html.emplace(std::move(*created));
  }
  const auto scale = scaleOf(options, *input);
  if (!scale) return report(inInput(scale.error(), *input));
  const auto quality = [&] {
    ProgressBar bar("measuring cells", slabCountOf(input->bodies), "slabs");
    return measure::measureQuality(
        input->bodies, {.timeScale = scale->value, .worst = options.worst}, bar.callback());
  }();
  if (!quality) return report(inInput(quality.error(), *input));
  std::optional<std::uint64_t> bytes;
  std::vector<std::string> losses;
  if (!options.output.empty()) {
    const auto written = write(options, *input, *quality, losses);
    if (!written) return report(inInput(written.error(), *input));
    bytes = *written;
  }
  if (html) {
    if (auto done = writePage(*html, *quality, scale->reason, *input); !done) {
      return report(inInput(done.error(), *input));
    }
  }
  if (options.json) {
    ordered_json value = jsonOf(*quality, *input);
    value["bytes"] = orNull(bytes);
    printJson(value);
    return reportLosses(losses);
  }
  printText(*quality, scale->reason, *input);
  if (bytes) print("  {}: {}\n", options.output, sizeText(*bytes));
  return reportLosses(losses);
}

}  // namespace

void addQuality(CLI::App& app, int& exitCode) {
  auto* command = app.add_subcommand("quality", "Measure the shape of the cells of a 4D mesh");
  auto options = std::make_shared<QualityArguments>();
  command->add_option("FILE", options->input, kT4dFileHelp)->required();
  command
      ->add_option("--time-scale", options->timeScale,
                   "Length equal to one unit of time (default: mean normal speed of the surface)")
      ->check(numberAboveZero());
  command->add_option("--worst", options->worst, "Number of worst cells to list")
      ->check(wholeNumber(0, 100000))
      ->capture_default_str();
  command
      ->add_option("-o,--output", options->output,
                   "Output file (.t4d): the mesh with measures as cell attributes")
      ->check(someName())
      ->check(noOtherFormat());
  std::vector<std::string> names;
  for (const auto& one : kQualityMeasures) names.emplace_back(one.name);
  command
      ->add_option("--attributes", options->attributes, "Measures to write (default: radius_ratio)")
      ->delimiter(',')
      ->check(CLI::IsMember(names));
  addCompressionOption(*command, options->compression);
  command
      ->add_option("--html", options->html,
                   "Write a page with histograms and pictures of the worst cells")
      ->check(someName());
  options->only.addTo(*command);
  command->add_flag("--json", options->json, "Print JSON");
  command->footer(
      "Example:\n  t4d quality bolt.t4d -o shaped.t4d\n"
      "  t4d slice shaped.t4d --time 2.5 --color attribute:radius_ratio -o shaped.glb");
  command->callback([=, &exitCode] { exitCode = run(*options); });
}

}  // namespace t4d::tools
