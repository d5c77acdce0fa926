#include "tools/t4d/weave.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <optional>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "formats/animation/mesh_steps.h"
#include "formats/file_extension.h"
#include "formats/t4d/url.h"
#include "formats/triangle/triangle_mesh_formats.h"
#include "model/number.h"
#include "platform/kept_inputs.h"
#include "platform/stopwatch.h"
#include "tools/t4d/commands.h"
#include "tools/t4d/console.h"
#include "tools/t4d/console_observer.h"
#include "tools/t4d/flat_caps.h"
#include "tools/t4d/frame_order.h"
#include "tools/t4d/json_option.h"
#include "tools/t4d/json_text.h"
#include "tools/t4d/lost_parts.h"
#include "tools/t4d/members.h"
#include "tools/t4d/numbers.h"
#include "tools/t4d/option_checks.h"
#include "tools/t4d/part_option.h"
#include "tools/t4d/t4d_output.h"
#include "tools/t4d/voxel_series.h"
#include "tools/t4d/weave_names.h"
#include "voxel4d/frame_formats.h"
#include "voxel4d/frame_spacing.h"

namespace t4d::tools {
namespace {

using nlohmann::ordered_json;

/// The data on how the file was made, for its metadata.
std::string weaveDetails(const WeaveInput& input, const WeaveOptions& options) {
  const FrameReading& reading = input.reading;
  ordered_json parameters;
  if (reading.voxelSize) parameters["voxel_size"] = *reading.voxelSize;
  if (reading.volumes.iso) {
    parameters[reading.volumes.below ? "below" : "iso"] = *reading.volumes.iso;
  }
  if (const auto& outside = reading.volumes.outside) {
    parameters["outside_value"] =
        std::isnan(*outside) ? ordered_json("nan") : ordered_json(*outside);
  }
  if (!reading.labels.empty()) parameters["labels"] = reading.labels;
  if (!reading.region.empty()) parameters["region"] = reading.region;
  if (reading.hasVelocity()) {
    std::vector<std::string> names;
    for (const std::string& file : reading.velocityFiles) {
      names.push_back(nameIn(formats::shownName(file)).string());
    }
    parameters["velocity"] =
        names.empty() ? reading.velocity : fmt::format("{}", fmt::join(names, ", "));
    parameters["substeps"] = reading.steps();
  }
  parameters["caps"] = nameOfCaps(options.caps);
  parameters["between"] = nameOfBetween(options.between);
  parameters["precision"] = options.output.writing.float32 ? "float32" : "float64";
  if (options.output.writing.step) parameters["grid"] = *options.output.writing.step;
  ordered_json source{{"frames", nameIn(input.name).string()}};
  if (reading.voxelSize && input.files.size() > 1) source["meshes"] = input.files.size();
  return ordered_json{{"source", source}, {"parameters", parameters}}.dump(
      -1, ' ', false, ordered_json::error_handler_t::replace);
}

T4dFile::About aboutWeaving(const WeaveInput& input, const WeaveOptions& options) {
  const auto unit = [](const std::string& given, const std::string& ofFile) {
    return given.empty() ? ofFile : given;
  };
  T4dFile::About about = {"voxel4d", input.name, unit(options.lengthUnit, input.frames.lengthUnit),
                          unit(options.timeUnit, input.frames.timeUnit),
                          weaveDetails(input, options)};
  about.space = input.frames.space;
  const auto& labels = input.reading.labels;
  for (std::size_t i = 0; labels.size() > 1 && i < labels.size(); ++i) {
    const std::string& name = options.output.body;
    about.bodies.push_back({fmt::format("{} {}", name.empty() ? "label" : name, labels[i])});
  }
  return about;
}

/// Frames of velocities in between, of those that a part counts.
std::uint64_t framesInBetween(const model::Part& part, std::uint64_t frames, std::uint64_t steps) {
  const model::PartRange own = part.of(frames - 1);
  const auto ofFiles = [&](std::uint64_t end) { return end / steps + 1; };  // among 0 .. end
  const std::uint64_t before = part.isFirst() ? 0 : ofFiles(own.begin);
  const std::uint64_t counted = own.size() + (part.isFirst() ? 1 : 0);
  return counted - (ofFiles(own.end) - before);
}

/// Weaves the frames of one body and adds it to the report.
Result<void> weaveBody(const WeaveInput& input, const WeaveOptions& options, T4dFile& file,
                       WeaveReport& report, Observer& observer) {
  const auto stage = observer.stage("weaving", input.frames.frames->frameCount(), "frames");
  const auto body = voxel4d::weave(*input.frames.frames,
                                   {.caps = options.caps,
                                    .between = options.between,
                                    .toSpace = input.frames.toSpace,
                                    .part = options.part},
                                   file, stage->callback());
  if (!body) return body.error();
  voxel4d::WeaveReport& all = report.woven;
  all.vertices += body->vertices;
  all.tetrahedra += body->tetrahedra;
  // The first frame of a part is counted by the part before.
  all.frames = body->frames - (options.part.isFirst() ? 0 : 1);
  all.masks += body->masks;
  for (int end = 0; end < 2; ++end) all.capTetrahedra[end] += body->capTetrahedra[end];
  all.partsLost.add(body->partsLost);
  return {};
}

Result<void> weaveBodies(WeaveInput& input, const WeaveOptions& options, T4dFile& file,
                         WeaveReport& report, Observer& observer) {
  const auto& labels = input.reading.labels;
  for (std::size_t i = 0; i < std::max<std::size_t>(1, labels.size()); ++i) {
    if (i > 0) {
      auto frames = framesOfLabel(input, labels[i]);
      if (!frames) return frames.error();
      input.frames = std::move(*frames);
    }
    file.setBody(i);
    if (auto woven = weaveBody(input, options, file, report, observer); !woven) {
      Error error = woven.error();
      if (input.meshes) {
        observer.noteEach(input.meshes->notices);
        if (error.where.empty()) error.where = input.files.front();
      }
      return error;
    }
    if (const std::string notice = input.frames.frames->notice(); !notice.empty()) {
      report.notices.push_back(labels.size() > 1 ? fmt::format("label {}: {}", labels[i], notice)
                                                 : notice);
    }
  }
  return {};
}

/// Notes the files that were opened before.
void noteInputs(const WeaveInput& input) {
  for (const std::string& file : input.files) platform::noteInput(file);
  for (const std::string& file : input.reading.velocityFiles) platform::noteInput(file);
}

}  // namespace

Result<WeaveReport> weave(WeaveInput input, const WeaveOptions& options, Observer& observer) {
  const platform::Stopwatch stopwatch;
  const platform::KeptInputs kept;
  noteInputs(input);
  const std::uint64_t frameCount = input.frames.frames->frameCount();
  auto file = T4dFile::create(options.output, aboutWeaving(input, options));
  if (!file) return file.error();
  WeaveReport report;
  report.notices = input.notices;
  if (!input.frames.notice.empty()) {
    report.notices.push_back(fmt::format("{}: {}", input.name, input.frames.notice));
  }
  std::ranges::copy(input.frames.notes, std::back_inserter(report.notices));
  if (auto woven = weaveBodies(input, options, *file, report, observer); !woven) {
    return woven.error();
  }
  const auto bytes = file->finish();
  if (!bytes) return bytes.error();
  report.framesInBetween = framesInBetween(options.part, frameCount, input.reading.steps());
  report.bytes = *bytes;
  report.space = input.frames.space;
  report.unsized = input.frames.unsized;
  report.assumedAxes = input.frames.assumedAxes;
  report.lengthUnit = options.lengthUnit.empty() ? input.frames.lengthUnit : options.lengthUnit;
  report.timeUnit = options.timeUnit.empty() ? input.frames.timeUnit : options.timeUnit;
  report.oneApart = input.frames.frames->isOneApart();
  report.takenAsDistances = input.frames.takenAsDistances;
  if (input.meshes) {
    std::ranges::copy(input.meshes->notices, std::back_inserter(report.notices));
    report.losses = input.meshes->losses;
  }
  std::ranges::copy(input.frames.losses, std::back_inserter(report.losses));
  std::ranges::copy(file->losses(), std::back_inserter(report.losses));
  report.seconds = input.seconds + stopwatch.seconds();
  return report;
}

void describe(Members& members, const WeaveReport& report) {
  const voxel4d::WeaveReport& woven = report.woven;
  members("vertices", woven.vertices, "Vertices of the 4D mesh, each once.")
      .atLeast(5)
      .joined(Joined::Added);
  members("tetrahedra", woven.tetrahedra, "Cells of the 4D mesh, caps included.")
      .atLeast(5)
      .joined(Joined::Added);
  members("frames", woven.frames,
          "Frames that were woven: grids or meshes that were read, and those in between.")
      .atLeast(2)
      .joined(Joined::Added);
  members("frames_in_between", report.framesInBetween,
          "Of these, the frames that --velocity made between those that were read.")
      .joined(Joined::Added);
  addCosts(members, report.seconds);
  members("cap_tetrahedra", woven.capTetrahedra,
          "Cells that close the mesh at its first and at its last time.")
      .joined(Joined::Added);
  members(
      "space", report.space.empty() ? std::nullopt : std::optional(report.space),
      "What positions are relative to a patient: RAS is x to the right, y anterior, z superior; "
      "LPS is x to the left, y posterior, z superior. null where the files do not say.")
      .oneOf({"RAS", "LPS"})
      .joined(Joined::First);
  members("bytes", report.bytes, "Size of the file, in bytes.").joined(Joined::Unknown);
  addLostParts(members, woven.partsLost);
}

namespace {

constexpr std::uint32_t kMostSubsteps = 1000;

struct WeaveArguments {
  std::vector<std::string> frames;
  FrameReading reading;
  std::vector<std::string> labels;
  std::optional<double> below;
  std::string outside;
  std::string times;
  std::optional<std::uint32_t> substeps;
  std::vector<double> spacing;
  std::vector<double> origin;
  std::string caps = "flat";
  std::optional<std::string> between;
  /// Options by name for inputs that only `python3 -m t4d weave` reads, which takes them from the
  /// words.
  std::map<std::string, std::string> ofPython;
  std::string lengthUnit;
  std::string timeUnit;
  LostPartsOptions lostParts;
  PartOption part;
  T4dOutput output;
  bool json = false;
};

constexpr const char* kAllLabels = "all";

std::optional<std::int64_t> labelOf(const std::string& text) {
  return model::numberIn<std::int64_t>(text);
}

CLI::Validator labelOrAll() {
  return CLI::Validator(
      [](std::string& text) -> std::string {
        if (text == kAllLabels || labelOf(text)) return {};
        return fmt::format("'{}' is neither a whole number of 64 bits nor '{}'", text, kAllLabels);
      },
      "INT|all");
}

/// A number, infinite or NaN included: no sample of a measurement may be finite where there is
/// none.
std::optional<double> sampleOf(const std::string& text) { return model::numberIn<double>(text); }

CLI::Validator sampleValue() {
  return CLI::Validator(
      [](std::string& text) -> std::string {
        return sampleOf(text) ? "" : fmt::format("'{}' is neither a number nor nan", text);
      },
      "V|nan");
}

/// x and y, and some of z, t and c (channels), in some order.
CLI::Validator axesOfArray() {
  return CLI::Validator(
      [](std::string& axes) -> std::string {
        std::string sorted = axes;
        std::ranges::sort(sorted);
        const bool once = std::ranges::adjacent_find(sorted) == sorted.end();
        if (once && sorted.find_first_not_of("ctxyz") == std::string::npos &&
            sorted.find("xy") != std::string::npos) {
          return {};
        }
        return fmt::format("'{}' is not an order of x, y, z, t and c, as tzyx", axes);
      },
      "AXES");
}

CLI::Validator regionOfFrames() {
  return CLI::Validator(
      [](std::string& text) {
        const auto region = voxel4d::parseRegion(text);
        return region ? std::string() : region.error().message;
      },
      "X0:X1,Y0:Y1,Z0:Z1[,T0:T1]");
}

/// The fault in the choice of options for meshes.
std::optional<std::string> misuseOfMeshes(const WeaveArguments& options) {
  const FrameReading& reading = options.reading;
  const bool collected = std::ranges::any_of(
      options.frames, [](const std::string& file) { return formats::isCollection(file); });
  if (collected && options.frames.size() > 1) {
    return "a collection (.pvd) is given alone: it lists the meshes";
  }
  if (!reading.voxelSize) {
    return "triangle meshes need --voxel-size, the edge length of a voxel; meshes that all have "
           "the same triangles can be swept as they are: t4d sweep";
  }
  const voxel4d::VolumeOptions& input = reading.volumes;
  if (input.iso || input.outside || !options.labels.empty() || !input.raw.empty() ||
      !input.axes.empty() || !options.spacing.empty() || !options.origin.empty() ||
      !reading.grid.empty() || !reading.region.empty()) {
    return "--iso, --below, --outside-value, --label, --spacing, --origin, --axes, --raw, --region "
           "and --grid are not for triangle meshes";
  }
  if (collected && input.startTime && !input.frameTime) {
    return "--start-time requires --frame-time";
  }
  return std::nullopt;
}

/// The fault in the options of frames in between.
std::optional<std::string> misuseOfVelocity(const WeaveArguments& options, FrameKind kind) {
  const FrameReading& reading = options.reading;
  if (!reading.hasVelocity()) {
    if (options.substeps) return "--substeps requires --velocity or --velocity-file";
    return std::nullopt;
  }
  if (reading.velocity == "estimate") {
    return "velocities cannot be estimated from the frames; --velocity names a grid that holds "
           "them";
  }
  if (!reading.region.empty()) {
    return "--region and velocities exclude each other: where a solid is cut off it does not move";
  }
  if (!reading.velocity.empty() && kind != FrameKind::Vdb) {
    return "--velocity is for .vdb files, which hold the velocity as a grid; that of a volume is "
           "in files of its own: --velocity-file VX VY VZ";
  }
  if (!reading.velocityFiles.empty() && kind != FrameKind::Volumes) {
    return "--velocity-file is for volumes; the velocity of .vdb files is a grid: --velocity GRID";
  }
  if (!reading.velocityFiles.empty() && reading.velocityFiles.size() != 3) {
    return "--velocity-file takes three files, of the components along x, y and z";
  }
  if (options.between) {
    return "--between is for masks and labels; velocities carry level sets and densities";
  }
  if (!options.labels.empty()) {
    return "--label makes masks; velocities carry level sets and densities";
  }
  return std::nullopt;
}

/// The fault in the options that say what is inside.
std::optional<std::string> misuseOfInside(const WeaveArguments& options) {
  const std::vector<std::string>& labels = options.labels;
  if (!labels.empty() && options.reading.volumes.iso) {
    return fmt::format("--label and {} exclude each other", options.below ? "--below" : "--iso");
  }
  if (!labels.empty() && options.reading.volumes.outside) {
    return "--label and --outside-value exclude each other: what has another label is outside";
  }
  if (options.reading.allLabels && labels.size() > 1) {
    return "--label: 'all' is given alone";
  }
  if (std::set(labels.begin(), labels.end()).size() < labels.size()) {
    return "--label: a label is given twice";
  }
  return std::nullopt;
}

/// What is wrong with the choice of options; nothing if it fits the files.
std::optional<std::string> misuseOfInput(const WeaveArguments& options, FrameKind kind) {
  for (const auto& [name, value] : options.ofPython) {
    if (!value.empty()) return fmt::format("{} is for what python3 -m t4d weave reads", name);
  }
  const FrameReading& reading = options.reading;
  const bool volumes = kind == FrameKind::Volumes;
  if (auto misuse = misuseOfVelocity(options, kind)) return misuse;
  if (kind == FrameKind::Meshes) return misuseOfMeshes(options);
  if (reading.voxelSize) return "--voxel-size is for triangle meshes; grids have voxels already";
  if (volumes && !reading.grid.empty()) return "--grid is for .vdb files";
  const auto allAre = [&](std::string_view extension) {
    return std::ranges::all_of(options.frames, [&](const std::string& file) {
      return formats::lowerCaseExtension(file) == extension;
    });
  };
  if (volumes && !reading.volumes.raw.empty() && !allAre(".raw")) return "--raw is for .raw files";
  if (volumes && !reading.volumes.axes.empty() && !allAre(".npy"))
    return "--axes is for .npy files";
  if (options.frames.front() == "-" && !reading.region.empty()) {
    return "--region is not for standard input (-): who writes it chooses the samples";
  }
  if (auto misuse = misuseOfInside(options)) return misuse;
  if (volumes) return std::nullopt;
  const voxel4d::VolumeOptions& input = reading.volumes;
  if (!options.labels.empty() || input.outside || !input.raw.empty() || !input.axes.empty() ||
      !options.spacing.empty() || !options.origin.empty()) {
    return "--label, --outside-value, --spacing, --origin, --axes and --raw are for volumes; .vdb "
           "files say what they hold";
  }
  if (input.startTime && !input.frameTime) return "--start-time requires --frame-time";
  return std::nullopt;
}

std::string withUnit(const std::string& unit) { return unit.empty() ? "" : " " + unit; }

/// Notices about the frames and the mesh.
std::vector<std::string> noticesOf(const WeaveArguments& options, const WeaveReport& report) {
  std::vector<std::string> notices = report.notices;
  if (!options.part.isGiven()) {
    noticeFlatCaps(voxelCapStyle(options.caps), report.woven, notices);
  }
  noticeLostParts(report.woven.partsLost, notices);
  if (options.between && report.woven.masks == 0) {
    notices.push_back("--between " + *options.between +
                      " has no effect: no frame is a mask or has labels, and the values of level "
                      "sets and densities say when points change sides");
  }
  if (!report.assumedAxes.empty()) {
    notices.push_back(fmt::format(
        "nothing names the axes of the input: they are taken as {}; --axes changes that",
        fmt::join(report.assumedAxes, ", ")));
  }
  if (!report.unsized.empty()) {
    notices.push_back(fmt::format(
        "nothing says how large the voxels are{}: they are taken as 1{}; --spacing changes that",
        report.unsized == "xyz" ? "" : fmt::format(" along {}", fmt::join(report.unsized, " and ")),
        withUnit(report.lengthUnit)));
  }
  if (report.oneApart) {
    notices.push_back(
        fmt::format("the input has no times: frames are taken to be 1{} apart; --frame-time or "
                    "--times changes that",
                    withUnit(report.timeUnit)));
  }
  if (report.takenAsDistances) {
    notices.push_back(
        "the samples are taken as distances: inside is where they are below 0; --iso VALUE takes "
        "them as densities, inside above VALUE, and --below VALUE inside below it");
  }
  return notices;
}

/// The report, with the member that `t4d join` needs of a part.
std::string jsonOf(const WeaveArguments& options, const WeaveReport& report, std::uint64_t frames) {
  return options.part.inReport(Members::valueOf(report), [&] {
    return ordered_json{{"frames", frames}};
  });
}

void printReport(const WeaveArguments& options, const WeaveReport& report) {
  const voxel4d::WeaveReport& woven = report.woven;
  print("{}: {} vertices, {} tetrahedra from {}\n", options.output.path, grouped(woven.vertices),
        grouped(woven.tetrahedra), counted(woven.frames, "frame"));
  if (report.framesInBetween > 0) {
    print("  {} of them in between, by velocities\n", grouped(report.framesInBetween));
  }
  print("  caps of {} and {} tetrahedra\n", grouped(woven.capTetrahedra[0]),
        grouped(woven.capTetrahedra[1]));
  print("  {}, {:.2f} s, peak memory {}\n", sizeText(report.bytes), report.seconds,
        sizeText(peakBytes()));
  if (!report.space.empty()) {
    print("  positions are {}: {}\n", report.space,
          report.space == "RAS" ? "x to the right, y anterior, z superior"
                                : "x to the left, y posterior, z superior");
  }
  if (const auto rounding = options.output.coding.rounding()) print("  {}\n", *rounding);
}

int run(WeaveArguments& options) {
  const auto kind = frameKindOf(options.frames);
  if (!kind) return report(kind.error());
  if (const auto misuse = misuseOfInput(options, *kind)) return wrongUsage(*misuse);
  const std::string order = orderFrames(options.frames);
  if (options.part.isGiven() && options.output.center) {
    return wrongUsage("--part and --center exclude each other: the parts would not meet");
  }
  auto input = openFrames(options.frames, options.reading);
  if (!input) return report(input.error());
  if (!order.empty()) input->notices.insert(input->notices.begin(), order);
  const std::uint64_t frames = input->frames.frames->frameCount();
  if (const auto done = options.part.settle(std::max<std::uint64_t>(frames, 1) - 1,
                                            "steps from frame to frame")) {
    return *done;
  }
  ConsoleObserver observer;
  const auto woven = weave(std::move(*input),
                           {.caps = voxelCapStyle(options.caps),
                            .between = chosenBetween(options.between),
                            .part = options.part.chosen(),
                            .lengthUnit = options.lengthUnit,
                            .timeUnit = options.timeUnit,
                            .output = options.output.fileOptions()},
                           observer);
  if (!woven) return report(woven.error());
  printNotices(noticesOf(options, *woven));
  if (options.json) {
    printText(jsonOf(options, *woven, frames) + "\n");
  } else {
    printReport(options, *woven);
  }
  return options.lostParts.exitCode(woven->woven.partsLost, reportLosses(woven->losses));
}

}  // namespace

void addWeave(CLI::App& app, int& exitCode) {
  auto* command = app.add_subcommand(
      "weave", "Weave a time series of voxel grids or triangle meshes into a 4D mesh");
  auto options = std::make_shared<WeaveArguments>();
  command
      ->add_option("FRAMES", options->frames,
                   "Frames: .vdb files or their folder; volumes: " + volumeExtensions() +
                       "; - for a stream of frames (docs/frame-stream.md); or, with --voxel-size, "
                       "triangle meshes: " +
                       formats::readableTriangleMeshExtensions() + ", or a .pvd that lists them")
      ->required();
  command
      ->add_option("--voxel-size", options->reading.voxelSize,
                   "Triangle meshes: voxel edge length, in length units")
      ->check(numberAboveZero());
  command
      ->add_option("--iso", options->reading.volumes.iso,
                   "Densities: inside is above this value (default: distances, inside below 0)")
      ->check(finiteNumber());
  command
      ->add_option("--below", options->below, "Inside is below this value, instead of above --iso")
      ->check(finiteNumber())
      ->excludes("--iso");
  command
      ->add_option("--label", options->labels,
                   "Volumes: integer label of the inside; several labels, or all, make a body each")
      ->check(labelOrAll());
  command
      ->add_option("--outside-value", options->outside,
                   "Volumes: samples of this value are no data and lie outside; nan: not numbers")
      ->check(sampleValue());
  command
      ->add_option("--frame-time", options->reading.volumes.frameTime,
                   "Time between frames (default: from the files, else 1)")
      ->check(numberAboveZero());
  command
      ->add_option("--start-time", options->reading.volumes.startTime,
                   "Time of the first frame (default: from the file, else 0)")
      ->check(finiteNumber());
  command
      ->add_option("--times", options->times,
                   "Time of each frame: T1,T2,...; or A:B:N for N frames, evenly spaced")
      ->check(timesUpTo(voxel4d::kMaxFrames))
      ->excludes("--frame-time", "--start-time");
  command->add_option("--grid", options->reading.grid,
                      "Use only grids with this name (default: all)");
  command
      ->add_option("--velocity", options->reading.velocity,
                   "Velocity grid of .vdb files: makes frames in between (docs/weave.md)")
      ->check(someName());
  command
      ->add_option("--velocity-file", options->reading.velocityFiles,
                   "Velocities of volumes: makes frames in between (docs/weave.md)")
      ->type_name("VX VY VZ")
      ->expected(1, 3)
      ->delimiter(',')
      ->check(someName());
  command
      ->add_option("--substeps", options->substeps,
                   fmt::format("Steps from frame to frame with velocities (default: {})",
                               FrameReading().substeps))
      ->check(wholeNumber(1, kMostSubsteps));
  addNumbers(*command, "--spacing", options->spacing,
             "Volumes: voxel edge lengths (default: from the file, else 1)", 1, 3, "DX [DY DZ]")
      ->check(numberAboveZero());
  addNumbers(*command, "--origin", options->origin,
             "Volumes: position of the first sample (default: from the file, else 0 0 0)", 3, 3,
             "X Y Z");
  command
      ->add_option("--axes", options->reading.volumes.axes,
                   "Axis order of .npy arrays (default: txyz, or xyz for several files)")
      ->check(axesOfArray());
  command
      ->add_option("--region", options->reading.region,
                   "Samples and frames to use, counted from 0 (default: all)")
      ->check(regionOfFrames());
  command->add_option("--raw", options->reading.volumes.raw,
                      "Layout of .raw files without header: 'TYPE NX NY NZ [NT] [little|big]'");
  command->add_option("--caps", options->caps, "Caps at the ends (docs/weave.md)")
      ->check(CLI::IsMember(voxelCaps()))
      ->capture_default_str();
  addBetween(*command, options->between, "");
  command->add_option("--length-unit", options->lengthUnit, "Length unit of the grids, such as mm");
  command->add_option("--time-unit", options->timeUnit, "Unit of the times, such as s");
  options->lostParts.addTo(*command);
  options->part.addTo(*command, "Weave only part K of N; `t4d join` joins the parts");
  options->output.addTo(*command);
  addJsonOption<WeaveReport>(*command, options->json, "What was made: a 4D mesh in a .t4d file.");
  for (const auto& [name, help] : {
           std::pair{"--channel", "Which of several channels, counted from 0, or its name"},
           std::pair{"--level", "OME-Zarr: level of the image (default: 0, the finest)"},
           std::pair{"--series", "DICOM: which of several series, by number or UID; TIFF: image"},
           std::pair{"--dataset", "HDF5, Zarr, VTK: path or name of the array"},
       }) {
    command->add_option(name, options->ofPython[name], help)
        ->group("Of python3 -m t4d weave, which reads DICOM, TIFF, Zarr, HDF5 and others as well");
  }
  command->footer(
      "Examples:\n  t4d weave frames/*.vdb -o moving.t4d\n"
      "  t4d weave heart.nrrd --label 2 -o heart.t4d\n"
      "  t4d weave heart.nii.gz --iso 900 --region 100:400,80:300,:,0:50 -o part.t4d\n"
      "  t4d weave scan_*.nii.gz --iso 300 --frame-time 0.04 -o scan.t4d\n"
      "  t4d weave frames/water_*.obj --voxel-size 0.01 --frame-time 0.04 -o water.t4d\n"
      "  python3 -m t4d weave dicom_folder --iso 300 -o scan.t4d");
  command->callback([=, &exitCode] {
    const auto& spacing = options->spacing;
    if (spacing.size() == 2) {
      exitCode = wrongUsage("--spacing is one length, or three");
      return;
    }
    if (!spacing.empty()) {
      options->reading.volumes.spacing = {spacing.front(), spacing[spacing.size() / 2],
                                          spacing.back()};
    }
    if (const auto& origin = options->origin; !origin.empty()) {
      options->reading.volumes.origin = {origin[0], origin[1], origin[2]};
    }
    if (options->substeps) options->reading.substeps = *options->substeps;
    if (options->below) {
      options->reading.volumes.iso = options->below;
      options->reading.volumes.below = true;
    }
    if (!options->outside.empty()) options->reading.volumes.outside = sampleOf(options->outside);
    if (!options->times.empty()) {
      options->reading.volumes.times = *timesOf(options->times, voxel4d::kMaxFrames);
    }
    for (const std::string& label : options->labels) {
      options->reading.allLabels = options->reading.allLabels || label == kAllLabels;
      if (const auto number = labelOf(label)) options->reading.labels.push_back(*number);
    }
    exitCode = run(*options);
  });
}

}  // namespace t4d::tools
