#include "tools/t4d/quality.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>
#include <tuple>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "formats/output_file.h"
#include "slice/slab_at_time.h"
#include "t4d/slice.h"
#include "tools/t4d/commands.h"
#include "tools/t4d/console.h"
#include "tools/t4d/console_observer.h"
#include "tools/t4d/exact_json.h"
#include "tools/t4d/input.h"
#include "tools/t4d/json_option.h"
#include "tools/t4d/members.h"
#include "tools/t4d/option_checks.h"
#include "tools/t4d/part_option.h"
#include "tools/t4d/quality_page.h"
#include "tools/t4d/quality_parts.h"
#include "tools/t4d/t4d_output.h"
#include "tools/t4d/time_scale.h"
#include "tools/t4d/version.h"

namespace t4d::tools {
namespace {

using measure::kQualityMeasures;
using nlohmann::ordered_json;

void describeDistribution(Members& members, const measure::Distribution& values) {
  const auto ofCells = [&](double value) {
    return values.count() == 0 ? std::nullopt : std::optional(value);
  };
  members("min", ofCells(values.min()), "The smallest value.");
  members("p01", ofCells(values.quantile(0.01)), "1 % of the cells do not exceed it; to 0.2 %.");
  members("p50", ofCells(values.quantile(0.5)), "The median; to 0.2 %.");
  members("p99", ofCells(values.quantile(0.99)), "99 % of the cells do not exceed it; to 0.2 %.");
  members("max", ofCells(values.max()), "The largest value.");
}

using Distributions = std::array<measure::Distribution, kQualityMeasures.size()>;

void addDistributions(Members& members, const Distributions& measures) {
  members("measures", measures, "For each measure its distribution.",
          [](Members& own, const Distributions& all) {
            for (std::size_t k = 0; k < all.size(); ++k) {
              own(kQualityMeasures[k].name.data(), all[k],
                  "How a measure is distributed over the cells; numbers are null where they are "
                  "infinite, and without cells.",
                  describeDistribution);
            }
          });
}

void describeCells(Members& members, const Distributions& cells) {
  members("cells", cells[0].count(), "How many there are.");
  addDistributions(members, cells);
}

void describeMeasures(Members& members, const measure::CellQuality& cell) {
  members("volume", cell.volume, "3-measure of a cell, in length^3.").atLeast(0);
  members("edge_ratio", cell.edgeRatio, "Longest edge divided by the shortest; null if infinite.")
      .atLeast(0)
      .orNull();
  members(
      "radius_ratio", cell.radiusRatio,
      "Radius of the circumsphere divided by three times that of the insphere; null if infinite.")
      .atLeast(0)
      .orNull();
  members("smallest_angle", cell.smallestAngle, "Smallest angle between two sides, in degrees.")
      .atLeast(0);
  members("largest_angle", cell.largestAngle, "Largest angle between two sides, in degrees.")
      .atLeast(0);
  members("height", cell.height, "Smallest height divided by the longest edge.").atLeast(0);
}

void describeWorst(Members& members, const measure::RankedCell& cell,
                   const std::vector<std::string>& bodies) {
  members("body", bodies.empty() ? std::string() : bodies[cell.body], "Name of the body.");
  members("slab", cell.slab, "Slab of the body, counted from 0.");
  members("cell", cell.cell, "Cell of the slab, counted from 0.");
  members("time", cell.center[3], "Time of the middle of the cell.");
  members("point", model::Point3(cell.center.head<3>()), "Position of the middle of the cell.");
  describeMeasures(members, cell.quality);
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
  QualityReport whole;
  measure::MeshQuality& all = whole.quality;
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
  ordered_json value = Members::valueOf(whole);
  value["time_scale"] = reports.front().at("time_scale");
  value["worst"] = cells;
  return value;
}

void describe(Members& members, const QualityReport& report) {
  const measure::MeshQuality& quality = report.quality;
  Distributions all;
  for (std::size_t k = 0; k < all.size(); ++k) all[k] = quality.all(k);
  members("cells", quality.cells(), "Cells of all bodies.");
  members("flat", quality.flat, "Cells without volume.");
  members("time_scale", quality.timeScale, "The length that one unit of time counts as.").above(0);
  addDistributions(members, all);
  members("sides", quality.sides, "Cells of slabs that last.", describeCells);
  members("caps", quality.caps, "Cells of caps.", describeCells);
  members("worst", quality.worst, "Cells with the largest radius ratios, the largest first.",
          [&](Members& own, const measure::RankedCell& cell) {
            describeWorst(own, cell, report.bodies);
          });
  members("bytes", report.bytes, "Size of the file written, in bytes; null without --output.");
}

namespace {

struct QualityArguments {
  std::string input;
  InputOptions only;
  QualityOptions quality;
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

void printReport(const QualityReport& report, const Input& input) {
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
Result<std::vector<QualityView>> viewsOf(const measure::MeshQuality& quality, const Input& input) {
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

Result<void> writePage(formats::OutputFile& file, const QualityReport& report, const Input& input) {
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
  const auto input = openInput(options.input, options.only);
  if (!input) return report(input.error());
  // A file with measures has a slab of each body.
  const bool ofEach = !options.quality.output.empty();
  if (const auto done = options.part.settle(mostParts(*input, ofEach), "slabs")) {
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
  const auto measured = quality(*input, options.quality, observer);
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
    tools::printText(options.part.inReport(Members::valueOf(*measured), identity, state) + "\n");
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
  addJsonOption<QualityReport>(*command, options->json, "The shape of the cells of a 4D mesh.");
  command->footer(
      "Example:\n  t4d quality bolt.t4d -o shaped.t4d\n"
      "  t4d slice shaped.t4d --time 2.5 --color attribute:radius_ratio -o shaped.glb");
  command->callback([=, &exitCode] { exitCode = run(*options); });
}

}  // namespace t4d::tools
