#include "tools/t4d/compare.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <iterator>
#include <memory>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "formats/output_file.h"
#include "formats/t4d/url.h"
#include "formats/triangle/triangle_mesh_formats.h"
#include "mesh4d/steps.h"
#include "model/converted_source.h"
#include "model/parallel.h"
#include "platform/child_process.h"
#include "t4d/check.h"
#include "t4d/mesh.h"
#include "tools/t4d/commands.h"
#include "tools/t4d/compare_methods.h"
#include "tools/t4d/compare_page.h"
#include "tools/t4d/console.h"
#include "tools/t4d/console_observer.h"
#include "tools/t4d/input.h"
#include "tools/t4d/json_option.h"
#include "tools/t4d/motion_options.h"
#include "tools/t4d/numbers.h"
#include "tools/t4d/option_checks.h"
#include "tools/t4d/origin.h"
#include "tools/t4d/version.h"
#include "tools/t4d/voxel_series.h"

namespace t4d::tools {
namespace {

/// A file's name without its folder.
std::string shownFileName(const std::string& path) {
  return std::filesystem::path(formats::shownName(path)).filename().string();
}

/// An open file, converted to the units of the other file if they differ.
struct Side {
  explicit Side(Input opened) : input(std::move(opened)), bodies(input.bodies) {}
  Side(const Side&) = delete;
  Side& operator=(const Side&) = delete;

  Input input;
  std::vector<std::unique_ptr<model::ConvertedSource>> converted;
  std::vector<model::Body> bodies;
  ComparedMesh mesh;
};

/// The conversion from `from`, the length or time unit of the file at `path`, to `to`, that of the
/// file it is compared with; the identity if there is nothing to convert. Adds notices of what is
/// converted or assumed.
Result<model::UnitConversion> conversionTo(
    const std::string& to, const std::string& otherPath, const std::string& from,
    const std::string& path, const char* what,
    std::optional<model::UnitConversion> (*convert)(std::string_view, std::string_view),
    std::vector<std::string>& notes) {
  if (from.empty() != to.empty()) {
    const bool stated = to.empty();
    notes.push_back(fmt::format("only {} states a {} unit, {}; {} is assumed to use it as well",
                                stated ? path : otherPath, what, stated ? from : to,
                                stated ? otherPath : path));
    return model::UnitConversion{};
  }
  const auto conversion = convert(from, to);
  if (!conversion) {
    return invalid(fmt::format("its {} unit is '{}' and that of {} is '{}'; they differ and at "
                               "least one of them is unknown, so neither can be converted",
                               what, from, otherPath, to),
                   path);
  }
  if (!conversion->isIdentity()) {
    notes.push_back(fmt::format("{}s of {} are converted from {} to {}, the unit of {}", what, path,
                                from, to, otherPath));
  }
  return *conversion;
}

/// Converts `b` to the units of `a`.
Result<void> convertUnits(const Side& a, Side& b, std::vector<std::string>& notes) {
  const std::string& pathOfA = a.input.name;
  const std::string& pathOfB = b.input.name;
  const formats::Metadata& ofA = a.input.metadata;
  const formats::Metadata& ofB = b.input.metadata;
  auto length = conversionTo(ofA.lengthUnit, pathOfA, ofB.lengthUnit, pathOfB, "length",
                             model::lengthConversion, notes);
  if (!length) return length.error();
  auto time = conversionTo(ofA.timeUnit, pathOfA, ofB.timeUnit, pathOfB, "time",
                           model::timeConversion, notes);
  if (!time) return time.error();
  if (originOf(ofA) != originOf(ofB)) {
    notes.push_back(
        fmt::format("the origins of {} and {} lie elsewhere in the original "
                    "coordinates; positions are compared as they are in the files",
                    pathOfA, pathOfB));
  }
  if (length->isIdentity() && time->isIdentity()) return {};
  for (model::Body& body : b.bodies) {
    b.converted.push_back(std::make_unique<model::ConvertedSource>(*body.source, *length, *time));
    body.source = b.converted.back().get();
  }
  return {};
}

/// Reads a file and measures it, into `side.mesh`. An invalid mesh is measured, too, with a notice.
Result<void> measureSide(Side& side, const ComparedFile& file, Observer& observer) {
  ComparedMesh& mesh = side.mesh;
  mesh = file.mesh;
  mesh.backend = side.input.metadata.backend;
  mesh.bytes = side.input.reader->fileBytes();
  if (mesh.name.empty()) {
    mesh.name = shownFileName(file.path);
    if (!mesh.backend.empty()) mesh.name += " (" + mesh.backend + ")";
  }
  const auto stage =
      observer.stage("measuring " + shownFileName(file.path), slabCountOf(side.bodies), "slabs");
  for (const model::Body& body : side.bodies) {
    auto report = measure::checkMesh(*body.source, {}, stage->part(body.source->slabCount()));
    if (!report) {
      Error error = report.error();
      if (error.where.empty()) error.where = side.input.name;
      return error;
    }
    mesh.vertices += report->vertices;
    mesh.tetrahedra += report->tetrahedra;
    mesh.hypervolume += report->hypervolume;
    if (!report->valid()) {
      observer.note(
          fmt::format("{}: body '{}' is not a closed, oriented 4D mesh; validating it says why",
                      side.input.name, body.name));
    }
  }
  return {};
}

/// Measures the shape of the cells, with the time scale of the other mesh or, without one, the mean
/// normal speed of this one.
Result<void> measureShapes(Side& side, std::optional<double> timeScale, Observer& observer) {
  CellShapes& shapes = side.mesh.shapes;
  const auto stage = observer.stage("measuring the cells of " + side.mesh.name);
  if (!timeScale) {
    const auto speed = measure::meanNormalSpeed(side.bodies, stage->callback());
    if (!speed) return inInput(speed.error(), side.input);
    timeScale = *speed > 0 ? *speed : 1;
  }
  const auto quality = measure::measureQuality(side.bodies, {.timeScale = *timeScale, .worst = 0},
                                               stage->callback());
  if (!quality) return inInput(quality.error(), side.input);
  shapes.timeScale = *timeScale;
  for (std::size_t k = 0; k < measure::kQualityMeasures.size(); ++k) {
    const std::string_view name = measure::kQualityMeasures[k].name;
    if (name != "radius_ratio" && name != "smallest_angle") continue;
    const measure::Distribution all = quality->all(k);
    const CellQuantiles quantiles{all.quantile(0.01), all.quantile(0.5), all.quantile(0.99)};
    (name == "radius_ratio" ? shapes.radiusRatio : shapes.smallestAngle) = quantiles;
  }
  return {};
}

/// The times to compare at. Without options, in the middle of steps: of a swept mesh, since the
/// volume of a woven one changes little between its frames.
std::vector<double> comparedTimes(const CompareOptions& options, const Side& a, const Side& b,
                                  const model::TimeSpan& span) {
  constexpr std::uint64_t kDefaultSlices = 9;
  if (!options.times.empty()) return options.times;
  if (options.slices) return model::evenTimes(span, *options.slices);
  const bool ofB = a.mesh.backend == "voxel4d" && b.mesh.backend != "voxel4d";
  return measure::timesAmidSteps(ofB ? b.bodies : a.bodies, span, kDefaultSlices);
}

/// If all times fall on layers of a mesh: what that misses, and a number of slices that would not.
std::optional<std::string> aliasing(const CompareOptions& options, const Side& a, const Side& b,
                                    const model::TimeSpan& span, const std::vector<double>& times) {
  std::vector<std::string> where;
  for (const auto& [side, letter] : {std::pair{&a, "a"}, std::pair{&b, "b"}}) {
    if (measure::timesOnLayers(side->bodies, times) < times.size()) continue;
    where.push_back(
        fmt::format("{} of {}", side->mesh.backend == "voxel4d" ? "frames" : "layers", letter));
  }
  if (where.empty()) return std::nullopt;
  std::string note = fmt::format("all comparison times are {}, so nothing between them is compared",
                                 fmt::join(where, " and "));
  if (!options.times.empty()) return note + "; choose other times";
  constexpr std::uint64_t kTries = 20;
  for (std::uint64_t n = times.size() + 1; n < times.size() + kTries; ++n) {
    const std::vector<double> others = model::evenTimes(span, n);
    if (2 * measure::timesOnLayers(a.bodies, others) > n) continue;
    if (2 * measure::timesOnLayers(b.bodies, others) > n) continue;
    return note + fmt::format("; try {} slices", n);
  }
  return note;
}

/// The solids at so many of the times, the first and the last among them.
Result<std::vector<SolidPair>> pairsToShow(const Side& a, const Side& b,
                                           const std::vector<double>& times, std::size_t most) {
  std::vector<SolidPair> pairs;
  const std::size_t count = std::min(most, times.size());
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t at = count == 1 ? 0 : i * (times.size() - 1) / (count - 1);
    auto solidOfA = measure::solidAt(a.bodies, times[at]);
    if (!solidOfA) return solidOfA.error();
    auto solidOfB = measure::solidAt(b.bodies, times[at]);
    if (!solidOfB) return solidOfB.error();
    pairs.push_back({times[at], std::move(*solidOfA), std::move(*solidOfB)});
  }
  return pairs;
}

/// Opens and measures a file; `a` is the one that it is compared with, if there is one.
Result<std::unique_ptr<Side>> openSide(const ComparedFile& file, const Side* a,
                                       const CompareOptions& options,
                                       std::vector<std::string>& notes, Observer& observer) {
  auto opened = openInput(file.path, {.bodies = {}, .maxCells = options.maxCells});
  if (!opened) return opened.error();
  auto side = std::make_unique<Side>(std::move(*opened));
  if (a != nullptr) {
    if (auto done = convertUnits(*a, *side, notes); !done) return done.error();
  }
  if (auto done = measureSide(*side, file, observer); !done) return done.error();
  std::optional<double> timeScale;
  if (a != nullptr) timeScale = a->mesh.shapes.timeScale;
  if (auto done = measureShapes(*side, timeScale, observer); !done) return done.error();
  return side;
}

/// Compares the solids of some bodies at each time, one on each thread, which has two slabs and two
/// slices in memory.
Result<std::vector<ComparedSlice>> compareBodies(std::span<const model::Body> a,
                                                 std::span<const model::Body> b,
                                                 std::span<const double> times,
                                                 const model::Progress& progress) {
  const auto at = [&](std::size_t i) -> Result<ComparedSlice> {
    auto solidOfA = measure::solidAt(a, times[i]);
    if (!solidOfA) return solidOfA.error();
    auto solidOfB = measure::solidAt(b, times[i]);
    if (!solidOfB) return solidOfB.error();
    auto compared = measure::compareSolids(times[i], *solidOfA, *solidOfB);
    if (!compared) return compared.error();
    return ComparedSlice{*compared, surfaceAgreement(*solidOfA, *solidOfB)};
  };
  using Item = std::shared_ptr<const Result<ComparedSlice>>;
  std::vector<ComparedSlice> slices;
  Result<void> done;
  model::inOrder<Item>(
      times.size(),
      [&](std::size_t i) { return std::make_shared<const Result<ComparedSlice>>(at(i)); },
      [&](const Item& compared) {
        if (!*compared) {
          done = compared->error();
          return false;
        }
        slices.push_back(**compared);
        done = model::report(progress, slices.size(), times.size());
        return done.has_value();
      });
  if (!done) return done.error();
  return slices;
}

/// Compares the bodies of each name, those of a first.
Result<std::vector<ComparedBody>> compareEachBody(const Side& a, const Side& b,
                                                  std::span<const double> times,
                                                  Observer& observer) {
  std::vector<std::string> names;
  for (const Side* side : {&a, &b}) {
    for (const model::Body& body : side->bodies) {
      if (std::ranges::find(names, body.name) == names.end()) names.push_back(body.name);
    }
  }
  const auto ofName = [](const Side& side, const std::string& name) {
    std::vector<model::Body> bodies;
    std::ranges::copy_if(side.bodies, std::back_inserter(bodies),
                         [&](const model::Body& body) { return body.name == name; });
    return bodies;
  };
  const auto stage = observer.stage("comparing bodies", names.size() * times.size(), "slices");
  std::vector<ComparedBody> bodies;
  for (const std::string& name : names) {
    auto slices = compareBodies(ofName(a, name), ofName(b, name), times, stage->part(times.size()));
    if (!slices) return slices.error();
    bodies.push_back({name, std::move(*slices)});
  }
  return bodies;
}

/// Compares `b` with `a`, and adds to the report.
Result<void> compareSides(const Side& a, const Side& b, bool isLast, const CompareOptions& options,
                          std::vector<std::string> notes, CompareReport& report,
                          Observer& observer) {
  const auto unitOf = [&](std::string formats::Metadata::*unit) {
    const std::string& ofA = a.input.metadata.*unit;
    return ofA.empty() ? b.input.metadata.*unit : ofA;
  };
  report.lengthUnit = unitOf(&formats::Metadata::lengthUnit);
  report.timeUnit = unitOf(&formats::Metadata::timeUnit);

  std::vector<model::Body> all = a.bodies;
  all.insert(all.end(), b.bodies.begin(), b.bodies.end());
  const model::TimeSpan span = model::timeSpanOf(all);
  const std::vector<double> times = comparedTimes(options, a, b, span);
  for (const double time : times) {
    if (model::timeWithin(span, time)) continue;
    return invalid(fmt::format("nothing exists at time {}; the meshes last from {} to {}", time,
                               span.begin, span.end));
  }
  const auto note = aliasing(options, a, b, span, times);
  if (note && std::ranges::find(report.notes, *note) == report.notes.end()) notes.push_back(*note);
  observer.noteEach(notes);
  report.notes.insert(report.notes.end(), notes.begin(), notes.end());

  const auto stage = observer.stage("comparing", times.size(), "slices");
  auto slices = compareBodies(a.bodies, b.bodies, times, stage->callback());
  if (!slices) return slices.error();
  report.comparisons.push_back({a.mesh, b.mesh, std::move(*slices), options.volumeExpected});
  if (options.eachBody) {
    auto bodies = compareEachBody(a, b, times, observer);
    if (!bodies) return bodies.error();
    report.comparisons.back().bodies = std::move(*bodies);
  }
  if (!isLast || options.pairs == 0) return {};
  auto pairs = pairsToShow(a, b, times, options.pairs);
  if (!pairs) return pairs.error();
  report.pairs = std::move(*pairs);
  return {};
}

}  // namespace

Result<CompareReport> compare(const ComparedFile& a, std::span<const ComparedFile> others,
                              const CompareOptions& options, Observer& observer) {
  CompareReport report;
  const auto first = openSide(a, nullptr, options, report.notes, observer);
  if (!first) return first.error();
  report.zUp = (*first)->input.metadata.up == "z";
  for (const ComparedFile& other : others) {
    std::vector<std::string> notes;
    const auto side = openSide(other, first->get(), options, notes, observer);
    if (!side) return side.error();
    if (auto done = compareSides(**first, **side, &other == &others.back(), options,
                                 std::move(notes), report, observer);
        !done) {
      return done.error();
    }
  }
  return report;
}

namespace {

constexpr std::uint64_t kMaxSlices = 100'000;
/// The number of pairs of solids that the page shows.
constexpr std::size_t kPictures = 3;

struct CompareArguments {
  std::string input;
  std::string other;  // "" for both backends on `input`
  std::string motion;
  MotionOptions table;
  std::vector<double> voxelSizes;
  voxel4d::FrameTimes frames;
  bool mask = false;
  std::optional<std::string> between;
  std::vector<std::string> caps;
  std::optional<double> rvMin;
  std::optional<std::uint64_t> steps;
  std::string up = "y";
  std::optional<std::uint64_t> slices;
  std::string times;
  std::optional<std::uint64_t> maxCells;
  std::string keep;
  std::string html;
  std::string csv;
  bool eachBody = false;
  bool json = false;

  bool builds() const { return other.empty(); }
};

/// The error message if the options cannot be combined; nothing if they can.
std::optional<std::string> misuseOf(const CompareArguments& options) {
  if (options.builds()) {
    if (options.motion.empty() || options.voxelSizes.empty()) {
      return "one solid needs --motion and --voxel-size; or give two .t4d files";
    }
    return std::nullopt;
  }
  if (!options.motion.empty() || !options.voxelSizes.empty() || options.frames.count ||
      options.frames.step || options.mask || options.between || !options.caps.empty() ||
      options.rvMin || options.steps || !options.keep.empty() || !options.table.table.empty()) {
    return "--motion and its options, --voxel-size, --frames, --frame-time, --mask, --between, "
           "--caps, --rv-min, --steps and --keep are for one solid; two .t4d files are compared as "
           "they are";
  }
  return std::nullopt;
}

/// A path that is not mistaken for an option.
std::string asOperand(const std::string& path) {
  return path.starts_with('-') ? "./" + path : path;
}

/// Makes meshes by `t4d sweep`, each in a process of its own, whose memory can be told. A fork of
/// this process would not do: it lacks the threads that reading the solid may have started.
class SweepProcess {
 public:
  explicit SweepProcess(const CompareArguments& options) : options_(options) {}

  Result<MadeMesh> make(const SweepOptions& sweep) {
    const auto finished = platform::runSelf(wordsFor(sweep));
    if (!finished) return finished.error();
    if (finished->code != kDone && finished->code != kLoss) {
      const auto& voxels = std::get<MotionSweep>(sweep.what).voxels;
      failed_ = finished->code;
      return fail(ErrorCode::Failed,
                  fmt::format("the backend {} made no 4D mesh", voxels ? "voxel4d" : "mesh4d"));
    }
    const auto said = nlohmann::ordered_json::parse(finished->output, nullptr, false);
    if (!said.is_object() || !said.contains("seconds") || !said.contains("peak_bytes")) {
      return fail(ErrorCode::Failed, "`t4d sweep --json` did not say how long it took");
    }
    return MadeMesh{said["seconds"], said["peak_bytes"].get<std::uint64_t>()};
  }

  /// The exit code of the process that made no mesh, and has printed why.
  std::optional<int> failed() const { return failed_; }

 private:
  std::vector<std::string> wordsFor(const SweepOptions& sweep) const {
    const auto& voxels = std::get<MotionSweep>(sweep.what).voxels;
    std::vector<std::string> words = {
        "sweep",     asOperand(options_.input),     "--motion", asOperand(options_.motion),
        "--backend", voxels ? "voxel4d" : "mesh4d", "--up",     options_.up,
        "-o",        asOperand(sweep.output.path),  "--json"};
    const std::vector<std::string> table = options_.table.arguments();
    words.insert(words.end(), table.begin(), table.end());
    const auto add = [&](const char* option, const std::string& value) {
      words.emplace_back(option);
      words.push_back(value);
    };
    if (voxels) {
      add("--voxel-size", fmt::format("{}", voxels->voxelSize));
      if (voxels->times.count) add("--frames", fmt::format("{}", *voxels->times.count));
      if (voxels->times.step) add("--frame-time", fmt::format("{}", *voxels->times.step));
      if (options_.mask) words.emplace_back("--mask");
      if (options_.between) add("--between", *options_.between);
    } else {
      if (options_.rvMin) add("--rv-min", fmt::format("{}", *options_.rvMin));
      if (options_.steps) add("--steps", fmt::format("{}", *options_.steps));
    }
    for (const std::string& caps : options_.caps) {
      if (voxels.has_value() == isVoxelCaps(caps)) add("--caps", caps);
    }
    return words;
  }

  const CompareArguments& options_;
  std::optional<int> failed_;
};

/// A file's name without its folder.
std::string fileNameOf(const std::string& path) {
  return std::filesystem::path(formats::shownName(path)).filename().string();
}

/// The output files, opened before the work begins.
struct Outputs {
  std::optional<formats::OutputFile> html;
  std::optional<formats::OutputFile> csv;
};

Result<Outputs> createOutputs(const CompareArguments& options) {
  Outputs outputs;
  for (const auto& [path, file] :
       {std::pair{&options.html, &outputs.html}, std::pair{&options.csv, &outputs.csv}}) {
    if (path->empty()) continue;
    auto created = formats::OutputFile::create(*path);
    if (!created) return created.error();
    file->emplace(std::move(*created));
  }
  return outputs;
}

void printTables(const std::string& title, const CompareReport& report) {
  const Comparison& comparison = report.comparisons.back();
  print("{}\n\n", title);
  if (report.comparisons.size() > 1) {
    printTable(convergenceTable(report), "lr");
    return;
  }
  printTable(meshTable(report, comparison), "lr");
  print("\n");
  printTable(sliceTable(report, comparison), "r");
}

/// Prints the report and writes it to files.
int finish(const CompareArguments& options, Outputs& outputs, const std::string& title,
           CompareReport report) {
  if (outputs.html) {
    const ProgressBar bar("drawing");
    if (auto written = outputs.html->finish(comparePage(title, report)); !written) {
      return tools::report(written.error());
    }
  }
  if (outputs.csv) {
    if (auto written = outputs.csv->finish(csvOf(report)); !written) {
      return tools::report(written.error());
    }
  }
  if (options.json) {
    printAsJson(report);
  } else {
    printTables(title, report);
  }
  return kDone;
}

CompareOptions compareOptionsOf(const CompareArguments& options) {
  CompareOptions how{.slices = options.slices, .maxCells = options.maxCells};
  how.eachBody = options.eachBody;
  if (!options.times.empty()) how.times = *timesOf(options.times, kMaxSlices);
  if (!options.html.empty()) how.pairs = kPictures;
  return how;
}

MethodsOptions methodsOptionsOf(const CompareArguments& options) {
  MethodsOptions how{options.input, options.motion, options.table.table};
  if (options.rvMin) how.steps = mesh4d::MinVolumeRatio{*options.rvMin};
  if (options.steps) how.steps = mesh4d::StepsPerSegment{*options.steps};
  for (const std::string& caps : options.caps) {
    if (isVoxelCaps(caps)) {
      how.voxels.caps = voxelCapStyle(caps);
    } else if (caps == "cone") {
      how.meshCaps = mesh4d::CapMethod::Cone;
    }
  }
  how.voxelSizes = options.voxelSizes;
  how.voxels.times = options.frames;
  how.voxels.mask = options.mask;
  how.voxels.between = chosenBetween(options.between);
  how.folder = options.keep;
  how.up = options.up;
  how.generator = versionText();
  return how;
}

int buildAndCompare(const CompareArguments& options, Outputs& outputs) {
  ConsoleObserver observer;
  SweepProcess process(options);
  auto done = compareMethods(
      methodsOptionsOf(options), compareOptionsOf(options),
      [&](const SweepOptions& sweep) { return process.make(sweep); }, observer);
  if (!done) {
    const int exitCode = report(done.error());
    return process.failed().value_or(exitCode);
  }
  std::string title =
      fmt::format("{} moved by {}", fileNameOf(options.input), fileNameOf(options.motion));
  if (done->compared.comparisons.size() == 1) {
    const ComparedMesh& woven = done->compared.comparisons.front().b;
    title += fmt::format(", voxels of {}, {}", *woven.voxelSize, counted(*woven.frames, "frame"));
  }
  const int exitCode = finish(options, outputs, title, std::move(done->compared));
  // The backends have reported the losses.
  return exitCode == kDone && !done->losses.empty() ? kLoss : exitCode;
}

int run(const CompareArguments& options) {
  if (const auto misuse = misuseOf(options)) return wrongUsage(*misuse);
  const std::array inputs = {options.input, options.other, options.motion};
  if (auto good = checkOutputs(std::array{options.html, options.csv}, inputs); !good) {
    return report(good.error());
  }
  auto outputs = createOutputs(options);
  if (!outputs) return report(outputs.error());
  if (options.builds()) return buildAndCompare(options, *outputs);
  ConsoleObserver observer;
  const std::array others = {ComparedFile{options.other}};
  auto compared = compare({options.input}, others, compareOptionsOf(options), observer);
  if (!compared) return report(compared.error());
  return finish(options, *outputs,
                fmt::format("{} and {}", fileNameOf(options.input), fileNameOf(options.other)),
                std::move(*compared));
}

}  // namespace

void addCompare(CLI::App& app, int& exitCode) {
  auto* command = app.add_subcommand(
      "compare", "Compare two .t4d files, or both backends on one solid and motion");
  auto options = std::make_shared<CompareArguments>();
  command
      ->add_option("INPUT", options->input,
                   fmt::format("Solid for both backends ({}), or .t4d file (path or URL)",
                               formats::readableTriangleMeshExtensions()))
      ->required();
  command->add_option("OTHER", options->other, "Other .t4d file (path or URL)");
  command->add_option("-m,--motion", options->motion,
                      "Motion: .json, or poses as .csv, .tsv or .txt (docs/motion.md)");
  options->table.addTo(*command);
  command
      ->add_option("--voxel-size", options->voxelSizes,
                   "voxel4d: Voxel edge length, or several: 2,1,0.5, in length units")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->check(numberAboveZero());
  addFrameTimes(*command, options->frames, "voxel4d: ", kFramesByMotion);
  addMaxCellsOption(*command, options->maxCells);
  command->add_flag("--mask", options->mask,
                    "voxel4d: Use masks of inside points instead of level sets");
  addBetween(*command, options->between, "voxel4d: ");
  command
      ->add_option("--caps", options->caps,
                   "Caps of mesh4d (tetgen, cone) or voxel4d (the others); once for each")
      ->check(CLI::IsMember({"tetgen", "cone", "flat", "half-step", "graded"}))
      ->allow_extra_args(false);
  auto* rvMin =
      command
          ->add_option(
              "--rv-min", options->rvMin,
              "mesh4d: Minimum slice volume relative to the solid, in [0, 1) (default: 0.998)")
          ->check(fractionBelowOne());
  command->add_option("--steps", options->steps, "mesh4d: Number of steps per segment")
      ->check(wholeNumber(1, mesh4d::kMaxSteps))
      ->excludes(rvMin);
  command->add_option("--up", options->up, "Axis of the solid that points up")
      ->check(CLI::IsMember({"y", "z"}))
      ->capture_default_str();
  auto* slices = command
                     ->add_option("--slices", options->slices,
                                  "Number of evenly spaced times to compare (default: up to 9)")
                     ->check(wholeNumber(1, kMaxSlices));
  command
      ->add_option("--times", options->times,
                   "Compare N evenly spaced times from A to B, both included")
      ->check(timesUpTo(kMaxSlices))
      ->excludes(slices);
  command->add_option("--keep", options->keep, "Keep the .t4d files in this folder")
      ->check(someName());
  command
      ->add_option("--html", options->html,
                   "Write a page with tables, plots over time and pictures")
      ->check(htmlFile());
  command->add_option("--csv", options->csv, "Write a table with one row per time")
      ->check(outputFile({".csv"}));
  command->add_flag("--each-body", options->eachBody,
                    "Compare each body with that of the same name, in a row for each");
  addJsonOption<CompareReport>(
      *command, options->json,
      "Comparison of two 4D meshes: two files, or the meshes that both backends make of one solid "
      "(a: mesh4d, b: voxel4d, with the smallest voxels if there are several sizes). Lengths and "
      "times of both are in the units of a. Measures are null if they are too large for a double.");
  command->footer(
      "Examples:\n"
      "  t4d compare bolt.obj --motion screw-in.json --voxel-size 0.5 --html bolt.html\n"
      "  t4d compare bolt.obj --motion screw-in.json --voxel-size 2,1,0.5\n"
      "  t4d compare bolt.t4d bolt-voxels.t4d --times 0:2:5 --csv bolt.csv");
  command->callback([=, &exitCode] { exitCode = run(*options); });
}

}  // namespace t4d::tools
