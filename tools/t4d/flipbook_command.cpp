#include <fmt/format.h>

#include "formats/gltf/gltf_writer.h"
#include "formats/usd/usd_writer.h"
#include "tools/t4d/centering.h"
#include "tools/t4d/commands.h"
#include "tools/t4d/console.h"
#include "tools/t4d/console_observer.h"
#include "tools/t4d/detail_text.h"
#include "tools/t4d/frame_options.h"
#include "tools/t4d/input_options.h"
#include "tools/t4d/json_option.h"
#include "tools/t4d/option_checks.h"
#include "tools/t4d/slice_write_options.h"
#include "tools/verbs/flipbook.h"

namespace t4d::tools {
namespace {

/// No viewer plays a file with more frames.
constexpr std::uint64_t kMaxFrames = 100'000;

struct FlipbookArguments {
  std::string input;
  FrameOptions frames;
  const CLI::Option* fps = nullptr;
  InputOptions only;
  verbs::FlipbookOptions flipbook;
  bool rigid = false;
  bool morph = false;
  bool json = false;
};

verbs::FlipbookKind kindOf(const FlipbookArguments& options) {
  return options.rigid   ? verbs::FlipbookKind::Rigid
         : options.morph ? verbs::FlipbookKind::Morph
                         : verbs::FlipbookKind::Frames;
}

std::string kindText(const verbs::FlipbookReport& made) {
  const double distance = made.written.distance;
  if (made.kind == verbs::FlipbookKind::Frames) return detailText(made.written.light, distance);
  return fmt::format("{}, within {:.3g} of the exact slices",
                     made.kind == verbs::FlipbookKind::Rigid
                         ? "rigid: one mesh per body and its poses"
                         : "morph: one mesh per body and its shapes at the layers",
                     distance);
}

/// Why these options cannot be.
std::optional<std::string> misuseOf(const FlipbookArguments& options) {
  const verbs::FlipbookOptions& how = options.flipbook;
  const bool byFrames = how.kind == verbs::FlipbookKind::Frames;
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
  if (how.kind == verbs::FlipbookKind::Morph && how.write.quantizeBits > 15) {
    return "--quantize: shapes of --morph have at most 15 bits";
  }
  return std::nullopt;
}

void printReport(const verbs::FlipbookOptions& how, const verbs::FlipbookReport& made,
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
  verbs::FlipbookOptions& how = options.flipbook;
  how.kind = kindOf(options);
  if (const auto misuse = misuseOf(options)) return wrongUsage(*misuse);
  const auto input = verbs::openInput(options.input, options.only);
  if (!input) return report(input.error());
  auto times = options.frames.of(model::timeSpanOf(input->bodies), kMaxFrames);
  if (!times) return report(times.error());
  how.times = std::move(*times);
  // The frames of a speed curve are made for a frame rate.
  if (options.fps->count() > 0 || !options.frames.speedFile.empty()) {
    how.framesPerSecond = options.frames.framesPerSecond;
  }
  ConsoleObserver observer;
  const auto made = verbs::flipbook(*input, how, observer);
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
  verbs::FlipbookOptions& flipbook = options->flipbook;
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
  addJsonOption<verbs::FlipbookReport>(*command, options->json,
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
