#include <filesystem>
#include <optional>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "t4d/convert/frame_files.h"
#include "t4d/formats/file_extension.h"
#include "t4d/formats/triangle/triangle_mesh_formats.h"
#include "t4d/formats/usd/usd_writer.h"
#include "t4d/verbs/origin.h"
#include "t4d/verbs/rasterize.h"
#include "tools/program/appearance.h"
#include "tools/program/centering.h"
#include "tools/program/commands.h"
#include "tools/program/console.h"
#include "tools/program/console_observer.h"
#include "tools/program/detail_text.h"
#include "tools/program/frame_options.h"
#include "tools/program/gltf_options.h"
#include "tools/program/input_options.h"
#include "tools/program/option_checks.h"
#include "tools/program/part_option.h"
#include "tools/program/velocity_options.h"

namespace t4d::tools {
namespace {

constexpr std::uint64_t kMostFrameFiles = 1'000'000;

struct FramesArguments {
  std::string input;
  std::string output;
  std::string format;
  FrameOptions frames;
  PartOption part;
  const CLI::Option* fps = nullptr;
  InputOptions only;
  Appearance appearance;
  VelocityOptions velocity;
  GltfOptions gltf;
  std::optional<double> voxelSize;
  bool light = false;
  bool attributes = false;
  bool center = false;
  bool json = false;
};

/// Why no frame may be written: one of them is the input.
std::optional<std::string> misuseOfFrames(const convert::FrameNames& names, std::uint64_t count,
                                          const std::string& input) {
  if (formats::lowerCaseExtension(input) != formats::lowerCaseExtension("a" + names.extension)) {
    return std::nullopt;
  }
  for (std::uint64_t i = 0; i < count; ++i) {
    const auto path = names.folder / names.fileName(i, count);
    if (auto misuse = misuseOfOutput(path.string(), {&input, 1})) return misuse;
  }
  return std::nullopt;
}

convert::FrameSpace spaceOf(const formats::Metadata& metadata) {
  return {metadata.lengthUnit, metadata.timeUnit, metadata.up};
}

constexpr const char* kFpsNeeds = "--fps: needs --speed-file, --velocity or USD files";

/// The options say how fast the frames play.
bool plays(const FramesArguments& options) {
  return options.fps->count() > 0 || !options.frames.speedFile.empty();
}

/// OpenVDB grids, as `rasterize` writes them.
int runGrids(const FramesArguments& options) {
  if (!options.voxelSize) return wrongUsage("--format vdb needs --voxel-size");
  if (plays(options) && options.frames.speedFile.empty()) return wrongUsage(kFpsNeeds);
  const Appearance& looks = options.appearance;
  if (options.light || options.attributes || options.center || options.gltf.bits ||
      options.gltf.meshopt || options.velocity.velocity || !looks.normals.empty() ||
      !looks.color.empty()) {
    return wrongUsage(
        "--format vdb: grids have no --light, --attributes, --center, --quantize, --meshopt, "
        "--normals, --velocity or --color");
  }
  auto input = verbs::openInput(options.input, options.only);
  if (!input) return report(input.error());
  const auto moments = options.frames.of(model::timeSpanOf(input->bodies), kMostFrameFiles);
  if (!moments) return report(moments.error());
  ConsoleObserver observer;
  const auto done = verbs::writeGridFrames(
      *input, {.times = *moments, .voxelSize = *options.voxelSize, .folder = options.output},
      observer);
  if (!done) return report(done.error());
  const voxel4d::VoxelSeries& series = done->written.series;
  if (options.json) {
    printText(jsonOf(*done) + "\n");
  } else {
    print("{}: {} of level sets from time {} to {}\n  {} inside, {}; listed in {}\n",
          options.output, counted(series.frames, "frame"), done->written.time.begin,
          done->written.time.end, counted(series.insidePoints, "point"), sizeText(series.bytes),
          done->manifest.string());
  }
  std::vector<std::string> notices;
  verbs::noticeEmptyFrames(series, notices);
  printNotices(notices);
  return kDone;
}

int run(const FramesArguments& options) {
  if (options.format == "vdb" && options.part.isGiven()) {
    return wrongUsage("--part: write grids in parts with t4d rasterize");
  }
  if (options.format == "vdb") return runGrids(options);
  if (options.voxelSize) return wrongUsage("--voxel-size: only for --format vdb");
  // A pattern has an extension of its own.
  const bool isPattern = options.output.find('%') != std::string::npos;
  std::string extension = options.format.empty() ? "" : "." + options.format;
  if (extension.empty() && !isPattern) extension = ".glb";
  const auto names = convert::frameNames(options.output, extension);
  if (!names) return wrongUsage(names.error().message);
  const bool isUsd = formats::isUsd("a" + names->extension);
  if (isUsd && options.part.chosen().count > 1) {
    return wrongUsage("--part: USD frames come with a file of all, for which each is needed");
  }
  if (plays(options) && options.frames.speedFile.empty() && !options.velocity.velocity && !isUsd) {
    return wrongUsage(kFpsNeeds);
  }
  if (const auto misuse = options.gltf.misuse("a" + names->extension)) return wrongUsage(*misuse);
  if (const auto misuse = options.velocity.misuse(options.appearance)) return wrongUsage(*misuse);
  auto input = verbs::openInput(options.input, options.only);
  if (!input) return report(input.error());
  const formats::Metadata& metadata = input->metadata;
  const model::TimeSpan span = model::timeSpanOf(input->bodies);
  const auto moments = options.frames.of(span, kMostFrameFiles);
  if (!moments) return report(moments.error());
  const std::vector<double>& times = *moments;
  if (const auto done = options.part.settle(times.size(), "frames")) return *done;
  const model::Part part = options.part.chosen();
  const model::PartRange own = part.of(times.size());
  if (const auto misuse = misuseOfFrames(*names, times.size(), options.input)) {
    return wrongUsage(*misuse);
  }
  convert::FrameFilesOptions how;
  how.part = part;
  how.detail = options.light ? slice::SliceDetail::Light : slice::SliceDetail::Exact;
  how.space = spaceOf(metadata);
  how.framesPerSecond = options.frames.framesPerSecond;
  how.write.attributes = options.attributes;
  how.write.normals = options.appearance.normalStyle();
  const bool inPlayback = isUsd || plays(options);
  if (inPlayback && options.velocity.velocity && times.size() == 1) {
    return wrongUsage(
        "--velocity: one frame alone has no speed of playback; take --frames 2, or leave out "
        "--fps");
  }
  how.velocity = options.velocity.ofFrames(
      options.appearance, inPlayback ? convert::playbackRates(times, options.frames.framesPerSecond)
                                     : std::vector<double>());
  auto painting = options.appearance.isBySpeed()
                      ? paintingBySpeed(input->bodies, times, how.detail, *how.velocity)
                      : options.appearance.painting(metadata, span, input->bodies);
  if (!painting) return report(inInput(painting.error(), *input));
  how.paint = painting->paint;
  const auto bounds = boundsOf(*input);
  if (!bounds) return report(inInput(bounds.error(), *input));
  how.write.gltf = options.gltf.encoding(options.gltf.bits ? *bounds : model::Bounds3());
  how.write.origin = verbs::originOf(metadata);
  if (options.center) how.write.center = verbs::roundCenterOf(*bounds);
  if (formats::triangleMeshFormat("a" + names->extension)->placed) {
    std::vector<std::string> notices;
    how.write.placement = verbs::placementOf(metadata, notices);
    printNotices(notices);
  }
  Result<convert::FrameFilesReport> written;
  {
    ProgressBar bar("slicing", own.size(), "frames");
    written = convert::writeFrameFiles(input->bodies, times, *names, how, bar.callback());
  }
  if (!written) {
    return report(inInput(written.error(), *input));
  }
  printNotices(written->notices);
  const std::string manifest =
      (names->folder /
       (part.count > 1 ? convert::manifestOfPart(names->manifest, part) : names->manifest))
          .string();
  if (options.json) {
    nlohmann::ordered_json result = {
        {"frames", written->frames},
        {"triangles", written->triangles},
        {"time_begin", times[own.begin]},
        {"time_end", times[own.end - 1]},
        {"bytes", written->bytes},
        {"manifest", manifest},
        {"light", written->light},
        {"distance", written->distance},
        {"max_speed", velocityJson(how.velocity.has_value(), written->maxSpeed)},
        {"clamped", velocityJson(how.velocity.has_value(), written->clamped)},
        {"color_range", painting->range()},
        {"quantization_error", quantizationError(how.write.gltf)}};
    if (options.part.isGiven()) {
      result["part"] = options.part.json(identityOf(*input, times.size()));
    }
    printJson(result);
  } else {
    const auto first = names->folder / names->fileName(own.begin, times.size());
    print("{}: {} of time {} to {}\n  {} in all, {}; listed in {}\n  {}\n",
          written->frames > 1 ? first.string() + ", ..." : first.string(),
          counted(written->frames, "frame"), times[own.begin], times[own.end - 1],
          counted(written->triangles, "triangle"), sizeText(written->bytes), manifest,
          detailText(written->light, written->distance));
    printExtra({velocityText(options.velocity, written->maxSpeed, written->clamped,
                             velocityUnit(metadata, inPlayback)),
                painting->text(), quantizationText(how.write.gltf)});
  }
  return reportLosses(written->losses, options.center);
}

}  // namespace

void addFrames(CLI::App& app, int& exitCode) {
  auto* command =
      app.add_subcommand("frames", "Write a 4D mesh as numbered triangle meshes, one per time");
  auto options = std::make_shared<FramesArguments>();
  command->add_option("FILE", options->input, kT4dFileHelp)->required();
  options->frames.addTo(*command, kMostFrameFiles);
  options->fps = options->frames.addSpeedTo(*command)->description(
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
      "--light", options->light,
      "Interpolate the triangles of the layers: up to 13 times fewer, same in all frames");
  options->only.addTo(*command);
  options->part.addTo(*command, "Write only part K of N of the frames, into the same folder");
  command->add_flag("--attributes", options->attributes,
                    "Write attributes; list those that the format cannot store (exit code 3)");
  options->appearance.addTo(*command);
  options->velocity.addTo(*command);
  options->gltf.addTo(*command);
  addCenterOption(*command, options->center);
  command->add_flag("--json", options->json, "Print JSON");
  command->footer("Example:\n  t4d frames bolt.t4d --frames 60 --format vtp -o bolt-frames");
  command->callback([=, &exitCode] { exitCode = run(*options); });
}

}  // namespace t4d::tools
