#include <algorithm>
#include <charconv>
#include <chrono>
#include <filesystem>
#include <optional>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "t4d/formats/animation/mesh_steps.h"
#include "t4d/formats/file_extension.h"
#include "t4d/formats/t4d/http_files.h"
#include "t4d/formats/t4d/url.h"
#include "t4d/formats/triangle/triangle_mesh_formats.h"
#include "t4d/verbs/lost_parts.h"
#include "t4d/verbs/t4d_file.h"
#include "t4d/voxel4d/advected_frames.h"
#include "t4d/voxel4d/vdb_frames.h"
#include "t4d/voxel4d/volumes/volume_frames.h"
#include "t4d/voxel4d/volumes/volume_velocity.h"
#include "t4d/voxel4d/weave.h"
#include "tools/program/commands.h"
#include "tools/program/console.h"
#include "tools/program/mesh_frames.h"
#include "tools/program/option_checks.h"
#include "tools/program/part_option.h"
#include "tools/program/t4d_output.h"
#include "tools/program/voxel_series.h"

namespace t4d::tools {
namespace {

using nlohmann::ordered_json;

constexpr std::uint32_t kDefaultSubsteps = 4;
constexpr std::uint32_t kMostSubsteps = 1000;

struct WeaveArguments {
  std::vector<std::string> frames;
  voxel4d::VolumeOptions input;
  std::vector<std::int64_t> labels;
  std::string grid;
  std::string velocity;                    // a grid of .vdb files
  std::vector<std::string> velocityFiles;  // of volumes
  std::optional<std::uint32_t> substeps;
  std::optional<double> voxelSize;
  std::vector<double> spacing;
  std::vector<double> origin;
  std::string region;
  std::string caps = "flat";
  std::optional<std::string> between;
  std::string lengthUnit;
  std::string timeUnit;
  LostPartsOptions lostParts;
  PartOption part;
  T4dOutput output;
  bool json = false;

  bool hasVelocity() const { return !velocity.empty() || !velocityFiles.empty(); }
  /// Steps from one frame to the next.
  std::uint32_t steps() const { return hasVelocity() ? substeps.value_or(kDefaultSubsteps) : 1; }
};

/// ".nrrd, .nhdr, ...".
std::string volumeExtensions() {
  std::vector<std::string_view> extensions;
  for (const auto& format : voxel4d::volumeFormats()) extensions.push_back(format.extension);
  return fmt::format("{}", fmt::join(extensions, ", "));
}

/// CLI11 takes the nearest for numbers that are too large.
CLI::Validator wholeNumberOf64Bits() {
  return CLI::Validator(
      [](std::string& text) -> std::string {
        std::int64_t value = 0;
        const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
        if (error == std::errc{} && end == text.data() + text.size()) return {};
        return fmt::format("'{}' is not a whole number of 64 bits", text);
      },
      "INT");
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

std::string detailsOf(const WeaveArguments& options) {
  ordered_json parameters;
  if (options.voxelSize) parameters["voxel_size"] = *options.voxelSize;
  if (options.input.iso) parameters["iso"] = *options.input.iso;
  if (!options.labels.empty()) parameters["labels"] = options.labels;
  if (!options.region.empty()) parameters["region"] = options.region;
  if (options.hasVelocity()) {
    std::vector<std::string> names;
    for (const std::string& file : options.velocityFiles) {
      names.push_back(verbs::nameIn(formats::shownName(file)).string());
    }
    parameters["velocity"] =
        names.empty() ? options.velocity : fmt::format("{}", fmt::join(names, ", "));
    parameters["substeps"] = options.steps();
  }
  parameters["caps"] = options.caps;
  parameters["between"] = options.between.value_or("distance");
  parameters["precision"] = options.output.coding.precision;
  if (options.output.coding.grid) parameters["grid"] = *options.output.coding.grid;
  ordered_json source{
      {"frames", verbs::nameIn(formats::shownName(options.frames.front())).string()}};
  if (options.voxelSize && options.frames.size() > 1) source["meshes"] = options.frames.size();
  return ordered_json{{"source", source}, {"parameters", parameters}}.dump(
      -1, ' ', false, ordered_json::error_handler_t::replace);
}

/// Frames of velocities in between, of those that a part counts.
std::uint64_t framesInBetween(const model::Part& part, std::uint64_t frames, std::uint64_t steps) {
  const model::PartRange own = part.of(frames - 1);
  const auto ofFiles = [&](std::uint64_t end) { return end / steps + 1; };  // among 0 .. end
  const std::uint64_t before = part.isFirst() ? 0 : ofFiles(own.begin);
  const std::uint64_t counted = own.size() + (part.isFirst() ? 1 : 0);
  return counted - (ofFiles(own.end) - before);
}

/// Fails if a folder holds volumes, but no .vdb files: only the latter are taken by the folder.
Result<void> checkFolder(const std::string& folder) {
  if (voxel4d::isVolumeFile(folder)) return {};
  std::error_code ignored;
  std::set<std::string> volumes;
  for (const auto& entry : std::filesystem::directory_iterator(folder, ignored)) {
    if (entry.path().extension() == ".vdb") return {};
    if (voxel4d::isVolumeFile(entry.path())) volumes.insert(entry.path().filename().string());
  }
  if (volumes.empty()) return {};
  return invalid(fmt::format("is a folder of {}, and none is a .vdb file; name the volumes, as {}",
                             counted(volumes.size(), "volume"),
                             (std::filesystem::path(folder) /
                              ("*" + std::filesystem::path(*volumes.begin()).extension().string()))
                                 .string()),
                 folder);
}

/// Of a file that is neither a volume by its extension nor a VDB file, both are said.
Error unreadable(Error error) {
  const std::string extension = formats::lowerCaseExtension(error.where);
  if (error.message == "is not a VDB file" && extension != ".vdb") {
    error.message +=
        fmt::format(", and not a volume by its extension; expected .vdb, {}, or triangle meshes",
                    volumeExtensions());
  }
  return error;
}

/// Adds frames that velocities carry to volumes.
Result<void> addFramesInBetween(const WeaveArguments& options, const voxel4d::VolumeOptions& input,
                                voxel4d::VolumeFrames& opened) {
  if (opened.frames->isOneApart()) {
    return invalid("velocities need the time from frame to frame, which the file does not say",
                   options.frames.front(), Remedy::FrameTime);
  }
  const std::vector<std::filesystem::path> files(options.velocityFiles.begin(),
                                                 options.velocityFiles.end());
  auto velocities = voxel4d::openVolumeVelocity(files, input, opened);
  if (!velocities) return velocities.error();
  opened.frames =
      voxel4d::advectedFrames(std::move(opened.frames), std::move(*velocities), options.steps());
  return {};
}

/// Frames of triangle meshes, of OpenVDB, or of volumes: what has the label, or is inside without
/// one. `meshes` becomes what is found in meshes.
Result<voxel4d::VolumeFrames> openFrames(const WeaveArguments& options,
                                         const std::optional<std::int64_t>& label,
                                         std::shared_ptr<MeshFramesLog>& meshes) {
  if (options.voxelSize) {
    auto opened = openMeshFrames(options.frames, {*options.voxelSize, options.input.frameTime,
                                                  options.input.startTime.value_or(0)});
    if (!opened) return opened.error();
    meshes = std::move(opened->log);
    voxel4d::VolumeFrames frames;
    frames.frames = std::move(opened->frames);
    return frames;
  }
  const std::vector<std::filesystem::path> inputs(options.frames.begin(), options.frames.end());
  if (voxel4d::isVolumeFile(inputs.front())) {
    voxel4d::VolumeOptions input = options.input;
    input.label = label;
    const auto isUrl = [](const std::string& name) { return !formats::schemeOf(name).empty(); };
    if (std::ranges::any_of(options.frames, isUrl) ||
        std::ranges::any_of(options.velocityFiles, isUrl)) {
      input.web = formats::httpFiles();
    }
    auto opened = voxel4d::openVolumeFrames(inputs, input);
    if (opened && !options.velocityFiles.empty()) {
      if (auto done = addFramesInBetween(options, input, *opened); !done) return done.error();
    }
    return opened;
  }
  voxel4d::VdbFramesOptions input{options.input.iso,
                                  options.input.frameTime,
                                  options.input.startTime.value_or(0),
                                  options.input.region,
                                  options.grid,
                                  options.velocity,
                                  options.steps()};
  auto frames = voxel4d::openVdbFrames(inputs, input);
  if (!frames) return unreadable(frames.error());
  voxel4d::VolumeFrames opened;
  opened.frames = std::move(*frames);
  return opened;
}

/// What is wrong with the choice of options for meshes.
std::optional<std::string> misuseOfMeshes(const WeaveArguments& options) {
  const bool collected = std::ranges::any_of(
      options.frames, [](const std::string& file) { return formats::isCollection(file); });
  if (collected && options.frames.size() > 1) {
    return "a collection (.pvd) is given alone: it lists the meshes";
  }
  if (!options.voxelSize) {
    return "triangle meshes need --voxel-size, the edge length of a voxel; meshes that all have "
           "the same triangles can be swept as they are: t4d sweep";
  }
  const voxel4d::VolumeOptions& input = options.input;
  if (input.iso || !options.labels.empty() || !input.raw.empty() || !input.axes.empty() ||
      input.channel || input.level > 0 || !options.spacing.empty() || !options.origin.empty() ||
      !options.grid.empty() || input.region) {
    return "--iso, --label, --spacing, --origin, --axes, --channel, --level, --raw, --region and "
           "--grid are not for triangle meshes";
  }
  if (collected && input.startTime && !input.frameTime) {
    return "--start-time requires --frame-time";
  }
  return std::nullopt;
}

/// What is wrong with the options of frames in between.
std::optional<std::string> misuseOfVelocity(const WeaveArguments& options, bool vdb, bool volumes) {
  if (!options.hasVelocity()) {
    if (options.substeps) return "--substeps requires --velocity or --velocity-file";
    return std::nullopt;
  }
  if (options.velocity == "estimate") {
    return "velocities cannot be estimated from the frames; --velocity names a grid that holds "
           "them";
  }
  if (!options.region.empty()) {
    return "--region and velocities exclude each other: where a solid is cut off it does not move";
  }
  if (!options.velocity.empty() && !vdb) {
    return "--velocity is for .vdb files, which hold the velocity as a grid; that of a volume is "
           "in files of its own: --velocity-file VX VY VZ";
  }
  if (!options.velocityFiles.empty() && !volumes) {
    return "--velocity-file is for volumes; the velocity of .vdb files is a grid: --velocity GRID";
  }
  if (options.velocityFiles.size() == 2) {
    return "--velocity-file takes three files, or one with three channels";
  }
  if (options.between) {
    return "--between is for masks and labels; velocities carry level sets and densities";
  }
  if (!options.labels.empty()) {
    return "--label makes masks; velocities carry level sets and densities";
  }
  return std::nullopt;
}

/// What is wrong with the choice of options; nothing if it fits the files.
std::optional<std::string> misuseOfInput(const WeaveArguments& options) {
  const bool volumes = voxel4d::isVolumeFile(options.frames.front());
  const bool meshes = isMeshFrame(options.frames.front());
  for (const std::string& file : options.frames) {
    if (voxel4d::isVolumeFile(file) != volumes || isMeshFrame(file) != meshes) {
      return fmt::format(
          "{} and {} are not of one kind; give .vdb files, volumes, or triangle meshes",
          options.frames.front(), file);
    }
  }
  if (auto misuse = misuseOfVelocity(options, !volumes && !meshes, volumes)) return misuse;
  if (meshes) return misuseOfMeshes(options);
  if (options.voxelSize) return "--voxel-size is for triangle meshes; grids have voxels already";
  if (volumes && !options.grid.empty()) return "--grid is for .vdb files";
  const auto isOf = [&](std::initializer_list<std::string_view> extensions, bool orZarr = false) {
    return std::ranges::all_of(options.frames, [&](const std::string& file) {
      if (orZarr && voxel4d::isZarrInput(file)) return true;
      return std::ranges::find(extensions, formats::lowerCaseExtension(file)) != extensions.end();
    });
  };
  if (volumes && !options.input.raw.empty() && !isOf({".raw"})) return "--raw is for .raw files";
  if (volumes && !options.input.axes.empty() && !isOf({".npy", ".tif", ".tiff"}, true)) {
    return "--axes is for .npy and .tif files, and for Zarr";
  }
  if (!options.input.series.empty() &&
      !std::ranges::all_of(options.frames,
                           [](const std::string& file) { return voxel4d::isDicomInput(file); })) {
    return "--series is for DICOM files";
  }
  if (volumes && options.input.channel &&
      !std::ranges::all_of(
          options.frames, [](const std::string& file) { return voxel4d::mayHaveChannels(file); })) {
    return "--channel is for .tif files, and for Zarr";
  }
  if (options.input.level > 0 && !isOf({}, true)) return "--level is for Zarr";
  if (!options.labels.empty() && options.input.iso) return "--label and --iso exclude each other";
  if (std::set(options.labels.begin(), options.labels.end()).size() < options.labels.size()) {
    return "--label: a label is given twice";
  }
  if (volumes) return std::nullopt;
  const voxel4d::VolumeOptions& input = options.input;
  if (!options.labels.empty() || !input.raw.empty() || !input.axes.empty() || input.channel ||
      !options.spacing.empty() || !options.origin.empty()) {
    return "--label, --spacing, --origin, --axes, --channel and --raw are for volumes; .vdb files "
           "say what they hold";
  }
  if (input.startTime && !input.frameTime) return "--start-time requires --frame-time";
  return std::nullopt;
}

int run(const WeaveArguments& options) {
  for (const auto& inputs : {options.frames, options.velocityFiles}) {
    if (const auto misuse = misuseOfOutput(options.output.path, inputs)) return wrongUsage(*misuse);
  }
  for (const std::string& input : options.frames) {
    if (auto good = checkFolder(input); !good) return report(good.error());
    // A mesh of a format that is only written is none of what can be woven.
    if (formats::triangleMeshFormat(input) == nullptr) continue;
    if (auto good = formats::checkMeshExtension(input); !good) return report(good.error());
  }
  if (const auto misuse = misuseOfInput(options)) return wrongUsage(*misuse);
  if (options.part.isGiven() && options.output.center) {
    return wrongUsage("--part and --center exclude each other: the parts would not meet");
  }
  const auto begin = std::chrono::steady_clock::now();
  // Each label is a body.
  std::vector<std::optional<std::int64_t>> labels(options.labels.begin(), options.labels.end());
  if (labels.empty()) labels.emplace_back();
  std::shared_ptr<MeshFramesLog> meshes;
  auto input = openFrames(options, labels.front(), meshes);
  if (!input) return report(input.error());
  const model::Part part = options.part.chosen();
  const std::uint64_t allFrames = input->frames->frameCount();
  if (const auto done = options.part.settle(std::max<std::uint64_t>(allFrames, 1) - 1,
                                            "steps from frame to frame")) {
    return *done;
  }
  const auto unit = [](const std::string& given, const std::string& ofFile) {
    return given.empty() ? ofFile : given;
  };
  verbs::T4dFile::About about = {"voxel4d", formats::shownName(options.frames.front()),
                                 unit(options.lengthUnit, input->lengthUnit),
                                 unit(options.timeUnit, input->timeUnit), detailsOf(options)};
  about.space = input->space;
  if (labels.size() > 1) {
    const std::string& name = options.output.body;
    for (const auto& label : labels) {
      about.bodies.push_back({fmt::format("{} {}", name.empty() ? "label" : name, *label)});
    }
  }
  auto file = verbs::T4dFile::create(options.output.fileOptions(), about);
  if (!file) return report(file.error());
  const voxel4d::CapStyle caps = voxelCapStyle(options.caps);
  voxel4d::WeaveReport woven;
  std::vector<std::string> notices;
  for (std::size_t i = 0; i < labels.size(); ++i) {
    if (i > 0) {
      input = openFrames(options, labels[i], meshes);
      if (!input) return report(input.error());
    }
    ProgressBar bar("weaving", input->frames->frameCount(), "frames");
    file->setBody(i);
    const auto body = voxel4d::weave(*input->frames,
                                     {.caps = caps,
                                      .between = betweenOf(options.between),
                                      .toSpace = input->toSpace,
                                      .part = part},
                                     *file, bar.callback());
    if (!body) {
      Error error = body.error();
      if (meshes) {
        printNotices(meshes->notices);
        if (error.where.empty()) error.where = options.frames.front();
      }
      return report(error);
    }
    woven.vertices += body->vertices;
    woven.tetrahedra += body->tetrahedra;
    // The first frame of a part is counted by the part before.
    woven.frames = body->frames - (part.isFirst() ? 0 : 1);
    woven.masks += body->masks;
    for (int end = 0; end < 2; ++end) woven.capTetrahedra[end] += body->capTetrahedra[end];
    woven.partsLost.add(body->partsLost);
    if (const std::string notice = input->frames->notice(); !notice.empty()) {
      notices.push_back(labels.size() > 1 ? fmt::format("label {}: {}", *labels[i], notice)
                                          : notice);
    }
  }
  std::vector<std::string> losses;
  if (meshes) {
    if (const auto misuse = misuseOfOutput(options.output.path, meshes->files)) {
      return wrongUsage(*misuse);
    }
    notices.insert(notices.end(), meshes->notices.begin(), meshes->notices.end());
    losses = meshes->losses;
  }
  auto bytes = file->finish();
  if (!bytes) return report(bytes.error());
  if (!options.part.isGiven()) noticeCaps(caps, woven, notices);
  verbs::noticeLostParts(woven.partsLost, notices);
  if (options.between && woven.masks == 0) {
    notices.push_back("--between " + *options.between +
                      " has no effect: no frame is a mask or has labels, and the values of level "
                      "sets and densities say when points change sides");
  }
  if (!input->notice.empty()) {
    notices.push_back(formats::shownName(options.frames.front()) + ": " + input->notice);
  }
  if (input->frames->isOneApart()) {
    notices.emplace_back(
        "the input has no times: frames are taken to be 1 apart; --frame-time changes that");
  }
  if (input->takenAsDistances) {
    notices.push_back(
        "the samples are taken as distances: inside is where they are below 0; --iso VALUE takes "
        "them as densities, inside above VALUE");
  }
  printNotices(notices);
  const std::uint64_t inBetween = framesInBetween(part, allFrames, options.steps());

  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  if (options.json) {
    ordered_json result = {
        {"vertices", woven.vertices},
        {"tetrahedra", woven.tetrahedra},
        {"frames", woven.frames},
        {"frames_in_between", inBetween},
        {"seconds", seconds},
        {"peak_bytes", peakBytes()},
        {"cap_tetrahedra", woven.capTetrahedra},
        {"space", input->space.empty() ? ordered_json() : ordered_json(input->space)},
        {"bytes", *bytes},
        {"parts_lost", verbs::jsonOf(woven.partsLost)}};
    if (options.part.isGiven()) result["part"] = options.part.json({{"frames", allFrames}});
    printJson(result);
  } else {
    print("{}: {} vertices, {} tetrahedra from {}\n", options.output.path, grouped(woven.vertices),
          grouped(woven.tetrahedra), counted(woven.frames, "frame"));
    if (inBetween > 0) {
      print("  {} of them in between, by velocities\n", grouped(inBetween));
    }
    print("  caps of {} and {} tetrahedra\n", grouped(woven.capTetrahedra[0]),
          grouped(woven.capTetrahedra[1]));
    print("  {}, {:.2f} s, peak memory {}\n", sizeText(*bytes), seconds, sizeText(peakBytes()));
    if (!input->space.empty()) {
      print("  positions are {}: {}\n", input->space,
            input->space == "RAS" ? "x to the right, y anterior, z superior"
                                  : "x to the left, y posterior, z superior");
    }
    if (const auto rounding = options.output.coding.rounding()) print("  {}\n", *rounding);
  }
  for (std::string& loss : file->losses()) losses.push_back(std::move(loss));
  return options.lostParts.exitCode(woven.partsLost, reportLosses(losses));
}

}  // namespace

void addWeave(CLI::App& app, int& exitCode) {
  auto* command = app.add_subcommand(
      "weave", "Weave a time series of voxel grids or triangle meshes into a 4D mesh");
  auto options = std::make_shared<WeaveArguments>();
  command
      ->add_option("FRAMES", options->frames,
                   "Frames: .vdb files or their folder; volumes: " + volumeExtensions() +
                       "; or, with --voxel-size, triangle meshes: " +
                       formats::readableTriangleMeshExtensions() + ", or a .pvd that lists them")
      ->required();
  command
      ->add_option("--voxel-size", options->voxelSize,
                   "Triangle meshes: voxel edge length, in length units")
      ->check(numberAboveZero());
  command
      ->add_option("--iso", options->input.iso,
                   "Densities: inside is above this value (default: distances, inside below 0)")
      ->check(finiteNumber());
  command
      ->add_option("--label", options->labels,
                   "Volumes: integer label of the inside; several labels make several bodies")
      ->check(wholeNumberOf64Bits());
  command
      ->add_option("--frame-time", options->input.frameTime,
                   "Time between frames (default: from the files, else 1)")
      ->check(numberAboveZero());
  command
      ->add_option("--start-time", options->input.startTime,
                   "Time of the first frame (default: from the file, else 0)")
      ->check(finiteNumber());
  command->add_option("--grid", options->grid, "Use only grids with this name (default: all)");
  command
      ->add_option("--velocity", options->velocity,
                   "Velocity grid of .vdb files: makes frames in between (docs/weave.md)")
      ->check(someName());
  command
      ->add_option("--velocity-file", options->velocityFiles,
                   "Velocities of volumes: makes frames in between (docs/weave.md)")
      ->type_name("VX VY VZ")
      ->expected(1, 3)
      ->delimiter(',')
      ->check(someName());
  command
      ->add_option(
          "--substeps", options->substeps,
          fmt::format("Steps from frame to frame with velocities (default: {})", kDefaultSubsteps))
      ->check(wholeNumber(1, kMostSubsteps));
  addNumbers(*command, "--spacing", options->spacing,
             "Volumes: voxel edge lengths (default: from the file, else 1)", 1, 3, "DX [DY DZ]")
      ->check(numberAboveZero());
  addNumbers(*command, "--origin", options->origin,
             "Volumes: position of the first sample (default: from the file, else 0 0 0)", 3, 3,
             "X Y Z");
  command
      ->add_option("--axes", options->input.axes,
                   "Axis order of .npy and Zarr arrays (default: txyz, or xyz for several files), "
                   "or of the pages of .tif files")
      ->check(axesOfArray());
  command
      ->add_option("--channel", options->input.channel,
                   ".tif files and Zarr with several channels: which, counted from 0")
      ->check(wholeNumber(0, 1U << 30U));
  command
      ->add_option("--level", options->input.level,
                   "OME-Zarr: level of the image (default: 0, the finest)")
      ->check(wholeNumber(0, 1U << 30U));
  command
      ->add_option("--region", options->region,
                   "Samples and frames to use, counted from 0 (default: all)")
      ->check(regionOfFrames());
  command->add_option("--series", options->input.series,
                      "DICOM files of several series: which, by its number or UID");
  command->add_option("--raw", options->input.raw,
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
  command->add_flag("--json", options->json, "Print the result as JSON");
  command->footer(
      "Examples:\n  t4d weave frames/*.vdb -o moving.t4d\n"
      "  t4d weave heart.nrrd --label 2 -o heart.t4d\n"
      "  t4d weave embryo.tif --iso 900 --region 100:400,80:300,:,0:50 -o part.t4d\n"
      "  t4d weave dicom_folder --iso 300 -o scan.t4d\n"
      "  t4d weave https://host/embryo.zarr --level 2 --iso 900 -o embryo.t4d\n"
      "  t4d weave scan_*.nii.gz --iso 300 --frame-time 0.04 -o scan.t4d\n"
      "  t4d weave frames/water_*.obj --voxel-size 0.01 --frame-time 0.04 -o water.t4d");
  command->callback([=, &exitCode] {
    const auto& spacing = options->spacing;
    if (spacing.size() == 2) {
      exitCode = wrongUsage("--spacing is one length, or three");
      return;
    }
    if (!spacing.empty()) {
      options->input.spacing = {spacing.front(), spacing[spacing.size() / 2], spacing.back()};
    }
    if (!options->region.empty()) options->input.region = *voxel4d::parseRegion(options->region);
    if (const auto& origin = options->origin; !origin.empty()) {
      options->input.origin = {origin[0], origin[1], origin[2]};
    }
    exitCode = run(*options);
  });
}

}  // namespace t4d::tools
