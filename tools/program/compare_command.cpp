#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <variant>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "t4d/formats/motion/motion_reader.h"
#include "t4d/formats/output_file.h"
#include "t4d/formats/t4d/url.h"
#include "t4d/formats/triangle/triangle_mesh_formats.h"
#include "t4d/measure/compare.h"
#include "t4d/measure/mesh_check.h"
#include "t4d/measure/mesh_quality.h"
#include "t4d/mesh4d/steps.h"
#include "t4d/model/converted_source.h"
#include "t4d/model/times.h"
#include "t4d/system/child_process.h"
#include "t4d/system/replaceable.h"
#include "t4d/system/temporary_folder.h"
#include "t4d/verbs/motion_frames.h"
#include "t4d/verbs/origin.h"
#include "t4d/voxel4d/voxelize.h"
#include "tools/program/commands.h"
#include "tools/program/compare_page.h"
#include "tools/program/compare_text.h"
#include "tools/program/console.h"
#include "tools/program/input_options.h"
#include "tools/program/motion_options.h"
#include "tools/program/numbers.h"
#include "tools/program/option_checks.h"
#include "tools/program/voxel_series.h"

namespace t4d::tools {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

constexpr std::uint64_t kMaxSlices = 100'000;
/// The number of pairs of solids shown on the page.
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

/// The solid and its motion. Its volume is constant.
struct Truth {
  model::TriangleMesh mesh;
  model::Motion motion;
  bool lossy;                      ///< the file of the solid holds more than was read
  std::vector<std::string> files;  ///< all that were read

  double volume() const { return std::abs(signedVolume(mesh)); }
  double hypervolume() const { return volume() * (motion.timeEnd() - motion.timeBegin()); }
};

Result<Truth> truthOf(const CompareArguments& options) {
  auto loaded = [&] {
    const ProgressBar bar("reading " + options.input);
    return formats::readTriangleMesh(options.input);
  }();
  if (!loaded) return loaded.error();
  auto motion = formats::readMotion(options.motion, nullptr, options.table.table);
  if (!motion) return motion.error();
  std::vector<std::string> files = {options.input, options.motion};
  for (const auto& file : loaded->otherFiles) files.push_back(file.string());
  return Truth{std::move(loaded->mesh), std::move(*motion), !loaded->losses.empty(),
               std::move(files)};
}

/// A 4D mesh in a file, and what is known about how it was made.
struct MeshFile {
  std::string path;
  ComparedMesh mesh;
};

/// A path that is not mistaken for an option.
std::string asOperand(const std::string& path) {
  return path.starts_with('-') ? "./" + path : path;
}

/// The name of the file that a backend makes.
std::string builtName(const CompareArguments& options, std::optional<double> voxelSize) {
  std::string name = fs::path(options.input).stem().string() + (voxelSize ? "-voxel4d" : "-mesh4d");
  if (voxelSize && options.voxelSizes.size() > 1) name += fmt::format("-{}", *voxelSize);
  return name + ".t4d";
}

/// Runs a backend in a separate process to make its mesh. If that fails, the backend has printed
/// why, and the result is its exit code. `voxelSize` is for voxel4d, nothing for mesh4d.
Result<std::variant<MeshFile, int>> build(const CompareArguments& options, const Truth& truth,
                                          const fs::path& folder, std::optional<double> voxelSize,
                                          std::vector<std::string>& notes) {
  const std::string backend = voxelSize ? "voxel4d" : "mesh4d";
  MeshFile file;
  file.path = (folder / builtName(options, voxelSize)).string();
  std::vector<std::string> arguments = {"sweep",     asOperand(options.input),
                                        "--motion",  asOperand(options.motion),
                                        "--backend", backend,
                                        "--up",      options.up,
                                        "-o",        asOperand(file.path),
                                        "--json"};
  const std::vector<std::string> table = options.table.arguments();
  arguments.insert(arguments.end(), table.begin(), table.end());
  const auto add = [&](const char* option, const std::string& value) {
    arguments.emplace_back(option);
    arguments.push_back(value);
  };
  file.mesh.hypervolumeExpected = truth.hypervolume();
  if (voxelSize) {
    // The other process prints its notices, too.
    auto times = verbs::motionFrameTimes(options.frames, *voxelSize, truth.mesh, truth.motion,
                                         options.motion, notes);
    if (!times) return times.error();
    file.mesh.name =
        fmt::format("voxel method, {}{}{}", *voxelSize, truth.motion.lengthUnit.empty() ? "" : " ",
                    truth.motion.lengthUnit);
    file.mesh.voxelSize = *voxelSize;
    file.mesh.frames = times->size();
    add("--voxel-size", fmt::format("{}", *voxelSize));
    add("--frames", fmt::format("{}", times->size()));
    if (options.frames.step) add("--frame-time", fmt::format("{}", *options.frames.step));
    if (options.mask) arguments.emplace_back("--mask");
    if (options.between) add("--between", *options.between);
  } else {
    file.mesh.name = "mesh method";
    if (options.rvMin) add("--rv-min", fmt::format("{}", *options.rvMin));
    if (options.steps) add("--steps", fmt::format("{}", *options.steps));
  }
  for (const std::string& caps : options.caps) {
    if (voxelSize.has_value() == isVoxelCaps(caps)) add("--caps", caps);
  }
  const auto finished = system::runSelf(arguments);
  if (!finished) return finished.error();
  if (finished->code != kDone && finished->code != kLoss) {
    say("the backend " + backend + " made no 4D mesh");
    return finished->code;
  }
  const auto said = ordered_json::parse(finished->output, nullptr, false);
  if (!said.is_object() || !said.contains("seconds") || !said.contains("peak_bytes")) {
    return fail(ErrorCode::Failed, "`t4d sweep --json` did not say how long it took");
  }
  file.mesh.seconds = said["seconds"];
  file.mesh.peakBytes = said["peak_bytes"];
  return file;
}

/// A file's name without its folder.
std::string nameOf(const std::string& path) {
  return fs::path(formats::shownName(path)).filename().string();
}

/// An open file, converted to the units of the other file if they differ.
struct Side {
  explicit Side(verbs::Input opened) : input(std::move(opened)), bodies(input.bodies) {}
  Side(const Side&) = delete;
  Side& operator=(const Side&) = delete;

  verbs::Input input;
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
  if (verbs::originOf(ofA) != verbs::originOf(ofB)) {
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
Result<void> measure(Side& side, const MeshFile& file) {
  ComparedMesh& mesh = side.mesh;
  mesh = file.mesh;
  mesh.backend = side.input.metadata.backend;
  mesh.bytes = side.input.reader->fileBytes();
  if (mesh.name.empty()) {
    mesh.name = nameOf(file.path);
    if (!mesh.backend.empty()) mesh.name += " (" + mesh.backend + ")";
  }
  ProgressBar bar("measuring " + nameOf(file.path), verbs::slabCountOf(side.bodies), "slabs");
  for (const model::Body& body : side.bodies) {
    auto report = measure::checkMesh(*body.source, {}, bar.part(body.source->slabCount()));
    if (!report) {
      Error error = report.error();
      if (error.where.empty()) error.where = side.input.name;
      return error;
    }
    mesh.vertices += report->vertices;
    mesh.tetrahedra += report->tetrahedra;
    mesh.hypervolume += report->hypervolume;
    if (!report->valid()) {
      printNotices(
          {fmt::format("{}: body '{}' is not a closed, oriented 4D mesh; `t4d validate` "
                       "says why",
                       side.input.name, body.name)});
    }
  }
  return {};
}

/// Measures the shape of the cells, with the time scale of the other mesh or, without one, the mean
/// normal speed of this one.
Result<void> measureCells(Side& side, std::optional<double> timeScale) {
  CellShapes& shapes = side.mesh.shapes;
  ProgressBar bar("measuring the cells of " + side.mesh.name);
  if (!timeScale) {
    const auto speed = measure::meanNormalSpeed(side.bodies, bar.callback());
    if (!speed) return inInput(speed.error(), side.input);
    timeScale = *speed > 0 ? *speed : 1;
  }
  const auto quality =
      measure::measureQuality(side.bodies, {.timeScale = *timeScale, .worst = 0}, bar.callback());
  if (!quality) return inInput(quality.error(), side.input);
  shapes.timeScale = *timeScale;
  for (std::size_t k = 0; k < measure::kQualityMeasures.size(); ++k) {
    const std::string_view name = measure::kQualityMeasures[k].name;
    if (name != "radius_ratio" && name != "smallest_angle") continue;
    const measure::Distribution all = quality->all(k);
    (name == "radius_ratio" ? shapes.radiusRatio : shapes.smallestAngle) = {
        all.quantile(0.01), all.quantile(0.5), all.quantile(0.99)};
  }
  return {};
}

/// The times to compare at. Without options, in the middle of steps: of a swept mesh, since the
/// volume of a woven one changes little between its frames.
std::vector<double> timesOf(const CompareArguments& options, const Side& a, const Side& b,
                            const model::TimeSpan& span) {
  constexpr std::uint64_t kDefaultSlices = 9;
  if (!options.times.empty()) return *tools::timesOf(options.times, kMaxSlices);
  if (options.slices) return model::evenTimes(span, *options.slices);
  const bool ofB = a.mesh.backend == "voxel4d" && b.mesh.backend != "voxel4d";
  return measure::timesAmidSteps(ofB ? b.bodies : a.bodies, span, kDefaultSlices);
}

/// If all times fall on layers of a mesh: what that misses, and a number of slices that would not.
std::optional<std::string> aliasing(const CompareArguments& options, const Side& a, const Side& b,
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
  if (!options.times.empty()) return note + "; choose other --times";
  constexpr std::uint64_t kTries = 20;
  for (std::uint64_t n = times.size() + 1; n < times.size() + kTries; ++n) {
    const std::vector<double> others = model::evenTimes(span, n);
    if (2 * measure::timesOnLayers(a.bodies, others) > n) continue;
    if (2 * measure::timesOnLayers(b.bodies, others) > n) continue;
    return note + fmt::format("; try --slices {}", n);
  }
  return note;
}

/// The solids at the first, a middle and the last of the times.
Result<std::vector<SolidPair>> pairsToShow(const Side& a, const Side& b,
                                           const std::vector<double>& times) {
  std::vector<SolidPair> pairs;
  const std::size_t count = std::min(kPictures, times.size());
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

Result<void> writeAll(std::optional<formats::OutputFile>& file, const std::string& text) {
  return file->write(text.data(), text.size()).and_then([&] { return file->commit(); });
}

/// Compares each of `others` with `file`, adds to the report, and prints and writes it.
int compareFiles(const CompareArguments& options, Outputs& outputs, const MeshFile& file,
                 const std::vector<MeshFile>& others, CompareReport report,
                 std::optional<double> volumeExpected) {
  auto openedA = verbs::openInput(file.path, {.bodies = {}, .maxCells = options.maxCells});
  if (!openedA) return tools::report(openedA.error());
  Side a(std::move(*openedA));
  if (auto measured = measure(a, file); !measured) return tools::report(measured.error());
  if (auto measured = measureCells(a, {}); !measured) return tools::report(measured.error());
  for (const MeshFile& other : others) {
    auto openedB = verbs::openInput(other.path, {.bodies = {}, .maxCells = options.maxCells});
    if (!openedB) return tools::report(openedB.error());
    Side b(std::move(*openedB));
    std::vector<std::string> notes;
    if (auto done = convertUnits(a, b, notes); !done) {
      return tools::report(done.error());
    }
    if (auto measured = measure(b, other); !measured) return tools::report(measured.error());
    if (auto measured = measureCells(b, a.mesh.shapes.timeScale); !measured) {
      return tools::report(measured.error());
    }
    const auto unitOf = [&](std::string formats::Metadata::*unit) {
      const std::string& ofA = a.input.metadata.*unit;
      return ofA.empty() ? b.input.metadata.*unit : ofA;
    };
    report.lengthUnit = unitOf(&formats::Metadata::lengthUnit);
    report.timeUnit = unitOf(&formats::Metadata::timeUnit);

    std::vector<model::Body> all = a.bodies;
    all.insert(all.end(), b.bodies.begin(), b.bodies.end());
    const model::TimeSpan span = model::timeSpanOf(all);
    const std::vector<double> times = timesOf(options, a, b, span);
    for (const double time : times) {
      if (model::timeWithin(span, time)) continue;
      return tools::report(Error{ErrorCode::InvalidInput,
                                 fmt::format("nothing exists at time {}; the meshes last from {} "
                                             "to {}",
                                             time, span.begin, span.end),
                                 {},
                                 {}});
    }
    const auto note = aliasing(options, a, b, span, times);
    if (note && std::ranges::find(report.notes, *note) == report.notes.end()) {
      notes.push_back(*note);
    }
    printNotices(notes);
    report.notes.insert(report.notes.end(), notes.begin(), notes.end());

    ProgressBar bar("comparing", times.size(), "slices");
    auto slices = measure::compareAt(a.bodies, b.bodies, times, {}, bar.callback());
    if (!slices) return tools::report(slices.error());
    report.comparisons.push_back({a.mesh, b.mesh, std::move(*slices), volumeExpected});
    if (outputs.html && &other == &others.back()) {
      auto pairs = pairsToShow(a, b, times);
      if (!pairs) return tools::report(pairs.error());
      report.pairs = std::move(*pairs);
      report.zUp = a.input.metadata.up == "z";
    }
  }
  if (outputs.html) {
    const ProgressBar bar("drawing");
    if (auto written = writeAll(outputs.html, comparePage(report)); !written) {
      return tools::report(written.error());
    }
  }
  if (outputs.csv) {
    if (auto written = writeAll(outputs.csv, compareCsv(report)); !written) {
      return tools::report(written.error());
    }
  }
  if (options.json) {
    printJson(compareJson(report));
  } else {
    printText(report);
  }
  return kDone;
}

int buildAndCompare(const CompareArguments& options, Outputs& outputs) {
  auto truth = truthOf(options);
  if (!truth) return report(truth.error());
  for (const std::string& output : {options.html, options.csv}) {
    if (const auto misuse = misuseOfOutput(output, truth->files)) return wrongUsage(*misuse);
  }
  std::optional<system::TemporaryFolder> temporary;
  fs::path folder = options.keep;
  if (options.keep.empty()) {
    auto created = system::TemporaryFolder::create();
    if (!created) return report(created.error());
    folder = created->path();
    temporary.emplace(std::move(*created));
  } else {
    std::error_code error;
    fs::create_directories(folder, error);
    if (error) {
      return report(Error{
          ErrorCode::Failed, "cannot create the folder: " + error.message(), options.keep, {}});
    }
  }

  std::vector<std::optional<double>> sizes = {std::nullopt};  // mesh4d first
  std::set<double, std::greater<>> unique(options.voxelSizes.begin(), options.voxelSizes.end());
  sizes.insert(sizes.end(), unique.begin(), unique.end());
  for (const std::optional<double>& size : sizes) {
    const std::string name = builtName(options, size);
    if (auto good = system::checkReplaceable(folder, {&name, 1}); !good) {
      return report(good.error());
    }
  }
  CompareReport made;
  std::vector<MeshFile> files;
  for (const std::optional<double>& size : sizes) {
    auto built = build(options, *truth, folder, size, made.notes);
    if (!built) return report(built.error());
    if (const int* exitCode = std::get_if<int>(&*built)) return *exitCode;
    files.push_back(std::get<MeshFile>(std::move(*built)));
  }
  const MeshFile meshMethod = std::move(files.front());
  files.erase(files.begin());
  made.title = fmt::format("{} moved by {}", nameOf(options.input), nameOf(options.motion));
  if (files.size() == 1) {
    made.title += fmt::format(", voxels of {}, {}", *files.front().mesh.voxelSize,
                              counted(*files.front().mesh.frames, "frame"));
  }
  const int done =
      compareFiles(options, outputs, meshMethod, files, std::move(made), truth->volume());
  // The backends have reported the losses.
  return done == kDone && truth->lossy ? kLoss : done;
}

int run(const CompareArguments& options) {
  if (const auto misuse = misuseOf(options)) return wrongUsage(*misuse);
  for (const std::string& output : {options.html, options.csv}) {
    if (const auto misuse =
            misuseOfOutput(output, std::array{options.input, options.other, options.motion})) {
      return wrongUsage(*misuse);
    }
  }
  if (const auto misuse = misuseOfOutputs(std::array{options.html, options.csv})) {
    return wrongUsage(*misuse);
  }
  auto outputs = createOutputs(options);
  if (!outputs) return report(outputs.error());
  if (options.builds()) return buildAndCompare(options, *outputs);
  CompareReport made;
  made.title = fmt::format("{} and {}", nameOf(options.input), nameOf(options.other));
  return compareFiles(options, *outputs, {options.input, {}}, {{options.other, {}}},
                      std::move(made), {});
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
      ->check(evenTimesUpTo(kMaxSlices))
      ->excludes(slices);
  command->add_option("--keep", options->keep, "Keep the .t4d files in this folder")
      ->check(someName());
  command
      ->add_option("--html", options->html,
                   "Write a page with tables, plots over time and pictures")
      ->check(someName());
  command->add_option("--csv", options->csv, "Write a table with one row per time")
      ->check(someName());
  command->add_flag("--json", options->json, "Print the comparison as JSON");
  command->footer(
      "Examples:\n"
      "  t4d compare bolt.obj --motion screw-in.json --voxel-size 0.5 --html bolt.html\n"
      "  t4d compare bolt.obj --motion screw-in.json --voxel-size 2,1,0.5\n"
      "  t4d compare bolt.t4d bolt-voxels.t4d --times 0:2:5 --csv bolt.csv");
  command->callback([=, &exitCode] { exitCode = run(*options); });
}

}  // namespace t4d::tools
