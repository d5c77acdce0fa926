#include <filesystem>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "t4d/convert/flipbook.h"
#include "t4d/convert/morph_flipbook.h"
#include "t4d/convert/rigid_flipbook.h"
#include "t4d/formats/usd/usd_writer.h"
#include "t4d/verbs/origin.h"
#include "tools/program/appearance.h"
#include "tools/program/centering.h"
#include "tools/program/commands.h"
#include "tools/program/console.h"
#include "tools/program/detail_text.h"
#include "tools/program/frame_options.h"
#include "tools/program/gltf_options.h"
#include "tools/program/input_options.h"
#include "tools/program/option_checks.h"
#include "tools/program/velocity_options.h"

namespace t4d::tools {
namespace {

/// No viewer plays a file with more frames.
constexpr std::uint64_t kMaxFrames = 100'000;

struct FlipbookArguments {
  std::string input;
  std::string output;
  FrameOptions frames;
  InputOptions only;
  Appearance appearance;
  VelocityOptions velocity;
  GltfOptions gltf;
  bool visibility = false;
  bool exact = false;
  bool rigid = false;
  bool morph = false;
  bool attributes = false;
  bool center = false;
  bool json = false;
};

std::string kindText(const FlipbookArguments& options, const convert::FrameSlicesReport& written) {
  if (!options.rigid && !options.morph) return detailText(written.light, written.distance);
  return fmt::format("{}, within {:.3g} of the exact slices",
                     options.rigid ? "rigid: one mesh a body and its poses"
                                   : "morph: one mesh a body and its shapes at the layers",
                     written.distance);
}

int run(const FlipbookArguments& options) {
  if (const auto misuse = misuseOfOutput(options.output, {&options.input, 1})) {
    return wrongUsage(*misuse);
  }
  if (const auto uneven = options.frames.unevenOption();
      uneven && (options.rigid || options.morph)) {
    return wrongUsage(*uneven + ": --rigid and --morph play a stretch of time evenly; use --times");
  }
  if ((options.rigid || options.morph) && options.appearance.color == "time") {
    return wrongUsage("--color time: a body of --rigid or --morph has one colour");
  }
  if ((options.rigid || options.morph) && options.appearance.isBySpeed()) {
    return wrongUsage("--color speed: a body of --rigid or --morph has one colour");
  }
  if (const auto misuse = options.velocity.misuse(options.appearance)) return wrongUsage(*misuse);
  if (const auto misuse = options.gltf.misuse(options.output)) return wrongUsage(*misuse);
  if (options.visibility && formats::isUsd(options.output)) {
    return wrongUsage("--visibility is for glTF; USD shows and hides bodies by their visibility");
  }
  if (options.morph && options.gltf.bits > 15) {
    return wrongUsage("--quantize: shapes of --morph have at most 15 bits");
  }
  auto input = verbs::openInput(options.input, options.only);
  if (!input) return report(input.error());
  const model::TimeSpan span = model::timeSpanOf(input->bodies);
  const auto moments = options.frames.of(span, kMaxFrames);
  if (!moments) return report(moments.error());
  const std::vector<double>& times = *moments;
  std::vector<std::string> notices;
  const formats::GltfPlacement placement = verbs::placementOf(input->metadata, notices);
  printNotices(notices);
  convert::FlipbookOptions how;
  how.framesPerSecond = options.frames.framesPerSecond;
  how.detail = options.exact ? slice::SliceDetail::Exact : slice::SliceDetail::Light;
  how.write = {.attributes = options.attributes, .placement = placement};
  how.write.normals = options.appearance.normalStyle();
  if (options.velocity.isNeeded(options.appearance)) {
    if (times.size() == 1) {
      return wrongUsage("--velocity: one frame alone has no speed of playback; take --frames 2");
    }
    how.velocity = options.velocity.ofFrames(options.appearance,
                                             convert::playbackRates(times, how.framesPerSecond));
  }
  auto painting = options.appearance.isBySpeed()
                      ? paintingBySpeed(input->bodies, times, how.detail, *how.velocity)
                      : options.appearance.painting(input->metadata, span, input->bodies);
  if (!painting) return report(inInput(painting.error(), *input));
  how.paint = painting->paint;
  const auto bounds = boundsOf(*input);
  if (!bounds) return report(inInput(bounds.error(), *input));
  how.write.gltf = options.gltf.encoding(options.gltf.bits ? *bounds : model::Bounds3());
  how.write.gltf.visibility = options.visibility;
  how.write.origin = verbs::originOf(input->metadata);
  if (options.center) how.write.center = verbs::roundCenterOf(*bounds);
  Result<convert::FrameSlicesReport> written;
  {
    // Of the other two kinds, slabs are read once for all frames.
    const bool byFrames = !options.rigid && !options.morph;
    ProgressBar bar("slicing", byFrames ? times.size() : 0, "frames");
    const auto write = options.rigid   ? convert::writeRigidFlipbook
                       : options.morph ? convert::writeMorphFlipbook
                                       : convert::writeFlipbook;
    written = write(input->bodies, times, options.output, how, bar.callback());
  }
  if (!written) {
    return report(inInput(written.error(), *input));
  }
  std::uintmax_t bytes = 0;
  auto files = nlohmann::json::array();
  for (const std::filesystem::path& file : written->files) {
    std::error_code unknown;
    const std::uintmax_t size = std::filesystem::file_size(file, unknown);
    if (!unknown) bytes += size;
    files.push_back(file.string());
  }
  if (files.size() > 1) {
    written->notices.push_back(fmt::format(
        "a glTF file cannot hold all frames: they are in {} files, {} to {}, one after the other",
        files.size(), written->files.front().string(), written->files.back().string()));
  }
  printNotices(written->notices);
  const double seconds = static_cast<double>(times.size()) / options.frames.framesPerSecond;
  if (options.json) {
    printJson({{"frames", written->frames},
               {"triangles", written->triangles},
               {"time_begin", times.front()},
               {"time_end", times.back()},
               {"seconds", seconds},
               {"bytes", bytes},
               {"files", files},
               {"rigid", options.rigid},
               {"morph", options.morph},
               {"light", written->light},
               {"distance", written->distance},
               {"max_speed", velocityJson(how.velocity.has_value(), written->maxSpeed)},
               {"clamped", velocityJson(how.velocity.has_value(), written->clamped)},
               {"color_range", painting->range()},
               {"quantization_error", quantizationError(how.write.gltf)}});
  } else {
    print("{}: {} of time {} to {}, plays for {:.4g} s\n  {} in all, {}\n  {}\n",
          written->files.front().string(), counted(written->frames, "frame"), times.front(),
          times.back(), seconds, counted(written->triangles, "triangle"), sizeText(bytes),
          kindText(options, *written));
    printExtra({velocityText(options.velocity, written->maxSpeed, written->clamped,
                             velocityUnit(input->metadata, /*ofPlayback=*/true)),
                painting->text()});
  }
  if (written->triangles == 0) {
    printNotices({"the flipbook is empty: the solid is not there at any of these times"});
  }
  return reportLosses(written->losses, options.center);
}

}  // namespace

void addFlipbook(CLI::App& app, int& exitCode) {
  auto* command =
      app.add_subcommand("flipbook", "Write a 4D mesh as an animated glTF or USD for any viewer");
  auto options = std::make_shared<FlipbookArguments>();
  command->add_option("FILE", options->input, kT4dFileHelp)->required();
  options->frames.addTo(*command, kMaxFrames);
  options->frames.addSpeedTo(*command);
  command->add_option("-o,--output", options->output, "Output file: .glb, .gltf, .usda or .usdz")
      ->required()
      ->check(someName())
      ->check(CLI::Validator(
          [](std::string& path) {
            return formats::isGltf(path) || formats::isUsd(path)
                       ? std::string()
                       : "'" + path + "' is not a .glb, .gltf, .usda or .usdz file";
          },
          ""));
  command->add_flag("--exact", options->exact,
                    "Use exact slices, with up to 13 times as many triangles between layers");
  auto* rigid = command->add_flag("--rigid", options->rigid,
                                  "Write one mesh per body, moved by its poses: smooth, kilobytes");
  rigid->excludes("--exact");
  auto* morph = command->add_flag(
      "--morph", options->morph,
      "Write one mesh per body, with its shape at each layer: smooth, for swept solids");
  morph->excludes("--exact")->excludes("--rigid");
  options->only.addTo(*command);
  command->add_flag("--attributes", options->attributes,
                    "Write attributes; list those that the format cannot store (exit code 3)");
  options->appearance.addTo(*command);
  options->velocity.addTo(*command)->excludes(rigid)->excludes(morph);
  options->gltf.addTo(*command);
  rigid->excludes(command->get_option("--quantize"));
  command
      ->add_flag("--visibility", options->visibility,
                 "Show frames with KHR_node_visibility, not scales (not for Blender, three.js)")
      ->excludes(rigid)
      ->excludes(morph);
  rigid->excludes("--attributes");
  morph->excludes("--attributes");
  addCenterOption(*command, options->center);
  command->add_flag("--json", options->json, "Print JSON");
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
