#include <array>
#include <chrono>
#include <filesystem>
#include <optional>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "t4d/edit/surface_crossings.h"
#include "t4d/formats/cutter_location_reader.h"
#include "t4d/formats/gcode_reader.h"
#include "t4d/formats/motion_reader.h"
#include "t4d/formats/output_file.h"
#include "t4d/formats/t4d/names.h"
#include "t4d/formats/triangle_mesh_formats.h"
#include "t4d/mill/mill.h"
#include "t4d/mill/tool_shape.h"
#include "t4d/slice/slice_at_times.h"
#include "tools/program/commands.h"
#include "tools/program/console.h"
#include "tools/program/frame_options.h"
#include "tools/program/input_options.h"
#include "tools/program/mending.h"
#include "tools/program/mill_page.h"
#include "tools/program/option_checks.h"
#include "tools/program/solid_input.h"
#include "tools/program/t4d_output.h"
#include "tools/program/voxel_series.h"

namespace t4d::tools {
namespace {

using nlohmann::ordered_json;

struct MillArguments {
  std::string stock;
  bool mend = false;
  MendingOptions mending;
  std::string tool;
  std::string motion;
  std::string gcode;
  std::string locations;
  std::string shank;
  std::string holder;
  double voxelSize = 0;
  std::optional<double> tolerance;
  std::optional<double> travel;
  double rapidFeed = formats::ToolPathOptions{}.rapidFeed;
  double memory = 4;  // GB
  voxel4d::FrameTimes times;
  std::string caps = "graded";
  std::string html;
  T4dOutput output;
  bool json = false;

  double toleranceOr() const { return tolerance.value_or(voxelSize / 100); }
  const std::string& path() const {
    return !gcode.empty() ? gcode : !locations.empty() ? locations : motion;
  }
};

/// Whether sizes are given and not a file.
bool isToolShape(const std::string& text) {
  for (const char* kind : {"ball:", "flat:", "bull:"}) {
    if (text.starts_with(kind)) return true;
  }
  const auto colon = text.find(':');
  std::error_code ignored;
  return colon != text.npos && text.find('=', colon) != text.npos &&
         !std::filesystem::exists(text, ignored);
}

bool isCylinder(const std::string& text) {
  std::error_code ignored;
  return text.find('=') != text.npos && !std::filesystem::exists(text, ignored);
}

/// A tool with its height, where shank and holder begin.
struct Tool {
  model::TriangleMesh mesh;
  double top = 0;
};

Result<model::TriangleMesh> readMesh(const std::string& path, std::vector<std::string>& losses) {
  auto loaded = SolidInput{path}.read();
  if (!loaded) return pass(loaded.error());
  losses.insert(losses.end(), loaded->losses.begin(), loaded->losses.end());
  return std::move(loaded->bodies.front().mesh);
}

Result<Tool> readTool(const MillArguments& options, std::vector<std::string>& losses) {
  Tool tool;
  if (isToolShape(options.tool)) {
    const auto shape = mill::parseTool(options.tool);
    if (!shape) return invalid(shape.error().message, "--tool");
    tool.mesh = mill::toolMesh(*shape, options.toleranceOr());
  } else {
    auto mesh = readMesh(options.tool, losses);
    if (!mesh) return pass(mesh.error());
    tool.mesh = std::move(*mesh);
  }
  tool.top = model::boundsOf(tool.mesh).max.z();
  return tool;
}

/// Shank and holder, one above the other.
Result<std::vector<mill::Guard>> readGuards(const MillArguments& options, double top,
                                            std::vector<std::string>& losses) {
  std::vector<mill::Guard> guards;
  for (const auto& [name, text] :
       {std::pair{"shank", &options.shank}, std::pair{"holder", &options.holder}}) {
    if (text->empty()) continue;
    if (!isCylinder(*text)) {
      auto mesh = readMesh(*text, losses);
      if (!mesh) return pass(mesh.error());
      guards.push_back({name, std::move(*mesh)});
    } else {
      const auto cylinder = mill::parseCylinder(*text);
      if (!cylinder) return invalid(cylinder.error().message, std::string("--") + name);
      guards.push_back({name, mill::cylinderMesh(*cylinder, top, options.toleranceOr())});
    }
    top = std::max(top, model::boundsOf(guards.back().mesh).max.z());
  }
  return guards;
}

Result<formats::ToolPath> readPath(const MillArguments& options) {
  const formats::ToolPathOptions how{options.toleranceOr(), options.rapidFeed};
  if (!options.gcode.empty()) return formats::readGcode(options.gcode, how);
  if (!options.locations.empty()) return formats::readCutterLocations(options.locations, how);
  formats::ToolPath path;
  std::string form;
  auto motion = formats::readMotion(options.motion, &form);
  if (!motion) return pass(motion.error());
  if (!form.empty()) path.notices.push_back(options.motion + ": " + form);
  if (const std::string notice = model::noticeOfHalfTurns(motion->halfTurns); !notice.empty()) {
    path.notices.push_back(options.motion + ": " + notice);
  }
  path.motion = std::move(*motion);
  return path;
}

std::string detailsOf(const MillArguments& options, std::size_t frames) {
  const auto nameOf = [](const std::string& path) {
    return std::filesystem::path(path).filename().string();
  };
  ordered_json source{{"mesh", nameOf(options.stock)}};
  source["tool"] = isToolShape(options.tool) ? options.tool : nameOf(options.tool);
  source[options.gcode.empty() && options.locations.empty() ? "motion" : "path"] =
      nameOf(options.path());
  return ordered_json{{"source", source},
                      {"parameters",
                       {{"voxel_size", options.voxelSize},
                        {"frames", frames},
                        {"tolerance", options.toleranceOr()},
                        {"caps", options.caps},
                        {"precision", options.output.coding.precision}}}}
      .dump(-1, ' ', false, ordered_json::error_handler_t::replace);
}

ordered_json jsonOf(const mill::MillReport& report) {
  ordered_json value{
      {"stock_volume", report.stockVolume},         {"removed_volume", report.removedVolume},
      {"remaining_volume", report.remainingVolume}, {"components", report.components},
      {"frames", report.progress.size()},           {"progress", ordered_json::array()},
      {"separations", ordered_json::array()},       {"collisions", ordered_json::array()}};
  for (const mill::MillProgress& at : report.progress) {
    value["progress"].push_back(
        {{"time", at.time}, {"removed_volume", at.removedVolume}, {"components", at.components}});
  }
  for (const mill::Separation& one : report.separations) {
    value["separations"].push_back(
        {{"begin", one.time.begin}, {"end", one.time.end}, {"components", one.components}});
  }
  for (const mill::Collision& one : report.collisions) {
    value["collisions"].push_back({{"part", one.part},
                                   {"begin", one.time.begin},
                                   {"end", one.time.end},
                                   {"point", {one.point.x(), one.point.y(), one.point.z()}}});
  }
  value["returned_volume"] = report.returnedVolume;
  value["steps"] = report.steps;
  value["vertices"] = report.woven.vertices;
  value["tetrahedra"] = report.woven.tetrahedra;
  return value;
}

void printText(const MillArguments& options, const mill::MillReport& report,
               const model::Motion& motion) {
  const auto cubic = [&](double volume) {
    return motion.lengthUnit.empty() ? fmt::format("{:.7g}", volume)
                                     : fmt::format("{:.7g} {}^3", volume, motion.lengthUnit);
  };
  const auto at = [&](double time) {
    return motion.timeUnit.empty() ? fmt::format("{:.6g}", time)
                                   : fmt::format("{:.6g} {}", time, motion.timeUnit);
  };
  print("{}: {} vertices, {} tetrahedra from {}\n", options.output.path,
        grouped(report.woven.vertices), grouped(report.woven.tetrahedra),
        counted(report.progress.size(), "frame"));
  print("  stock {}, removed {}, remaining {} in {}\n", cubic(report.stockVolume),
        cubic(report.removedVolume), cubic(report.remainingVolume),
        counted(report.components, "component"));
  for (const mill::Separation& one : report.separations) {
    print("  falls apart into {} between {} and {}\n", one.components, at(one.time.begin),
          at(one.time.end));
  }
  for (const mill::Collision& one : report.collisions) {
    print("  collision of the {} from {} to {}, at ({:.4g}, {:.4g}, {:.4g}){}\n", one.part,
          at(one.time.begin), at(one.time.end), one.point.x(), one.point.y(), one.point.z(),
          one.part == "tool" ? ": a rapid move cuts" : "");
  }
}

/// Slices of the file for the page.
Result<std::vector<std::pair<double, model::TriangleMesh>>> workpieces(
    const std::string& path, const model::TimeSpan& span) {
  const auto input = verbs::openInput(path, InputOptions{});
  if (!input) return pass(input.error());
  const std::vector<double> times = model::evenTimes(span, 6);
  auto slices = slice::sliceAtTimes(*input->bodies.front().source, times);
  std::vector<std::pair<double, model::TriangleMesh>> found;
  for (std::size_t i = 0; i < times.size(); ++i) {
    if (!slices[i]) return pass(slices[i].error());
    found.emplace_back(times[i], std::move(slices[i]->mesh));
  }
  return found;
}

Result<void> writePage(const MillArguments& options, const mill::MillReport& report,
                       const model::Motion& motion) {
  MillPage page{"Milling of " + std::filesystem::path(options.stock).filename().string(),
                motion.lengthUnit,
                motion.timeUnit,
                report,
                {},
                options.output.up == "z"};
  const ProgressBar bar("drawing");
  auto meshes = workpieces(options.output.path, {motion.timeBegin(), motion.timeEnd()});
  if (!meshes) return pass(meshes.error());
  page.workpieces = std::move(*meshes);
  auto file = formats::OutputFile::create(options.html);
  if (!file) return pass(file.error());
  const std::string html = millPage(page);
  if (auto written = file->write(html.data(), html.size()); !written) return written;
  return file->commit();
}

/// A notice if the surface crosses itself; nothing if it does not, or where nobody can tell.
std::string noticeOfCrossings(const std::string& path, const model::TriangleMesh& mesh) {
  constexpr std::size_t kMost = 1000;
  const ProgressBar bar("checking " + path);
  const auto found = edit::findCrossings(mesh, kMost);
  if (!found || found->pairs.empty()) return {};
  return fmt::format(
      "{} crosses itself, in {}{}; where it overlaps itself it counts once, and where it is inside "
      "out it is empty",
      path, found->complete ? "" : "more than ",
      counted(found->pairs.size(), "pair of triangles", "pairs of triangles"));
}

std::optional<std::string> misuseOf(const MillArguments& options) {
  const int paths = static_cast<int>(!options.motion.empty()) +
                    static_cast<int>(!options.gcode.empty()) +
                    static_cast<int>(!options.locations.empty());
  if (paths != 1) {
    return "how the tool moves is said by one of --motion, --gcode and --locations";
  }
  if (isToolShape(options.tool)) {
    const auto shape = mill::parseTool(options.tool);
    if (!shape) return "--tool: " + shape.error().message;
  }
  for (const auto& [name, text] :
       {std::pair{"shank", &options.shank}, std::pair{"holder", &options.holder}}) {
    if (text->empty() || !isCylinder(*text)) continue;
    const auto cylinder = mill::parseCylinder(*text);
    if (!cylinder) return fmt::format("--{}: {}", name, cylinder.error().message);
  }
  if (!options.html.empty() && options.output.path == "-") {
    return "--html needs the .t4d in a file";
  }
  return std::nullopt;
}

int run(const MillArguments& options) {
  if (const auto misuse = misuseOf(options)) return wrongUsage(*misuse);
  std::vector<std::string> inputs = {options.stock, options.path()};
  if (!isToolShape(options.tool)) inputs.push_back(options.tool);
  for (const std::string* guard : {&options.shank, &options.holder}) {
    if (!guard->empty() && !isCylinder(*guard)) inputs.push_back(*guard);
  }
  for (const std::string* output : {&options.output.path, &options.html}) {
    if (output->empty()) continue;
    if (const auto misuse = misuseOfOutput(*output, inputs)) return wrongUsage(*misuse);
  }
  if (const auto misuse = misuseOfOutputs(std::array{options.output.path, options.html})) {
    return wrongUsage(*misuse);
  }
  if (auto writable = checkWritable({{options.html}}); !writable) return report(writable.error());
  const auto begin = std::chrono::steady_clock::now();
  std::vector<std::string> losses;
  auto stock = SolidInput{options.stock, "", options.mend ? &options.mending : nullptr}.read();
  if (!stock) return report(stock.error());
  if (stock->mended) printNotices(noticesOf(*stock->mended));
  losses = stock->losses;
  const std::string crossings = noticeOfCrossings(options.stock, stock->bodies.front().mesh);
  if (!crossings.empty()) printNotices({crossings});
  const double memory = 1e9 * options.memory;
  auto sized = mill::checkVoxelSize(stock->bodies.front().mesh, options.voxelSize, memory);
  if (!sized) {
    if (sized.error().where.empty()) sized.error().where = options.stock;
    return report(sized.error());
  }
  const auto tool = readTool(options, losses);
  if (!tool) return report(tool.error());
  auto guards = readGuards(options, tool->top, losses);
  if (!guards) return report(guards.error());
  const auto path = readPath(options);
  if (!path) return report(path.error());
  printNotices(path->notices);
  const model::Motion& motion = path->motion;

  voxel4d::FrameTimes when = options.times;
  if (!when.count && !when.step) {
    when.count = kDefaultFrames;
    noticeDefaultFrames();
  }
  const auto times = voxel4d::frameTimes({motion.timeBegin(), motion.timeEnd()}, when);
  if (!times) {
    Error error = times.error();
    error.where = options.path();
    return report(error);
  }
  auto file = T4dFile::create(options.output, {"voxel4d", options.stock, motion.lengthUnit,
                                               motion.timeUnit, detailsOf(options, times->size())});
  if (!file) return report(file.error());
  mill::MillOptions how;
  how.voxelSize = options.voxelSize;
  how.times = *times;
  how.tolerance = options.toleranceOr();
  how.travel = options.travel.value_or(0);
  how.memory = memory;
  how.guards = std::move(*guards);
  how.rapids = path->rapids;
  how.caps = voxelCapStyle(options.caps);
  const auto milled = [&] {
    ProgressBar bar("milling", times->size(), "frames");
    return mill::mill(stock->bodies.front().mesh, tool->mesh, motion, how, *file, bar.callback());
  }();
  if (!milled) {
    Error error = milled.error();
    if (error.where.empty() && error.remedy == Remedy::Motion) error.where = options.path();
    if (error.where.empty() || error.where == "stock") error.where = options.stock;
    for (const auto& [name, given] :
         {std::pair{"tool", &options.tool}, std::pair{"shank", &options.shank},
          std::pair{"holder", &options.holder}}) {
      if (error.where == name) error.where = *given;
    }
    return report(error);
  }
  const auto bytes = file->finish();
  if (!bytes) return report(bytes.error());
  printNotices(milled->notices);
  if (!milled->firstCut) {
    printNotices(
        {options.path() +
         ": nothing is removed; the tool never meets the stock, or by less than the voxels show"});
  }
  if (!options.html.empty()) {
    if (auto written = writePage(options, *milled, motion); !written) {
      return report(written.error());
    }
  }
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  if (options.json) {
    ordered_json value = jsonOf(*milled);
    value["seconds"] = seconds;
    value["peak_bytes"] = peakBytes();
    value["bytes"] = *bytes;
    printJson(value);
  } else {
    printText(options, *milled, motion);
    print("  {}, {:.2f} s, peak memory {}\n", sizeText(*bytes), seconds, sizeText(peakBytes()));
    if (const auto rounding = options.output.coding.rounding()) print("  {}\n", *rounding);
  }
  for (std::string& loss : file->losses()) losses.push_back(std::move(loss));
  return reportLosses(losses);
}

}  // namespace

void addMill(CLI::App& app, int& exitCode) {
  auto* command = app.add_subcommand(
      "mill", "Mill a solid with a moving tool; write the workpiece as a 4D mesh");
  auto options = std::make_shared<MillArguments>();
  command
      ->add_option("STOCK", options->stock,
                   "Solid to mill: " + formats::readableTriangleMeshExtensions())
      ->required();
  command
      ->add_option("--tool", options->tool,
                   "Tool: ball:d=6,l=30, flat:d=6,l=30, bull:d=6,r=1,l=30 or a triangle mesh")
      ->required()
      ->check(someName());
  command
      ->add_option("-m,--motion", options->motion,
                   "Tool motion: .json, or poses as .csv, .tsv or .txt (docs/motion.md)")
      ->check(someName());
  command
      ->add_option("--gcode", options->gcode,
                   "Tool motion: three-axis G-code, in mm and s (docs/mill.md)")
      ->check(someName());
  command
      ->add_option("--locations", options->locations,
                   "Tool motion: five-axis cutter locations, in mm and s (docs/mill.md)")
      ->check(someName());
  command->add_option("--voxel-size", options->voxelSize, "Voxel edge length, in length units")
      ->required()
      ->check(numberAboveZero());
  addFrameTimes(*command, options->times, "", fmt::format(" (default: {})", kDefaultFrames));
  command
      ->add_option("--shank", options->shank,
                   "Shank above the tool: d=6,l=40 (a cylinder) or a triangle mesh")
      ->check(someName());
  command
      ->add_option("--holder", options->holder,
                   "Holder above the shank: d=40,l=50 (a cylinder) or a triangle mesh")
      ->check(someName());
  command
      ->add_option("--tolerance", options->tolerance,
                   "Maximum error of tool, arcs and turns, in length units (default: 0.01 voxels)")
      ->check(numberAboveZero());
  command
      ->add_option("--travel", options->travel,
                   "Maximum travel of the tip per step, in length units (default: 4 voxels)")
      ->check(numberAboveZero());
  command->add_option("--rapid", options->rapidFeed, "Feed rate of rapid moves, in mm/min")
      ->check(numberAboveZero())
      ->capture_default_str();
  command
      ->add_option("--max-memory", options->memory,
                   "Maximum memory for the voxels of the stock, in GB")
      ->check(numberAboveZero())
      ->capture_default_str();
  command->add_option("--caps", options->caps, "Caps at the ends (docs/weave.md)")
      ->check(CLI::IsMember({"graded", "flat", "half-step"}))
      ->capture_default_str();
  command
      ->add_option("--html", options->html,
                   "Write a page with the removed volume over time and pictures")
      ->check(someName());
  options->mending.addTo(*command, options->mend);
  options->output.addTo(*command);
  command->add_flag("--json", options->json, "Print the result as JSON");
  command->footer(
      "Examples:\n  t4d mill cube.obj --tool ball:d=6,l=30 --gcode pocket.nc --voxel-size 0.5 --up "
      "z "
      "-o process.t4d\n"
      "  t4d slice process.t4d --time 5 -o at-5.glb");
  command->callback([=, &exitCode] { exitCode = run(*options); });
}

}  // namespace t4d::tools
