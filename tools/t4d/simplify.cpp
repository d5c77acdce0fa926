#include "tools/t4d/simplify.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "formats/output_file.h"
#include "model/parallel.h"
#include "model/source_part.h"
#include "platform/stopwatch.h"
#include "t4d/check.h"
#include "t4d/file.h"
#include "tools/t4d/commands.h"
#include "tools/t4d/console.h"
#include "tools/t4d/console_observer.h"
#include "tools/t4d/input.h"
#include "tools/t4d/json_option.h"
#include "tools/t4d/members.h"
#include "tools/t4d/option_checks.h"
#include "tools/t4d/simplify_page.h"
#include "tools/t4d/t4d_output.h"
#include "tools/t4d/time_scale.h"
#include "tools/t4d/version.h"

namespace t4d::tools {
namespace {

/// An error of less than this part of the size is lost in rounding.
constexpr double kLeastError = 1e-12;

/// Part of the diagonal of the bounds of a body that is its error without any wish.
constexpr double kUsualError = 1e-3;

double sizeOf(const model::Bounds3& bounds) {
  return bounds.empty() ? 0 : (bounds.max - bounds.min).norm();
}

std::uint64_t cellsOf(const Input& input) {
  std::uint64_t cells = 0;
  if (!input.reader) return cells;
  const auto& infos = input.reader->metadata().bodies;
  for (std::size_t i = 0; i < infos.size(); ++i) {
    if (std::ranges::find(input.bodies, infos[i].name, &model::Body::name) == input.bodies.end()) {
      continue;
    }
    cells += input.reader->summary(i).tetrahedra;
  }
  return cells;
}

/// The options for all bodies.
Result<edit::SimplifyOptions> optionsOf(const SimplifyOptions& wanted, const Input& input,
                                        double timeScale) {
  const auto bounds = boundsOf(input);
  if (!bounds) return bounds.error();
  const double size = sizeOf(*bounds);
  edit::SimplifyOptions options;
  options.timeScale = timeScale;
  options.preserve = wanted.preserve;
  options.windowSlabs = wanted.windowSlabs;
  options.part = wanted.part;
  options.ratio = wanted.ratio;
  options.maxError = wanted.maxError;
  if (wanted.cells) {
    const auto cells = static_cast<double>(cellsOf(input));
    options.ratio = std::min(1.0, static_cast<double>(*wanted.cells) / std::max(cells, 1.0));
  }
  if (!options.ratio && !options.maxError) options.maxError = kUsualError * size;
  if (options.maxError && !(*options.maxError >= kLeastError * size)) {
    return fail(ErrorCode::Options,
                fmt::format("an error of {} is below what doubles can hold for a mesh of size "
                            "{:.4g}; allow at least {:.2g}",
                            *options.maxError, size, kLeastError * size));
  }
  return options;
}

/// The options for one body: without any wish, its error is of its own size, since a small body
/// beside a large one would shrink to a few cells.
Result<edit::SimplifyOptions> optionsFor(const model::Body& body, const SimplifyOptions& wanted,
                                         edit::SimplifyOptions options, const Input& input) {
  if (wanted.ratio || wanted.cells || wanted.maxError) return options;
  Input alone = input;
  alone.bodies = {body};
  const auto bounds = boundsOf(alone);
  if (!bounds) return bounds.error();
  const double least = kLeastError / kUsualError * *options.maxError;
  options.maxError = std::max(least, kUsualError * sizeOf(*bounds));
  return options;
}

/// Says of bodies that are stored as poses what they lose.
Result<void> noteSweeps(const Input& input, Observer& observer) {
  for (const model::Body& body : input.bodies) {
    const std::size_t slabs = body.source->slabCount();
    if (slabs < 2) continue;
    const auto slab = body.source->slab(1);
    if (!slab) return slab.error();
    if (!(*slab)->upperPose) continue;
    observer.note(
        fmt::format("body '{}' is swept: its file holds poses of one solid, and is small as it is; "
                    "simplified, it loses the poses and the exact layers",
                    body.name));
  }
  return {};
}

/// Says that a number of cells was not reached, and why.
void noteGoal(const edit::SimplifyOptions& options, const edit::SimplifyReport& mesh,
              Observer& observer) {
  constexpr double kNearGoal = 1.02;
  if (!options.ratio) return;
  const double goal = *options.ratio * static_cast<double>(mesh.cellsBefore);
  if (static_cast<double>(mesh.cells) <= kNearGoal * goal + 64) return;
  observer.note(
      fmt::format("ended at {} cells, not {:.0f}: any further collapse would {}change the "
                  "topology, turn a cell "
                  "over, make a needle, or move a layer between two windows",
                  mesh.cells, goal, options.maxError ? "exceed the largest error, " : ""));
}

/// Says that a time scale was given that suits the mesh badly.
void noteNeedles(const SimplifyOptions& wanted, const SimplifyReport& report, Observer& observer) {
  constexpr double kNeedle = 1e-4;
  const double height = report.heights(0).quantile(0.5);
  if (!wanted.timeScale || height >= kNeedle) return;
  observer.note(fmt::format(
      "with {} as the length of a unit of time, half of the cells are needles, less "
      "than {:.1g} of their longest edge high, and few can go; the mean normal speed of "
      "the surface, the default, is a better scale",
      *wanted.timeScale, height));
}

void add(const edit::SimplifyReport& body, edit::SimplifyReport& all) {
  all.cellsBefore += body.cellsBefore;
  all.cells += body.cells;
  all.verticesBefore += body.verticesBefore;
  all.vertices += body.vertices;
  all.hypervolumeBefore += body.hypervolumeBefore;
  all.hypervolume += body.hypervolume;
  if (body.maxError) all.maxError = std::max(all.maxError.value_or(0), *body.maxError);
  all.droppedAttributes.insert(body.droppedAttributes.begin(), body.droppedAttributes.end());
}

/// Writes the file; `before` are the slabs of each body that it replaces.
Result<void> write(const Input& input, const edit::SimplifyOptions& options,
                   const SimplifyOptions& wanted, SimplifyReport& report,
                   std::vector<model::SourcePart>& before, Observer& observer) {
  auto writer = formats::T4dWriter::create(wanted.output, metadataOf(input, wanted.generator),
                                           {.compression = wanted.compression});
  if (!writer) return writer.error();
  const auto stage = observer.stage("simplifying", slabCountOf(input.bodies), "slabs");
  for (std::size_t b = 0; b < input.bodies.size(); ++b) {
    const model::Source& source = *input.bodies[b].source;
    const auto own = optionsFor(input.bodies[b], wanted, options, input);
    if (!own) return own.error();
    const auto done =
        edit::simplify(source, *own, writer->body(b), stage->part(source.slabCount()));
    if (!done) return done.error();
    add(*done, report.mesh);
    before.emplace_back(source, done->slabs[0], done->slabs[1]);
  }
  const auto bytes = finishEdited(*writer, input);
  if (!bytes) return bytes.error();
  report.bytes = *bytes;
  report.losses = writer->losses();
  if (!report.mesh.droppedAttributes.empty()) {
    report.losses.push_back(fmt::format("attributes that only some slabs have: {}",
                                        fmt::join(report.mesh.droppedAttributes, ", ")));
  }
  return {};
}

/// The slices of both at a time, and their distance.
Result<std::pair<SlicePair, double>> comparedAt(const Input& before, const Input& after,
                                                double time, double tolerance) {
  auto a = measure::solidAt(before.bodies, time);
  if (!a) return a.error();
  auto b = measure::solidAt(after.bodies, time);
  if (!b) return b.error();
  const double distance = measure::surfaceDistance(*a, *b, tolerance).hausdorff();
  return std::pair(SlicePair{time, std::move(*a), std::move(*b)}, distance);
}

/// Compares slices of the file with those of the input, one time on each thread.
Result<void> compareSlices(const Input& before, const Input& after, const SimplifyOptions& wanted,
                           SimplifyReport& report, Observer& observer) {
  constexpr double kTolerance = 1e-3;  // of the diagonal of two slices
  const auto times = model::evenTimes(model::timeSpanOf(before.bodies), wanted.times);
  const auto stage = observer.stage("comparing slices", times.size(), "slices");
  const auto isKept = [&, pairs = std::min(wanted.pairs, times.size())](std::size_t at) {
    for (std::size_t i = 0; i < pairs; ++i) {
      if (at == (pairs == 1 ? 0 : i * (times.size() - 1) / (pairs - 1))) return true;
    }
    return false;
  };
  using Compared = std::shared_ptr<Result<std::pair<SlicePair, double>>>;
  Result<void> done;
  model::inOrder<std::size_t, Compared>(
      times.size(), model::threadCount(), [](std::size_t i) { return i; },
      [&](std::size_t i) {
        return std::make_shared<Result<std::pair<SlicePair, double>>>(
            comparedAt(before, after, times[i], kTolerance));
      },
      [&, i = std::size_t{0}](const Compared& compared) mutable {
        if (!*compared) {
          done = compared->error();
          return false;
        }
        auto& [pair, distance] = **compared;
        report.distances.push_back({pair.time, distance});
        if (isKept(i++)) report.pairs.push_back(std::move(pair));
        if (auto shown = stage->part(1)) shown(1);
        return true;
      });
  if (!done) return done;
  double sum = 0;
  for (const auto& [time, distance] : report.distances) {
    sum += distance;
    if (distance <= report.measuredError) continue;
    report.measuredError = distance;
    report.measuredErrorTime = time;
  }
  report.meanError = times.empty() ? 0 : sum / static_cast<double>(times.size());
  return {};
}

Result<void> measureCells(const Input& before, const Input& after, double timeScale,
                          SimplifyReport& report, Observer& observer) {
  const auto stage = observer.stage(
      "measuring cells", slabCountOf(before.bodies) + slabCountOf(after.bodies), "slabs");
  std::size_t which = 0;
  for (const Input* input : {&before, &after}) {
    auto quality = measure::measureQuality(input->bodies, {.timeScale = timeScale, .worst = 0},
                                           stage->part(slabCountOf(input->bodies)));
    if (!quality) return quality.error();
    report.quality[which++] = std::move(*quality);
  }
  return {};
}

Result<SimplifyReport> simplifyAndMeasure(const Input& input, const SimplifyOptions& wanted,
                                          Observer& observer) {
  const auto scale = timeScaleOf(wanted.timeScale, input, observer);
  if (!scale) return scale.error();
  const auto options = optionsOf(wanted, input, scale->value);
  if (!options) return options.error();
  SimplifyReport report;
  report.scaleReason = scale->reason;
  report.bytesBefore = input.reader ? input.reader->fileBytes() : 0;
  if (auto noted = noteSweeps(input, observer); !noted) return noted.error();
  const platform::Stopwatch stopwatch;
  std::vector<model::SourcePart> parts;
  if (auto done = write(input, *options, wanted, report, parts, observer); !done) {
    return done.error();
  }
  report.seconds = stopwatch.seconds();
  noteGoal(*options, report.mesh, observer);
  Input before = input;
  for (std::size_t b = 0; b < parts.size(); ++b) before.bodies[b].source = &parts[b];
  const auto after = openInput(wanted.output);
  if (!after) return after.error();
  if (auto done = compareSlices(before, *after, wanted, report, observer); !done) {
    return done.error();
  }
  if (auto done = measureCells(before, *after, scale->value, report, observer); !done) {
    return done.error();
  }
  noteNeedles(wanted, report, observer);
  return report;
}

}  // namespace

Result<SimplifyReport> simplify(const Input& input, const SimplifyOptions& options,
                                Observer& observer) {
  auto report = simplifyAndMeasure(input, options, observer);
  if (!report) return inInput(report.error(), input);
  return report;
}

measure::Distribution SimplifyReport::heights(std::size_t which) const {
  const auto& all = measure::kQualityMeasures;
  const auto height = std::ranges::find(all, "height", &measure::QualityMeasure::name);
  return quality[which].all(height - all.begin());
}

namespace {

void describeHeights(Members& members, const measure::Distribution& heights) {
  members("min", heights.min(), "The smallest.");
  members("p01", heights.quantile(0.01), "The value that 1 % of the cells do not exceed.");
  members("p50", heights.quantile(0.5), "The median.");
}

}  // namespace

void describe(Members& members, const SimplifyReport& report) {
  const edit::SimplifyReport& mesh = report.mesh;
  members("cells_before", mesh.cellsBefore, "Cells of all bodies before.");
  members("cells", mesh.cells, "Cells of all bodies after.");
  members("vertices_before", mesh.verticesBefore,
          "Vertices before; those that two slabs share count once.");
  members("vertices", mesh.vertices, "Vertices after; those that two slabs share count once.");
  members("hypervolume_before", mesh.hypervolumeBefore,
          "Enclosed hypervolume before, in length^3 * time.");
  members("hypervolume", mesh.hypervolume,
          "Enclosed hypervolume after; equal to that before, up to rounding.");
  members(
      "max_error", mesh.maxError,
      "Proved bound, up to rounding, on the Hausdorff distance between slices of both meshes at "
      "the same time. Null without --max-error.")
      .above(0);
  members("measured_error", report.measuredError,
          "The largest distance found between slices at the times compared.")
      .atLeast(0);
  members("measured_error_time", report.measuredErrorTime, "The time of this largest distance.");
  members("mean_error", report.meanError, "The mean of the distances at the times compared.")
      .atLeast(0);
  members("time_scale", report.quality[0].timeScale, "The length that one unit of time counts as.")
      .above(0);
  members("height_before", report.heights(0),
          "Smallest height of a cell divided by its longest edge, before.", describeHeights);
  members("height", report.heights(1),
          "Smallest height of a cell divided by its longest edge, after.", describeHeights);
  members("bytes_before", report.bytesBefore, "Size of the input file; 0 for a mesh in memory.");
  members("bytes", report.bytes, "Size of the output file.");
  addCosts(members, report.seconds);
}

namespace {

struct SimplifyArguments {
  std::string input;
  InputOptions only;
  SimplifyOptions simplify;
  std::optional<model::Part> part;
  std::string html;
  bool json = false;
};

std::string percentOf(std::uint64_t part, std::uint64_t whole) {
  return fmt::format("{:.3g} %", 100.0 * static_cast<double>(part) /
                                     static_cast<double>(std::max<std::uint64_t>(whole, 1)));
}

void printReport(const SimplifyReport& report, const std::string& output) {
  const edit::SimplifyReport& mesh = report.mesh;
  print("{}: {} of {} ({})\n", output, counted(mesh.cells, "cell"), grouped(mesh.cellsBefore),
        percentOf(mesh.cells, mesh.cellsBefore));
  print("  {} of {}\n", counted(mesh.vertices, "vertex", "vertices"), grouped(mesh.verticesBefore));
  print("  hypervolume {:.12g}, before {:.12g}\n", mesh.hypervolume, mesh.hypervolumeBefore);
  if (mesh.maxError) print("  no slice is farther than {:.4g} from the original\n", *mesh.maxError);
  print("  measured: at most {:.4g}, at time {:.6g}; in the mean {:.4g}\n", report.measuredError,
        report.measuredErrorTime, report.meanError);
  const auto before = report.heights(0);
  const auto after = report.heights(1);
  print("  height of cells: least {:.3g}, before {:.3g}; median {:.3g}, before {:.3g}\n",
        after.min(), before.min(), after.quantile(0.5), before.quantile(0.5));
  print("  {}, before {}, {:.2f} s, peak memory {}\n", sizeText(report.bytes),
        sizeText(report.bytesBefore), report.seconds, sizeText(peakBytes()));
}

Result<void> writePage(const SimplifyArguments& options, const formats::Metadata& metadata,
                       const SimplifyReport& report, formats::OutputFile& file) {
  const std::string page = simplifyPage(options.input, options.simplify.output, metadata, report);
  return file.finish(page);
}

int run(SimplifyArguments& options) {
  const std::array outputs = {options.simplify.output, options.html};
  if (auto good = checkOutputs(outputs, {&options.input, 1}); !good) return report(good.error());
  std::optional<formats::OutputFile> page;
  if (!options.html.empty()) {
    auto file = formats::OutputFile::create(options.html);
    if (!file) return report(file.error());
    page = std::move(*file);
    options.simplify.pairs = 3;
  }
  const auto input = openInput(options.input, options.only);
  if (!input) return report(input.error());
  options.simplify.generator = versionText();
  options.simplify.part = options.part.value_or(model::Part());
  ConsoleObserver observer;
  const auto done = simplify(*input, options.simplify, observer);
  if (!done) return report(done.error());
  if (options.json) {
    printAsJson(*done);
  } else {
    printReport(*done, options.simplify.output);
  }
  const int exitCode = reportLosses(done->losses);
  if (page) {
    const auto written = writePage(options, input->metadata, *done, *page);
    if (!written) return report(written.error());
  }
  return exitCode;
}

}  // namespace

void addSimplify(CLI::App& app, int& exitCode) {
  auto* command = app.add_subcommand(
      "simplify", "Reduce the number of cells of a 4D mesh, with a stated error");
  auto options = std::make_shared<SimplifyArguments>();
  SimplifyOptions& simplify = options->simplify;
  command->add_option("FILE", options->input, kT4dFileHelp)->required();
  addT4dOutputOption(*command, simplify.output);
  command
      ->add_option("--max-error", simplify.maxError,
                   "Maximum distance of slices (default: 0.001 of the size of each body)")
      ->check(numberAboveZero());
  auto* ratio = command->add_option("--ratio", simplify.ratio, "Part of the cells to keep, up to 1")
                    ->check(numberAboveZero());
  command->add_option("--cells", simplify.cells, "Number of cells to keep, of all bodies together")
      ->check(wholeNumber(1, std::uint64_t{1} << 62))
      ->excludes(ratio);
  command
      ->add_option("--time-scale", simplify.timeScale,
                   "Length equal to one unit of time (default: mean normal speed of the surface)")
      ->check(numberAboveZero());
  command
      ->add_option("--preserve", simplify.preserve,
                   "Cell attribute whose borders are kept, such as triangle or label")
      ->check(someName());
  command
      ->add_option("--window", simplify.windowSlabs,
                   "Number of slabs to join to one (default: 250,000 cells)")
      ->check(wholeNumber(1, std::uint64_t{1} << 32));
  addPartOption(*command, options->part, "Simplify only part K of N; `t4d join` joins the parts");
  addCompressionOption(*command, simplify.compression);
  options->only.addTo(*command);
  command
      ->add_option("--html", options->html,
                   "Write a page with the numbers and slices of both side by side")
      ->check(htmlFile());
  addJsonOption<SimplifyReport>(*command, options->json,
                                "A 4D mesh with fewer cells, and its distance from the given one.");
  command->footer(
      "Example:\n  t4d simplify ball.t4d --max-error 0.05 -o small.t4d\n"
      "  t4d simplify ball.t4d --ratio 0.1 -o tenth.t4d");
  command->callback([=, &exitCode] { exitCode = run(*options); });
}

}  // namespace t4d::tools
