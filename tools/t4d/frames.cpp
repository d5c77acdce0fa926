#include "tools/t4d/frames.h"

#include <filesystem>
#include <optional>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "formats/file_extension.h"
#include "formats/triangle/triangle_mesh_formats.h"
#include "formats/usd/usd_writer.h"
#include "tools/t4d/centering.h"
#include "tools/t4d/commands.h"
#include "tools/t4d/console.h"
#include "tools/t4d/console_observer.h"
#include "tools/t4d/detail_text.h"
#include "tools/t4d/frame_options.h"
#include "tools/t4d/input.h"
#include "tools/t4d/json_option.h"
#include "tools/t4d/members.h"
#include "tools/t4d/option_checks.h"
#include "tools/t4d/origin.h"
#include "tools/t4d/part_option.h"
#include "tools/t4d/rasterize.h"
#include "tools/t4d/slice_write_options.h"
#include "tools/t4d/slice_writing.h"

namespace t4d::tools {
namespace {

/// A name with the extension of the frames.
std::string anyFrame(const FramesOptions& options) { return "a" + options.names.extension; }

}  // namespace

Result<FramesReport> frames(const Input& input, const FramesOptions& options, Observer& observer) {
  const std::vector<double> times = timesOfFrames(options.times, input);
  const formats::Metadata& metadata = input.metadata;
  const bool inPlayback = options.inPlayback || formats::isUsd(anyFrame(options));
  if (inPlayback && options.write.velocity && times.size() == 1) return oneFrameHasNoSpeed();
  convert::FrameFilesOptions how;
  how.part = options.part;
  how.detail = options.light ? slice::SliceDetail::Light : slice::SliceDetail::Exact;
  how.space = {metadata.lengthUnit, metadata.timeUnit, metadata.up};
  how.framesPerSecond = options.framesPerSecond;
  auto looks = frameLooksOf(
      options.write, input, times, how.detail,
      inPlayback ? convert::playbackRates(times, options.framesPerSecond) : std::vector<double>(),
      observer);
  if (!looks) return looks.error();
  how.write = looks->write;
  how.velocity = looks->velocity;
  how.paint = looks->painting.paint;
  const auto* format = formats::triangleMeshFormat(anyFrame(options));
  if (format != nullptr && format->placed) {
    std::vector<std::string> notices;
    how.write.placement = placementOf(metadata, notices);
    observer.noteEach(notices);
  }
  const model::PartRange own = options.part.of(times.size());
  auto written = [&] {
    const auto stage = observer.stage("slicing", own.size(), "frames");
    return convert::writeFrameFiles(input.bodies, times, options.names, how, stage->callback());
  }();
  if (!written) return inInput(written.error(), input);
  observer.noteEach(written->notices);
  FramesReport report;
  report.written = std::move(*written);
  report.manifest =
      options.names.folder / (options.part.count > 1
                                  ? convert::manifestOfPart(options.names.manifest, options.part)
                                  : options.names.manifest);
  report.firstTime = times[own.begin];
  report.lastTime = times[own.end - 1];
  report.hasVelocity = how.velocity.has_value();
  report.colorRange = looks->painting.range;
  report.quantizationError = quantizationErrorOf(how.write.gltf);
  return report;
}

void describe(Members& members, const FramesReport& report) {
  const convert::FrameFilesReport& written = report.written;
  members("frames", written.frames, "Number of frames, each a file.")
      .atLeast(1)
      .atMost(1'000'000)
      .joined(Joined::Added);
  members("triangles", report.ofGrids ? std::nullopt : std::optional(written.triangles),
          "Triangles of all frames together; null for OpenVDB grids.")
      .joined(Joined::Added);
  members("time_begin", report.firstTime, "The mesh's time at the first frame, in its time units.")
      .joined(Joined::First);
  members("time_end", report.lastTime, "The mesh's time at the last frame, in its time units.")
      .joined(Joined::Last);
  members("bytes", written.bytes, "Size of all frames together, in bytes.").joined(Joined::Added);
  members("manifest", report.manifest, "Path of the manifest, which lists the files.")
      .joined(Joined::First);
  addFrameMembers(members, written, report.hasVelocity, report.colorRange,
                  report.quantizationError);
}

namespace {

constexpr std::uint64_t kMostFrameFiles = 1'000'000;

struct FramesArguments {
  std::string input;
  std::string output;
  std::string format;
  FrameOptions when;
  PartOption part;
  const CLI::Option* fps = nullptr;
  InputOptions only;
  std::optional<double> voxelSize;
  FramesOptions frames;
  bool json = false;
};

constexpr const char* kFpsNeeds = "--fps: needs --speed-file, --velocity or USD files";

/// The options say how fast the frames play.
bool plays(const FramesArguments& options) {
  return options.fps->count() > 0 || !options.when.speedFile.empty();
}

/// OpenVDB grids, as `rasterize` writes them.
int runGrids(const FramesArguments& options) {
  if (!options.voxelSize) return wrongUsage("--format vdb needs --voxel-size");
  if (plays(options) && options.when.speedFile.empty()) return wrongUsage(kFpsNeeds);
  const SliceWriteOptions& write = options.frames.write;
  if (options.frames.light || write.attributes || write.center || write.quantizeBits ||
      write.meshopt || write.velocity || write.normals || !write.color.empty()) {
    return wrongUsage(
        "--format vdb: grids have no --light, --attributes, --center, --quantize, --meshopt, "
        "--normals, --velocity or --color");
  }
  auto input = openInput(options.input, options.only);
  if (!input) return report(input.error());
  const auto moments = options.when.of(model::timeSpanOf(input->bodies), kMostFrameFiles);
  if (!moments) return report(moments.error());
  ConsoleObserver observer;
  const auto done = writeGridFrames(
      *input, {.times = *moments, .voxelSize = *options.voxelSize, .folder = options.output},
      observer);
  if (!done) return report(done.error());
  const voxel4d::VoxelSeries& series = done->written.series;
  if (options.json) {
    printAsJson(*done);
  } else {
    print("{}: {} of level sets from time {} to {}\n  {} inside, {}; listed in {}\n",
          options.output, counted(series.frames, "frame"), done->written.time.begin,
          done->written.time.end, counted(series.insidePoints, "point"), sizeText(series.bytes),
          done->manifest.string());
  }
  std::vector<std::string> notices;
  noticeEmptyFrames(series, notices);
  printNotices(notices);
  return kDone;
}

void printReport(const FramesArguments& options, const FramesReport& made,
                 const formats::Metadata& metadata) {
  const FramesOptions& how = options.frames;
  const convert::FrameFilesReport& written = made.written;
  const std::uint64_t begin = how.part.of(how.times.size()).begin;
  const auto first = how.names.folder / how.names.fileName(begin, how.times.size());
  print("{}: {} of time {} to {}\n  {} in all, {}; listed in {}\n  {}\n",
        written.frames > 1 ? first.string() + ", ..." : first.string(),
        counted(written.frames, "frame"), made.firstTime, made.lastTime,
        counted(written.triangles, "triangle"), sizeText(written.bytes), made.manifest.string(),
        detailText(written.light, written.distance));
  printExtra({velocityText(how.write, written.maxSpeed, written.clamped,
                           velocityUnit(metadata, how.inPlayback)),
              colorText(how.write, made.colorRange),
              quantizationText(how.write, made.quantizationError)});
}

int run(FramesArguments& options) {
  if (options.format == "vdb" && options.part.isGiven()) {
    return wrongUsage("--part: write grids in parts with t4d rasterize");
  }
  if (options.format == "vdb") return runGrids(options);
  if (options.voxelSize) return wrongUsage("--voxel-size: only for --format vdb");
  // A pattern has an extension of its own.
  const bool isPattern = options.output.find('%') != std::string::npos;
  std::string extension = options.format.empty() ? "" : "." + options.format;
  if (extension.empty() && !isPattern) extension = ".glb";
  auto names = convert::frameNames(options.output, extension);
  if (!names) return wrongUsage(names.error().message);
  FramesOptions& how = options.frames;
  how.names = std::move(*names);
  how.part = options.part.chosen();
  const bool isUsd = formats::isUsd(anyFrame(how));
  if (isUsd && how.part.count > 1) {
    return wrongUsage("--part: USD frames come with a file of all, for which each is needed");
  }
  if (plays(options) && options.when.speedFile.empty() && !how.write.velocity && !isUsd) {
    return wrongUsage(kFpsNeeds);
  }
  if (how.light && how.write.isColoredByTrack()) {
    return wrongUsage("--color track: not with --light");
  }
  if (const auto misuse = misuseOfEncoding(how.write, anyFrame(how))) return wrongUsage(*misuse);
  if (const auto misuse = misuseOfMaxSpeed(how.write)) return wrongUsage(*misuse);
  const auto input = openInput(options.input, options.only);
  if (!input) return report(input.error());
  auto times = options.when.of(model::timeSpanOf(input->bodies), kMostFrameFiles);
  if (!times) return report(times.error());
  how.times = std::move(*times);
  if (const auto done = options.part.settle(how.times.size(), "frames")) return *done;
  how.inPlayback = isUsd || plays(options);
  how.framesPerSecond = options.when.framesPerSecond;
  ConsoleObserver observer;
  const auto made = frames(*input, how, observer);
  if (!made && made.error().remedy == Remedy::MoreFrames) {
    return wrongUsage("--velocity: " + made.error().message +
                      "; take --frames 2, or leave out --fps");
  }
  if (!made) return report(made.error());
  if (options.json) {
    const auto identity = [&] { return identityOf(*input, how.times.size()); };
    printText(options.part.inReport(Members::valueOf(*made), identity) + "\n");
  } else {
    printReport(options, *made, input->metadata);
  }
  return reportLosses(made->written.losses, how.write.center);
}

}  // namespace

void addFrames(CLI::App& app, int& exitCode) {
  auto* command =
      app.add_subcommand("frames", "Write a 4D mesh as numbered triangle meshes, one per time");
  auto options = std::make_shared<FramesArguments>();
  command->add_option("FILE", options->input, kT4dFileHelp)->required();
  options->when.addTo(*command, kMostFrameFiles);
  options->fps = options->when.addSpeedTo(*command)->description(
      "Frames per second of playback, for --speed-file, --velocity and USD");
  command
      ->add_option("-o,--output", options->output,
                   "Output folder, or file name pattern such as out/bolt_%04d.ply")
      ->required()
      ->check(someName());
  command
      ->add_option("--format", options->format, "File format for an output folder (default: glb)")
      ->check(CLI::Validator(
          [](std::string& name) {
            if (name == "vdb") return std::string();
            const auto* format = formats::triangleMeshFormat("a." + name);
            return format != nullptr && format->write != nullptr
                       ? std::string()
                       : fmt::format("'{}' is not the extension of a format that is written: {}",
                                     name, formats::writableTriangleMeshExtensions());
          },
          "glb|gltf|ply|stl|obj|off|vtp|usda|usdz|vdb"));
  command
      ->add_option("--voxel-size", options->voxelSize,
                   "Voxel edge length for --format vdb, in length units")
      ->check(numberAboveZero());
  command->add_flag(
      "--light", options->frames.light,
      "Interpolate the triangles of the layers: up to 13 times fewer, same in all frames");
  options->only.addTo(*command);
  options->part.addTo(*command, "Write only part K of N of the frames, into the same folder");
  addSliceWriteOptions(*command, options->frames.write);
  addCenterOption(*command, options->frames.write.center);
  addJsonOption<FramesReport>(
      *command, options->json,
      "What was written: a triangle mesh or an OpenVDB grid for each time, and a manifest.");
  command->footer("Example:\n  t4d frames bolt.t4d --frames 60 --format vtp -o bolt-frames");
  command->callback([=, &exitCode] { exitCode = run(*options); });
}

}  // namespace t4d::tools
