#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "formats/output_file.h"
#include "slice/slab_at_time.h"
#include "t4d/slice.h"
#include "tools/t4d/commands.h"
#include "tools/t4d/console.h"
#include "tools/t4d/console_observer.h"
#include "tools/t4d/input_options.h"
#include "tools/t4d/json_option.h"
#include "tools/t4d/option_checks.h"
#include "tools/t4d/part_option.h"
#include "tools/t4d/quality_page.h"
#include "tools/t4d/t4d_output.h"
#include "tools/t4d/version.h"
#include "tools/verbs/quality.h"

namespace t4d::tools {
namespace {

using measure::kQualityMeasures;

struct QualityArguments {
  std::string input;
  InputOptions only;
  verbs::QualityOptions quality;
  PartOption part;
  std::string html;
  bool json = false;
};

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

void printReport(const verbs::QualityReport& report, const verbs::Input& input) {
  const measure::MeshQuality& quality = report.quality;
  print("{}: {}, 1 unit of time as {:.4g} of length ({})\n", input.name,
        counted(quality.cells(), "cell", "cells"), quality.timeScale, report.scaleReason);
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
        {fmt::format("  {:.4g}", cell.quality.radiusRatio), report.bodies[cell.body],
         grouped(cell.slab), grouped(cell.cell), fmt::format("{:.6g}", cell.center[3]),
         fmt::format("({:.4g}, {:.4g}, {:.4g})", cell.center[0], cell.center[1], cell.center[2])});
  }
  printTable(rows, "lllllr");
}

/// The solids at the times of the worst cells, with the radius ratio of each triangle.
Result<std::vector<QualityView>> viewsOf(const measure::MeshQuality& quality,
                                         const verbs::Input& input) {
  constexpr std::size_t kMostViews = 3;
  const std::span<const measure::QualityMeasure> ratio(&kQualityMeasures[2], 1);
  std::vector<QualityView> views;
  for (const measure::RankedCell& cell : quality.worst) {
    const double time = cell.center[3];
    const auto isShown = [&](const QualityView& view) { return view.time == time; };
    if (std::ranges::any_of(views, isShown)) continue;
    const model::Source& source = *input.bodies[cell.body].source;
    const auto at = slice::slabAtTime(source, time);
    if (!at) return at.error();
    if (!at->slab) continue;
    const auto slab = source.slab(*at->slab);
    if (!slab) return slab.error();
    slice::Slicer slicer(slice::Hyperplane::atTime(at->time),
                         at->atEnd ? slice::OnHyperplane::Above : slice::OnHyperplane::Below);
    measure::QualitySink with(ratio, quality.timeScale, slicer);
    if (auto put = with.put(**slab); !put) return put.error();
    views.push_back({time, cell.center.head<3>(), slicer.finish().mesh});
    if (views.size() == kMostViews) break;
  }
  return views;
}

Result<void> writePage(formats::OutputFile& file, const verbs::QualityReport& report,
                       const verbs::Input& input) {
  const measure::MeshQuality& quality = report.quality;
  auto views = viewsOf(quality, input);
  if (!views) return views.error();
  QualityPage page{fmt::format("Cells of {}", input.name),
                   fmt::format("{}, of which {} of caps; 1 unit of time as {:.4g} of length ({}).",
                               counted(quality.cells(), "cell"), grouped(quality.caps[0].count()),
                               quality.timeScale, report.scaleReason),
                   {{"", "min", "1 %", "50 %", "99 %", "max"}},
                   std::move(*views)};
  for (std::size_t k = 0; k < kQualityMeasures.size(); ++k) {
    page.table.push_back(rowOf(kTitles[k], quality.all(k)));
  }
  return file.finish(qualityPage(page, input.metadata, quality));
}

/// Why these options cannot be.
std::optional<std::string> misuseOf(const QualityArguments& options) {
  if (!options.quality.attributes.empty() && options.quality.output.empty()) {
    return "--attributes are written to a file; name it with -o";
  }
  if (options.part.isGiven() && !options.html.empty()) {
    return "--part and --html exclude each other: the page is of the whole mesh";
  }
  return std::nullopt;
}

int run(QualityArguments& options) {
  if (const auto misuse = misuseOf(options)) return wrongUsage(*misuse);
  const std::array outputs = {options.quality.output, options.html};
  if (auto good = checkOutputs(outputs, {&options.input, 1}); !good) return report(good.error());
  const auto input = verbs::openInput(options.input, options.only);
  if (!input) return report(input.error());
  // A file with measures has a slab of each body.
  const bool ofEach = !options.quality.output.empty();
  if (const auto done = options.part.settle(verbs::mostParts(*input, ofEach), "slabs")) {
    return *done;
  }
  options.quality.part = options.part.chosen();
  std::optional<formats::OutputFile> html;
  if (!options.html.empty()) {
    auto created = formats::OutputFile::create(options.html);
    if (!created) return report(created.error());
    html.emplace(std::move(*created));
  }
  options.quality.generator = versionText();
  ConsoleObserver observer;
  const auto measured = verbs::quality(*input, options.quality, observer);
  if (!measured) return report(measured.error());
  if (html) {
    if (auto done = writePage(*html, *measured, *input); !done) {
      return report(inInput(done.error(), *input));
    }
  }
  if (options.json) {
    const auto identity = [&] {
      nlohmann::ordered_json known = identityOf(*input);
      known["worst"] = options.quality.worst;
      known["time_scale"] = measured->quality.timeScale;
      return known;
    };
    const auto state = options.part.isGiven()
                           ? nlohmann::ordered_json::parse(partStateOf(*measured))
                           : nlohmann::ordered_json();
    tools::printText(options.part.inReport(verbs::Members::valueOf(*measured), identity, state) +
                     "\n");
    return reportLosses(measured->losses);
  }
  printReport(*measured, *input);
  if (measured->bytes) print("  {}: {}\n", options.quality.output, sizeText(*measured->bytes));
  return reportLosses(measured->losses);
}

}  // namespace

void addQuality(CLI::App& app, int& exitCode) {
  auto* command = app.add_subcommand("quality", "Measure the shape of the cells of a 4D mesh");
  auto options = std::make_shared<QualityArguments>();
  command->add_option("FILE", options->input, kT4dFileHelp)->required();
  command
      ->add_option("--time-scale", options->quality.timeScale,
                   "Length equal to one unit of time (default: mean normal speed of the surface)")
      ->check(numberAboveZero());
  command->add_option("--worst", options->quality.worst, "Number of worst cells to list")
      ->check(wholeNumber(0, 100000))
      ->capture_default_str();
  command
      ->add_option("-o,--output", options->quality.output,
                   "Output file (.t4d): the mesh with measures as cell attributes")
      ->check(someName())
      ->check(outputFile({".t4d"}));
  std::vector<std::string> names;
  for (const auto& one : kQualityMeasures) names.emplace_back(one.name);
  command
      ->add_option("--attributes", options->quality.attributes,
                   "Measures to write (default: radius_ratio)")
      ->delimiter(',')
      ->check(CLI::IsMember(names));
  addCompressionOption(*command, options->quality.compression);
  command
      ->add_option("--html", options->html,
                   "Write a page with histograms and pictures of the worst cells")
      ->check(htmlFile());
  options->only.addTo(*command);
  options->part.addTo(*command,
                      "Measure only part K of N of the slabs; `t4d join` joins the reports");
  addJsonOption<verbs::QualityReport>(*command, options->json,
                                      "The shape of the cells of a 4D mesh.");
  command->footer(
      "Example:\n  t4d quality bolt.t4d -o shaped.t4d\n"
      "  t4d slice shaped.t4d --time 2.5 --color attribute:radius_ratio -o shaped.glb");
  command->callback([=, &exitCode] { exitCode = run(*options); });
}

}  // namespace t4d::tools
