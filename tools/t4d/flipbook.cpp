#include "tools/t4d/flipbook.h"

#include <cmath>
#include <filesystem>

#include <fmt/format.h>

#include "formats/gltf/gltf_writer.h"
#include "formats/usd/usd_writer.h"
#include "model/units.h"
#include "t4d/convert.h"
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
#include "tools/t4d/slice_write_options.h"
#include "tools/t4d/slice_writing.h"

namespace t4d::tools {
namespace {

/// Whether the times between frames differ by less than anybody sees.
bool areEven(std::span<const double> times) {
  constexpr double kUnseen = 0.01;  // of the time between two frames
  const double step = (times.back() - times.front()) / static_cast<double>(times.size() - 1);
  for (std::size_t i = 0; i < times.size(); ++i) {
    const double even = times.front() + static_cast<double>(i) * step;
    if (std::abs(times[i] - even) > kUnseen * std::abs(step)) return false;
  }
  return true;
}

/// The frames per second at which each is shown at its own time; nothing if its unit is another
/// than the second, and for frames that are not evenly spaced.
std::optional<double> realRate(std::span<const double> times, const std::string& timeUnit) {
  const auto seconds = model::timeConversion(timeUnit, "s");
  if (!seconds || !seconds->isIdentity()) return std::nullopt;
  if (times.front() == times.back() || !areEven(times)) return std::nullopt;
  return static_cast<double>(times.size() - 1) / std::abs(times.back() - times.front());
}

double rateOf(const FlipbookOptions& options, std::size_t frames, std::optional<double> realRate) {
  constexpr double kUsual = 24;
  if (options.framesPerSecond) return *options.framesPerSecond;
  if (options.seconds) return static_cast<double>(frames) / *options.seconds;
  return realRate.value_or(kUsual);
}

Result<convert::FrameSlicesReport> writeFrames(const Input& input, const FlipbookOptions& options,
                                               std::span<const double> times,
                                               const convert::FlipbookOptions& how,
                                               Observer& observer) {
  // The other two kinds read slabs once for all frames.
  const bool byFrames = options.kind == FlipbookKind::Frames;
  const auto stage = observer.stage("slicing", byFrames ? times.size() : 0, "frames");
  const auto write = options.kind == FlipbookKind::Rigid   ? convert::writeRigidFlipbook
                     : options.kind == FlipbookKind::Morph ? convert::writeMorphFlipbook
                                                           : convert::writeFlipbook;
  auto written = write(input.bodies, times, options.output, how, stage->callback());
  if (!written) return inInput(written.error(), input);
  return written;
}

std::uint64_t sizeOfFiles(const std::vector<std::filesystem::path>& files) {
  std::uint64_t bytes = 0;
  for (const std::filesystem::path& file : files) {
    std::error_code unknown;
    const std::uintmax_t size = std::filesystem::file_size(file, unknown);
    if (!unknown) bytes += size;
  }
  return bytes;
}

}  // namespace

Result<FlipbookReport> flipbook(const Input& input, const FlipbookOptions& options,
                                Observer& observer) {
  const std::vector<double> times = timesOfFrames(options.times, input);
  std::vector<std::string> notices;
  const formats::GltfPlacement placement = placementOf(input.metadata, notices);
  observer.noteEach(notices);
  convert::FlipbookOptions how;
  const std::optional<double> real = realRate(times, input.metadata.timeUnit);
  how.framesPerSecond = rateOf(options, times.size(), real);
  const bool exact = options.exact || options.write.isColoredByTrack();
  how.detail = exact ? slice::SliceDetail::Exact : slice::SliceDetail::Light;
  std::vector<double> rates;
  if (options.write.needsVelocity()) {
    if (times.size() == 1) return oneFrameHasNoSpeed();
    rates = convert::playbackRates(times, how.framesPerSecond);
  }
  auto looks = frameLooksOf(options.write, input, times, how.detail, std::move(rates), observer);
  if (!looks) return looks.error();
  how.write = looks->write;
  how.write.placement = placement;
  how.write.gltf.visibility = options.visibility;
  how.velocity = looks->velocity;
  how.paint = looks->painting.paint;
  how.meanings = input.metadata.attributes;
  auto written = writeFrames(input, options, times, how, observer);
  if (!written) return written.error();
  const std::vector<std::filesystem::path>& files = written->files;
  if (files.size() > 1) {
    written->notices.push_back(fmt::format(
        "a glTF file cannot hold all frames: they are in {} files, {} to {}, one after the other",
        files.size(), files.front().string(), files.back().string()));
  }
  observer.noteEach(written->notices);
  FlipbookReport report;
  report.kind = options.kind;
  report.bytes = sizeOfFiles(files);
  report.written = std::move(*written);
  report.firstTime = times.front();
  report.lastTime = times.back();
  report.seconds = static_cast<double>(times.size()) / how.framesPerSecond;
  report.inRealTime = real == how.framesPerSecond;
  report.hasVelocity = how.velocity.has_value();
  report.colorRange = looks->painting.range;
  report.quantizationError = quantizationErrorOf(how.write.gltf);
  return report;
}

void describe(Members& members, const FlipbookReport& report) {
  const convert::FrameSlicesReport& written = report.written;
  members("frames", written.frames, "Number of frames.").atLeast(1).atMost(100'000);
  members("triangles", written.triangles,
          "Triangles of all frames together; of all bodies, if rigid or morph.");
  members("time_begin", report.firstTime, "The mesh's time at the first frame, in its time units.");
  members("time_end", report.lastTime, "The mesh's time at the last frame, in its time units.");
  members("seconds", report.seconds,
          "Duration of the animation, in seconds: frames divided by --fps.")
      .above(0);
  members("bytes", report.bytes, "Size of all files together, in bytes.");
  members("files", written.files,
          "Paths of the files. If one file would be too large for its format, there are several, "
          "each with the frames after those of the previous file.")
      .itemsFrom(1);
  members("rigid", report.kind == FlipbookKind::Rigid,
          "Whether there is one mesh for each body, moved by its poses, instead of frames.");
  members("morph", report.kind == FlipbookKind::Morph,
          "Whether there is one mesh for each body, with a morph target for each layer, instead of "
          "frames.");
  addFrameMembers(members, written, report.hasVelocity, report.colorRange,
                  report.quantizationError);
}

namespace {

/// No viewer plays a file with more frames.
constexpr std::uint64_t kMaxFrames = 100'000;

struct FlipbookArguments {
  std::string input;
  FrameOptions frames;
  const CLI::Option* fps = nullptr;
  InputOptions only;
  FlipbookOptions flipbook;
  bool rigid = false;
  bool morph = false;
  bool json = false;
};

FlipbookKind kindOf(const FlipbookArguments& options) {
  return options.rigid   ? FlipbookKind::Rigid
         : options.morph ? FlipbookKind::Morph
                         : FlipbookKind::Frames;
}

std::string kindText(const FlipbookReport& made) {
  const double distance = made.written.distance;
  if (made.kind == FlipbookKind::Frames) return detailText(made.written.light, distance);
  return fmt::format("{}, within {:.3g} of the exact slices",
                     made.kind == FlipbookKind::Rigid
                         ? "rigid: one mesh per body and its poses"
                         : "morph: one mesh per body and its shapes at the layers",
                     distance);
}

/// Why these options cannot be.
std::optional<std::string> misuseOf(const FlipbookArguments& options) {
  const FlipbookOptions& how = options.flipbook;
  const bool byFrames = how.kind == FlipbookKind::Frames;
  if (const auto uneven = options.frames.unevenOption(); uneven && !byFrames) {
    return *uneven + ": --rigid and --morph play a stretch of time evenly; use --times A:B:N";
  }
  const std::string& color = how.write.color;
  if (!byFrames && (color == "time" || color == "speed" || color == "track")) {
    return fmt::format("--color {}: a body of --rigid or --morph has one colour", color);
  }
  if (how.seconds && !options.frames.speedFile.empty()) {
    return "--duration: the curve of --speed-file says how long the animation plays";
  }
  if (auto misuse = misuseOfMaxSpeed(how.write)) return misuse;
  if (auto misuse = misuseOfEncoding(how.write, how.output)) return misuse;
  if (how.visibility && formats::isUsd(how.output)) {
    return "--visibility is for glTF; USD shows and hides bodies by their visibility";
  }
  if (how.kind == FlipbookKind::Morph && how.write.quantizeBits > 15) {
    return "--quantize: shapes of --morph have at most 15 bits";
  }
  return std::nullopt;
}

void printReport(const FlipbookOptions& how, const FlipbookReport& made,
                 const formats::Metadata& metadata) {
  const convert::FrameSlicesReport& written = made.written;
  print("{}: {} of time {} to {}, plays for {:.4g} s{}\n  {} in all, {}\n  {}\n",
        written.files.front().string(), counted(written.frames, "frame"), made.firstTime,
        made.lastTime, made.seconds, made.inRealTime ? ", in real time" : "",
        counted(written.triangles, "triangle"), sizeText(made.bytes), kindText(made));
  printExtra({velocityText(how.write, written.maxSpeed, written.clamped,
                           velocityUnit(metadata, /*ofPlayback=*/true)),
              colorText(how.write, made.colorRange)});
}

int run(FlipbookArguments& options) {
  FlipbookOptions& how = options.flipbook;
  how.kind = kindOf(options);
  if (const auto misuse = misuseOf(options)) return wrongUsage(*misuse);
  const auto input = openInput(options.input, options.only);
  if (!input) return report(input.error());
  auto times = options.frames.of(model::timeSpanOf(input->bodies), kMaxFrames);
  if (!times) return report(times.error());
  how.times = std::move(*times);
  // The frames of a speed curve are made for a frame rate.
  if (options.fps->count() > 0 || !options.frames.speedFile.empty()) {
    how.framesPerSecond = options.frames.framesPerSecond;
  }
  ConsoleObserver observer;
  const auto made = flipbook(*input, how, observer);
  if (!made && made.error().remedy == Remedy::MoreFrames) {
    return wrongUsage("--velocity: " + made.error().message + "; take --frames 2");
  }
  if (!made) return report(made.error());
  if (options.json) {
    printAsJson(*made);
  } else {
    printReport(how, *made, input->metadata);
  }
  if (made->written.triangles == 0) {
    printNotices({"the flipbook is empty: the solid is not there at any of these times"});
  }
  return reportLosses(made->written.losses, how.write.center);
}

}  // namespace

void addFlipbook(CLI::App& app, int& exitCode) {
  auto* command =
      app.add_subcommand("flipbook", "Write a 4D mesh as an animated glTF or USD for any viewer");
  auto options = std::make_shared<FlipbookArguments>();
  FlipbookOptions& flipbook = options->flipbook;
  command->add_option("FILE", options->input, kT4dFileHelp)->required();
  options->frames.addTo(*command, kMaxFrames);
  auto* fps = options->frames.addSpeedTo(*command);
  fps->description("Frames per second (default: real time if time is in s, otherwise 24)");
  fps->default_str("");
  options->fps = fps;
  command
      ->add_option("--duration", flipbook.seconds,
                   "Duration of the animation in seconds, instead of --fps")
      ->check(numberAboveZero())
      ->excludes(fps);
  command->add_option("-o,--output", flipbook.output, "Output file: .glb, .gltf, .usda or .usdz")
      ->required()
      ->check(someName())
      ->check(outputByExtension({".glb", ".gltf", ".usda", ".usdz"}));
  command->add_flag("--exact", flipbook.exact,
                    "Use exact slices, with up to 13 times as many triangles between layers");
  auto* rigid = command->add_flag("--rigid", options->rigid,
                                  "Write one mesh per body, moved by its poses: smooth, kilobytes");
  rigid->excludes("--exact");
  auto* morph = command->add_flag(
      "--morph", options->morph,
      "Write one mesh per body, with its shape at each layer: smooth, for swept solids");
  morph->excludes("--exact")->excludes("--rigid");
  options->only.addTo(*command);
  addSliceWriteOptions(*command, flipbook.write);
  command->get_option("--velocity")->excludes(rigid)->excludes(morph);
  rigid->excludes(command->get_option("--quantize"));
  command
      ->add_flag("--visibility", flipbook.visibility,
                 "Show frames with KHR_node_visibility, not scales (not for Blender, three.js)")
      ->excludes(rigid)
      ->excludes(morph);
  addCenterOption(*command, flipbook.write.center);
  addJsonOption<FlipbookReport>(*command, options->json,
                                "The animated glTF or USD that was written.");
  command->footer(
      "Frames, the default, are for any solid and any viewer, which draws the triangles of all "
      "frames\n"
      "in every picture. --rigid and --morph draw those of one; a solid that only moves and turns "
      "takes\n"
      "--rigid, one that is deformed --morph.\n\n"
      "Example:\n  t4d flipbook bolt.t4d --frames 48 -o bolt-moving.glb");
  command->callback([=, &exitCode] { exitCode = run(*options); });
}

}  // namespace t4d::tools
