#include <algorithm>
#include <array>
#include <chrono>
#include <filesystem>
#include <map>
#include <optional>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "t4d/edit/surface_crossings.h"
#include "t4d/formats/motion/motion_reader.h"
#include "t4d/formats/output_file.h"
#include "t4d/formats/t4d/names.h"
#include "t4d/formats/toolpath/cutter_location_reader.h"
#include "t4d/formats/toolpath/gcode_reader.h"
#include "t4d/formats/toolpath/tool_table.h"
#include "t4d/formats/triangle/triangle_mesh_formats.h"
#include "t4d/mill/mill.h"
#include "t4d/slice/slice_at_times.h"
#include "t4d/verbs/mending.h"
#include "t4d/verbs/solid_input.h"
#include "t4d/verbs/t4d_file.h"
#include "tools/program/commands.h"
#include "tools/program/console.h"
#include "tools/program/console_observer.h"
#include "tools/program/frame_options.h"
#include "tools/program/input_options.h"
#include "tools/program/mending.h"
#include "tools/program/mill_page.h"
#include "tools/program/mill_tools.h"
#include "tools/program/motion_options.h"
#include "tools/program/option_checks.h"
#include "tools/program/part_option.h"
#include "tools/program/t4d_output.h"
#include "tools/program/voxel_series.h"

namespace t4d::tools {
namespace {

using nlohmann::ordered_json;

struct MillArguments {
  std::string stock;
  bool mend = false;
  MendingOptions mending;
  MillToolOptions tools;
  std::string motion;
  MotionOptions table;
  std::string gcode;
  std::string locations;
  std::string toolTable;
  std::vector<std::string> offsets;
  std::vector<std::string> rotaries;
  bool tipControl = false;
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

/// What G-code and cutter locations are read with, but for tools.
Result<formats::ToolPathOptions> pathOptions(const MillArguments& options) {
  formats::ToolPathOptions how{options.toleranceOr(), options.rapidFeed};
  for (const std::string& offset : options.offsets) {
    auto parsed = formats::parseOffset(offset, how.offsets);
    if (!parsed) return invalid("--offset: " + parsed.error().message);
  }
  for (const std::string& text : options.rotaries) {
    const auto axis = formats::parseRotaryAxis(text);
    if (!axis) return invalid("--rotary: " + axis.error().message);
    if (std::ranges::find(how.rotaries, axis->axis, &formats::RotaryAxis::axis) !=
        how.rotaries.end()) {
      return invalid(fmt::format("--rotary: {} is given twice", text.substr(0, 1)));
    }
    how.rotaries.push_back(*axis);
  }
  how.tipControl = options.tipControl;
  return how;
}

/// Adds the tools, the lengths that the table has, and how far the longest one reaches.
void addTools(const std::vector<mill::Tool>& tools, const std::map<int, formats::TableTool>& table,
              formats::ToolPathOptions& how) {
  if (tools.front().number != 0) how.tools.emplace();
  how.reach = 0;
  const auto reach = [&](const model::TriangleMesh& mesh) {
    for (const auto& vertex : mesh.vertices) how.reach = std::max(how.reach, vertex.norm());
  };
  for (const mill::Tool& tool : tools) {
    if (how.tools) how.tools->push_back(tool.number);
    reach(tool.mesh);
    for (const mill::Guard& guard : tool.guards) reach(guard.mesh);
  }
  for (const auto& [number, tool] : table) how.lengths.emplace(number, tool.length);
}

Result<formats::ToolPath> readPath(const MillArguments& options,
                                   const formats::ToolPathOptions& how) {
  if (!options.gcode.empty()) return formats::readGcode(options.gcode, how);
  if (!options.locations.empty()) return formats::readCutterLocations(options.locations, how);
  formats::ToolPath path;
  std::string form;
  auto motion = formats::readMotion(options.motion, &form, options.table.table);
  if (!motion) return motion.error();
  if (!form.empty()) path.notices.push_back(options.motion + ": " + form);
  if (const std::string notice = model::noticeOfHalfTurns(motion->halfTurns); !notice.empty()) {
    path.notices.push_back(options.motion + ": " + notice);
  }
  path.motion = std::move(*motion);
  return path;
}

std::string detailsOf(const MillArguments& options, const MillToolSpecs& specs,
                      std::size_t frames) {
  const auto nameOf = [](const std::string& path) {
    return std::filesystem::path(path).filename().string();
  };
  ordered_json source{{"mesh", nameOf(options.stock)}};
  for (const auto& [number, spec] : specs) {
    const std::string tool = spec.files().empty() ? spec.tool : nameOf(spec.tool);
    if (number == 0) {
      source["tool"] = tool;
    } else {
      source["tools"][std::to_string(number)] = tool;
    }
  }
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

bool hasNumbers(const formats::ToolPath& path) {
  return std::ranges::any_of(path.mountings,
                             [](const auto& one) { return one.tool.value_or(0) > 0; });
}

ordered_json jsonOf(const mill::MillReport& report, const formats::ToolPath& path) {
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
                                   {"tool", one.tool},
                                   {"begin", one.time.begin},
                                   {"end", one.time.end},
                                   {"point", {one.point.x(), one.point.y(), one.point.z()}}});
  }
  value["mountings"] = ordered_json::array();
  if (hasNumbers(path)) {
    for (const formats::Mounting& one : path.mountings) {
      value["mountings"].push_back({{"time", one.time}, {"tool", one.tool.value_or(0)}});
    }
  }
  value["returned_volume"] = report.returnedVolume;
  value["steps"] = report.steps;
  value["vertices"] = report.woven.vertices;
  value["tetrahedra"] = report.woven.tetrahedra;
  return value;
}

void printText(const MillArguments& options, const mill::MillReport& report,
               const formats::ToolPath& path) {
  const model::Motion& motion = path.motion;
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
  constexpr double kWorthSaying = 0.001;
  if (report.returnedVolume > kWorthSaying * report.removedVolume) {
    print("  up to {} comes back between frames and goes again; --frames {} has less of it\n",
          cubic(report.returnedVolume), std::max<std::size_t>(2, report.progress.size() / 4));
  }
  int mounted = 0;
  for (const formats::Mounting& one : path.mountings) {
    const int tool = one.tool.value_or(mounted);
    if (tool != mounted) print("  T{} from {}\n", tool, at(one.time));
    mounted = tool;
  }
  for (const mill::Separation& one : report.separations) {
    print("  falls apart into {} between {} and {}\n", one.components, at(one.time.begin),
          at(one.time.end));
  }
  for (const mill::Collision& one : report.collisions) {
    print("  collision of the {} from {} to {}, at ({:.4g}, {:.4g}, {:.4g}){}\n",
          mill::partOfTool(one.part, one.tool), at(one.time.begin), at(one.time.end), one.point.x(),
          one.point.y(), one.point.z(), one.part == "tool" ? ": a rapid move cuts" : "");
  }
}

/// Slices of the file for the page.
Result<std::vector<std::pair<double, model::TriangleMesh>>> workpieces(
    const std::string& path, const model::TimeSpan& span) {
  const auto input = verbs::openInput(path, InputOptions{});
  if (!input) return input.error();
  const std::vector<double> times = model::evenTimes(span, 6);
  auto slices = slice::sliceAtTimes(*input->bodies.front().source, times);
  std::vector<std::pair<double, model::TriangleMesh>> found;
  for (std::size_t i = 0; i < times.size(); ++i) {
    if (!slices[i]) return slices[i].error();
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
  if (!meshes) return meshes.error();
  page.workpieces = std::move(*meshes);
  auto file = formats::OutputFile::create(options.html);
  if (!file) return file.error();
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
  if (!options.table.table.empty() && options.motion.empty()) {
    return "--angles, --quaternion, --length-unit and --time-unit are for --motion";
  }
  const bool saysMore = !options.toolTable.empty() || !options.offsets.empty() ||
                        !options.rotaries.empty() || options.tipControl;
  if (options.gcode.empty() && saysMore) {
    return "--tool-table, --offset, --rotary and --tcp are for --gcode";
  }
  if (!options.html.empty() && options.output.path == "-") {
    return "--html needs the .t4d in a file";
  }
  return std::nullopt;
}

/// Whether an output is an input or another output.
std::optional<std::string> misuseOfFiles(const MillArguments& options, const MillToolSpecs& specs) {
  std::vector<std::string> inputs = {options.stock, options.path()};
  if (!options.toolTable.empty()) inputs.push_back(options.toolTable);
  for (const auto& [number, spec] : specs) {
    for (std::string& file : spec.files()) inputs.push_back(std::move(file));
  }
  for (const std::string* output : {&options.output.path, &options.html}) {
    if (output->empty()) continue;
    if (auto misuse = misuseOfOutput(*output, inputs)) return misuse;
  }
  return misuseOfOutputs(std::array{options.output.path, options.html});
}

mill::MillOptions millOptions(const MillArguments& options, const std::vector<mill::Tool>& tools,
                              const formats::ToolPath& path) {
  mill::MillOptions how;
  how.voxelSize = options.voxelSize;
  how.tolerance = options.toleranceOr();
  how.travel = options.travel.value_or(0);
  how.memory = 1e9 * options.memory;
  for (const formats::Mounting& one : path.mountings) {
    how.mountings.push_back(mill::mountingOf(tools, one.time, one.tool));
  }
  how.rapids = path.rapids;
  how.caps = voxelCapStyle(options.caps);
  return how;
}

/// The error, at the file that it is about.
Error placed(Error error, const MillArguments& options, const MillToolSpecs& specs) {
  if (error.where.empty() && error.remedy == Remedy::Motion) error.where = options.path();
  if (error.where.empty() || error.where == "stock") error.where = options.stock;
  if (const auto given = givenAs(error.where, specs)) error.where = *given;
  return error;
}

using TableTools = std::map<int, formats::TableTool>;

Result<TableTools> readTable(const MillArguments& options) {
  if (options.toolTable.empty()) return TableTools();
  return formats::readToolTable(options.toolTable);
}

/// The stock, in which voxels of this size find room. Adds what is lost of it.
Result<model::TriangleMesh> readStock(const MillArguments& options,
                                      std::vector<std::string>& losses) {
  ConsoleObserver observer;
  auto stock =
      verbs::readSolidInput({options.stock, {}, options.mending.given(options.mend)}, observer);
  if (!stock) return stock.error();
  if (stock->mended) observer.noteEach(verbs::noticesOf(*stock->mended));
  losses.insert(losses.end(), stock->losses.begin(), stock->losses.end());
  model::TriangleMesh& mesh = stock->bodies.front().mesh;
  const std::string crossings = noticeOfCrossings(options.stock, mesh);
  if (!crossings.empty()) printNotices({crossings});
  if (auto sized = mill::checkVoxelSize(mesh, options.voxelSize, 1e9 * options.memory); !sized) {
    return sized.error();
  }
  return std::move(mesh);
}

Result<std::vector<double>> frameTimesOf(const MillArguments& options,
                                         const model::Motion& motion) {
  voxel4d::FrameTimes when = options.times;
  if (!when.count && !when.step) {
    when.count = kDefaultFrames;
    noticeDefaultFrames();
  }
  auto times = voxel4d::frameTimes({motion.timeBegin(), motion.timeEnd()}, when);
  if (times) return times;
  Error error = times.error();
  error.where = options.path();
  return error;
}

void printReport(const MillArguments& options, const mill::MillReport& report,
                 const formats::ToolPath& path, std::uint64_t bytes, double seconds) {
  if (options.json) {
    ordered_json value = jsonOf(report, path);
    value["seconds"] = seconds;
    value["peak_bytes"] = peakBytes();
    value["bytes"] = bytes;
    printJson(value);
    return;
  }
  printText(options, report, path);
  print("  {}, {:.2f} s, peak memory {}\n", sizeText(bytes), seconds, sizeText(peakBytes()));
  if (const auto rounding = options.output.coding.rounding()) print("  {}\n", *rounding);
}

/// Mills what the options name, which have been checked.
int millFiles(const MillArguments& options, const MillToolSpecs& specs, const TableTools& table,
              formats::ToolPathOptions pathHow) {
  const auto begin = std::chrono::steady_clock::now();
  std::vector<std::string> losses;
  const auto stock = readStock(options, losses);
  if (!stock) return report(placed(stock.error(), options, specs));
  const auto tools = readMillTools(specs, options.toleranceOr(), losses);
  if (!tools) return report(tools.error());
  addTools(*tools, table, pathHow);
  const auto path = readPath(options, pathHow);
  if (!path) return report(path.error());
  printNotices(path->notices);
  const model::Motion& motion = path->motion;
  const auto times = frameTimesOf(options, motion);
  if (!times) return report(times.error());
  auto file = verbs::T4dFile::create(options.output.fileOptions(),
                                     {"voxel4d", options.stock, motion.lengthUnit, motion.timeUnit,
                                      detailsOf(options, specs, times->size())});
  if (!file) return report(file.error());
  mill::MillOptions how = millOptions(options, *tools, *path);
  how.times = *times;
  const auto milled = [&] {
    ProgressBar bar("milling", times->size(), "frames");
    return mill::mill(*stock, *tools, motion, how, *file, bar.callback());
  }();
  if (!milled) return report(placed(milled.error(), options, specs));
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
  printReport(options, *milled, *path, *bytes, seconds);
  for (std::string& loss : file->losses()) losses.push_back(std::move(loss));
  return reportLosses(losses);
}

int run(const MillArguments& options) {
  if (const auto misuse = misuseOf(options)) return wrongUsage(*misuse);
  auto pathHow = pathOptions(options);
  if (!pathHow) return wrongUsage(pathHow.error().message);
  const auto table = readTable(options);
  if (!table) return report(table.error());
  const auto specs = millToolSpecs(options.tools, *table);
  if (!specs) return wrongUsage(specs.error().message);
  if (!specs->contains(0) && !options.motion.empty()) {
    return wrongUsage("tools with numbers are mounted by --gcode or --locations");
  }
  if (const auto misuse = misuseOfFiles(options, *specs)) return wrongUsage(*misuse);
  if (auto writable = checkWritable({{options.html}}); !writable) return report(writable.error());
  return millFiles(options, *specs, *table, std::move(*pathHow));
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
  options->tools.addTo(*command);
  command
      ->add_option("-m,--motion", options->motion,
                   "Tool motion: .json, or poses as .csv, .tsv or .txt (docs/motion.md)")
      ->check(someName());
  options->table.addTo(*command);
  command->add_option("--gcode", options->gcode, "Tool motion: G-code, in mm and s (docs/mill.md)")
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
      ->add_option("--tool-table", options->toolTable,
                   "Lengths of tools (G43), and tools in remarks: a tool table of LinuxCNC, in mm")
      ->check(someName());
  command
      ->add_option("--offset", options->offsets,
                   "Origin G54 to G59.3 in the frame of the stock, zero of the machine G53, or its "
                   "places G28 and G30: G55=100,0,-20 (repeatable)")
      ->allow_extra_args(false);
  command
      ->add_option("--rotary", options->rotaries,
                   "Rotary axis of table or head: A=table:0,0,-50, B=head:0,0,150 (repeatable)")
      ->allow_extra_args(false);
  command->add_flag("--tcp", options->tipControl,
                    "X, Y and Z are of the tip in the frame of the stock, as after G43.4");
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
  addNoPartOption(*command,
                  "milling cannot be divided: every cut starts from what the cuts before it left");
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
