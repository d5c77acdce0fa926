#include "tools/t4d/mill.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <iterator>
#include <map>
#include <optional>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "conformance/backends/milling.h"
#include "formats/output_file.h"
#include "formats/toolpath/tool_table.h"
#include "formats/triangle/triangle_mesh_formats.h"
#include "platform/kept_inputs.h"
#include "platform/stopwatch.h"
#include "platform/temporary_folder.h"
#include "t4d/slice.h"
#include "tools/t4d/commands.h"
#include "tools/t4d/console.h"
#include "tools/t4d/console_observer.h"
#include "tools/t4d/frame_options.h"
#include "tools/t4d/input.h"
#include "tools/t4d/json_option.h"
#include "tools/t4d/members.h"
#include "tools/t4d/mending.h"
#include "tools/t4d/mill_page.h"
#include "tools/t4d/mill_tools.h"
#include "tools/t4d/motion_options.h"
#include "tools/t4d/option_checks.h"
#include "tools/t4d/part_option.h"
#include "tools/t4d/slice.h"
#include "tools/t4d/t4d_output.h"
#include "tools/t4d/voxel_series.h"
#include "tools/t4d/weave_names.h"

namespace t4d::tools {
namespace {

using nlohmann::ordered_json;

/// The error, at the file that it is about.
Error atMillFile(Error error, const MillFiles& files) {
  if (error.where.empty() && error.remedy == Remedy::Motion) error.where = files.path;
  if (error.where.empty() || error.where == "stock") error.where = files.stock.path;
  if (const auto given = givenAs(error.where.file, files.tools)) error.where = *given;
  return error;
}

/// How the file was made, for its metadata.
std::string millDetails(const MillFiles& files, const MillOptions& options, std::size_t frames) {
  const auto fileName = [](const std::string& path) {
    return std::filesystem::path(path).filename().string();
  };
  ordered_json source{{"mesh", files.box.empty() ? fileName(files.stock.path) : files.box}};
  for (const auto& [number, spec] : files.tools) {
    const std::string tool = spec.files().empty() ? spec.tool : fileName(spec.tool);
    if (number == 0) {
      source["tool"] = tool;
    } else {
      source["tools"][std::to_string(number)] = tool;
    }
  }
  source[files.kind == ToolPathKind::Motion ? "motion" : "path"] = fileName(files.path);
  return ordered_json{{"source", source},
                      {"parameters",
                       {{"voxel_size", options.voxelSize},
                        {"frames", frames},
                        {"tolerance", options.toleranceOr()},
                        {"caps", nameOfCaps(options.caps)},
                        {"precision", options.output.writing.float32 ? "float32" : "float64"}}}}
      .dump(-1, ' ', false, ordered_json::error_handler_t::replace);
}

/// Notes the files that were read before.
void noteInputs(const MillFiles& files) {
  if (files.box.empty()) platform::noteInput(files.stock.path);
  platform::noteInput(files.path);
  for (const auto& [number, spec] : files.tools) {
    for (const std::string& file : spec.files()) platform::noteInput(file);
  }
}

mill::MillOptions optionsOfMilling(const MillInput& input, const MillOptions& options,
                                   const std::vector<double>& times) {
  mill::MillOptions how;
  how.voxelSize = options.voxelSize;
  how.times = times;
  how.tolerance = options.toleranceOr();
  how.travel = options.travel;
  how.memory = options.memory;
  for (const formats::Mounting& one : input.path.mountings) {
    how.mountings.push_back(mill::mountingOf(input.tools, one.time, one.tool));
  }
  how.rapids = input.path.rapids;
  how.caps = options.caps;
  return how;
}

}  // namespace

PathSummary summaryOf(const formats::ToolPath& path) {
  PathSummary summary;
  summary.dwell = path.dwell;
  int mounted = 0;
  for (const formats::Mounting& one : path.mountings) {
    const int tool = one.tool.value_or(mounted);
    summary.toolChanges += tool != mounted && mounted != 0 ? 1 : 0;
    mounted = tool;
  }
  std::size_t mounting = 0;
  std::size_t rapid = 0;
  for (const model::Segment& segment : path.motion.segments) {
    summary.extent.add(segment.start.translation);
    summary.extent.add(segment.end.translation);
    const double seconds = segment.timeEnd - segment.timeBegin;
    const double middle = 0.5 * (segment.timeBegin + segment.timeEnd);
    while (rapid < path.rapids.size() && path.rapids[rapid].end < middle) ++rapid;
    if (rapid < path.rapids.size() && path.rapids[rapid].begin < middle) {
      summary.rapid += seconds;
      continue;
    }
    while (mounting + 1 < path.mountings.size() && path.mountings[mounting + 1].time < middle) {
      ++mounting;
    }
    const bool holds = mounting < path.mountings.size() && path.mountings[mounting].time < middle;
    summary.cutting[holds ? path.mountings[mounting].tool.value_or(0) : 0] += seconds;
  }
  return summary;
}

Result<MillReport> mill(const MillInput& input, const MillOptions& options, Observer& observer) {
  const platform::Stopwatch stopwatch;
  const MillFiles& files = input.files;
  const model::Motion& motion = input.path.motion;
  const platform::KeptInputs kept;
  noteInputs(files);
  const auto times = voxel4d::frameTimes({motion.timeBegin(), motion.timeEnd()}, options.frames);
  if (!times) {
    Error error = times.error();
    error.where = files.path;
    return error;
  }
  auto file = T4dFile::create(options.output,
                              {"voxel4d", files.stock.path, motion.lengthUnit, motion.timeUnit,
                               millDetails(files, options, times->size())});
  if (!file) return file.error();
  auto milled = [&] {
    const auto stage = observer.stage("milling", times->size(), "frames");
    return mill::mill(input.stock, input.tools, motion, optionsOfMilling(input, options, *times),
                      *file, stage->callback());
  }();
  if (!milled) return atMillFile(milled.error(), files);
  const auto bytes = file->finish();
  if (!bytes) return bytes.error();
  MillReport report{.milled = std::move(*milled),
                    .path = summaryOf(input.path),
                    .motion = motion,
                    .mountings = input.path.mountings,
                    .bytes = *bytes};
  report.notices = report.milled.notices;
  if (!report.milled.firstCut) {
    report.notices.push_back(
        files.path +
        ": nothing is removed; the tool never meets the stock, or by less than the voxels show");
  }
  report.losses = input.losses;
  std::ranges::copy(file->losses(), std::back_inserter(report.losses));
  report.seconds = input.seconds + stopwatch.seconds();
  return report;
}

namespace {

void describePath(Members& members, const PathSummary& path) {
  members("min", path.extent.min, "Least coordinates of the tip, in the frame of the stock.");
  members("max", path.extent.max, "Largest coordinates of the tip.");
  members("cutting", std::vector(path.cutting.begin(), path.cutting.end()),
          "How long each tool moves by feed.", [](Members& own, const std::pair<int, double>& one) {
            own("tool", one.first, "Number of the tool; 0: one without a number.").atLeast(0);
            own("time", one.second, "In time units.").atLeast(0);
          });
  members("rapid_time", path.rapid, "How long rapid moves take.").atLeast(0);
  members("dwell_seconds", path.dwell,
          "How long the program dwells (G4), which the motion leaves out.")
      .atLeast(0);
  members("tool_changes", path.toolChanges, "Changes from one tool with a number to another.");
}

}  // namespace

void describe(Members& members, const MillReport& report) {
  const mill::MillReport& milled = report.milled;
  members("stock_volume", milled.stockVolume, "Volume of the first frame, the stock.").atLeast(0);
  members("removed_volume", milled.removedVolume, "Volume that was removed in all.").atLeast(0);
  members("remaining_volume", milled.remainingVolume, "Volume of the last frame.").atLeast(0);
  members("components", milled.components, "Parts that the workpiece consists of at the end.");
  members("frames", milled.progress.size(), "Frames that were woven.").atLeast(2);
  members("progress", milled.progress, "One for each frame.",
          [](Members& own, const mill::MillProgress& at) {
            own("time", at.time, "Time of the frame.");
            own("removed_volume", at.removedVolume, "Volume removed up to then.").atLeast(0);
            own("components", at.components, "Parts that the workpiece consists of then.");
          });
  members("separations", milled.separations, "When the workpiece falls apart.",
          [](Members& own, const mill::Separation& one) {
            own("begin", one.time.begin,
                "Time when the step of the tool that parts the voxels begins.");
            own("end", one.time.end,
                "Time when the tip has gone a voxel farther than in that step.");
            own("components", one.components, "Parts after it.").atLeast(2);
          });
  members("collisions", milled.collisions, "Contacts that must not be.",
          [](Members& own, const mill::Collision& one) {
            own("part", one.part, "What touches the stock; the tool, if a rapid move cuts.")
                .oneOf({"shank", "holder", "tool"});
            own("tool", one.tool,
                "Number of the tool that it is or belongs to; 0: tools have no numbers.")
                .atLeast(0);
            own("begin", one.time.begin,
                "Time when the first step of the tool with the contact begins.");
            own("end", one.time.end, "Time when the last one ends.");
            own("point", one.point,
                "A place of the contact in its first step, where it is deepest in the stock.");
          });
  const bool numbered = std::ranges::any_of(
      report.mountings, [](const auto& one) { return one.tool.value_or(0) > 0; });
  members("mountings", std::span(report.mountings).first(numbered ? report.mountings.size() : 0),
          "When tools are mounted; empty if they have no numbers.",
          [](Members& own, const formats::Mounting& one) {
            own("time", one.time, "From this time on.");
            own("tool", one.tool.value_or(0), "Number of the tool; 0: none.").atLeast(0);
          });
  members("path", report.path, "What the tool does.", describePath);
  members("returned_volume", milled.returnedVolume,
          "The most that comes back between frames and goes again, in cells that lean backward: 0, "
          "or a small part of what is removed.")
      .atLeast(0);
  members("steps", milled.steps, "Steps of the tool; the envelope of each was removed.").atLeast(1);
  members("vertices", milled.woven.vertices, "Vertices of the 4D mesh.");
  members("tetrahedra", milled.woven.tetrahedra, "Cells of the 4D mesh.");
  addCosts(members, report.seconds);
  members("bytes", report.bytes, "Size of the file, in bytes.");
}

namespace {

struct MillArguments {
  std::string stock;
  std::string box;
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
  std::string start;
  std::string dialect;
  formats::ToolPathOptions program;
  MillOptions mill;
  double memory = 4;  // GB
  voxel4d::FrameTimes times;
  std::string caps = "graded";
  std::string html;
  T4dOutput output;
  bool json = false;

  ToolPathKind kind() const {
    if (!gcode.empty()) return ToolPathKind::Gcode;
    return locations.empty() ? ToolPathKind::Motion : ToolPathKind::Locations;
  }
  const std::string& path() const {
    return !gcode.empty() ? gcode : !locations.empty() ? locations : motion;
  }
};

/// What G-code and cutter locations are read with, but for tools.
Result<formats::ToolPathOptions> pathOptions(const MillArguments& options) {
  formats::ToolPathOptions how = options.program;
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
  if (!options.start.empty()) {
    const auto start = formats::parsePoint(options.start);
    if (!start) return invalid("--start: " + start.error().message);
    how.start = *start;
  }
  if (!options.dialect.empty()) how.dialect = formats::gcodeDialect(options.dialect);
  return how;
}

std::string timeText(double time, const std::string& unit) {
  return unit.empty() ? fmt::format("{:.4g}", time) : fmt::format("{:.4g} {}", time, unit);
}

/// "tip from (-16, 0, 4) to (16, 0, 30); T1 cuts 3.2 s, rapid moves 0.4 s".
void printPath(const PathSummary& path, const model::Motion& motion) {
  const auto point = [](const model::Point3& at) {
    return fmt::format("({:.6g}, {:.6g}, {:.6g})", at.x(), at.y(), at.z());
  };
  std::string text;
  for (const auto& [tool, time] : path.cutting) {
    text += fmt::format("{}cuts {}, ", tool == 0 ? "" : fmt::format("T{} ", tool),
                        timeText(time, motion.timeUnit));
  }
  text += fmt::format("rapid moves {}", timeText(path.rapid, motion.timeUnit));
  if (path.dwell > 0) text += fmt::format(", dwells {:.4g} s (left out)", path.dwell);
  if (path.toolChanges > 0) text += ", " + counted(path.toolChanges, "tool change");
  print("  tip from {} to {}; {}\n", point(path.extent.min), point(path.extent.max), text);
}

void printText(const MillArguments& options, const MillReport& done) {
  const mill::MillReport& report = done.milled;
  const model::Motion& motion = done.motion;
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
  printPath(done.path, motion);
  int mounted = 0;
  for (const formats::Mounting& one : done.mountings) {
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
  print("  {}, {:.2f} s, peak memory {}\n", sizeText(done.bytes), done.seconds,
        sizeText(peakBytes()));
  if (const auto rounding = options.output.coding.rounding()) print("  {}\n", *rounding);
}

/// The page, with slices of the file.
Result<void> writePage(const std::string& process, const MillArguments& options,
                       const mill::MillReport& report) {
  const ProgressBar bar("drawing");
  const auto input = openInput(process, InputOptions{});
  if (!input) return input.error();
  const model::Source& milled = *input->bodies.front().source;
  const std::vector<double> times = model::evenTimes(model::timeSpanOf(milled), 6);
  auto slices = slice::sliceAtTimes(milled, times);
  Workpieces workpieces;
  for (std::size_t i = 0; i < times.size(); ++i) {
    if (!slices[i]) return slices[i].error();
    workpieces.emplace_back(times[i], std::move(slices[i]->mesh));
  }
  const std::string title =
      "Milling of " + (options.stock.empty()
                           ? options.box
                           : std::filesystem::path(options.stock).filename().string());
  return formats::writeOutputFile(options.html,
                                  millPage(title, input->metadata, report, workpieces));
}

bool isPart(const std::string& path) {
  return path != "-" &&
         std::ranges::any_of(formats::writableTriangleMeshes(),
                             [&](std::string_view one) { return path.ends_with(one); });
}

/// Writes the solid at the end of a .t4d.
Result<SliceReport> writePart(const std::string& process, const std::string& path) {
  const auto input = openInput(process, InputOptions{});
  if (!input) return input.error();
  SliceOptions how;
  how.output = path;
  how.time = model::timeSpanOf(*input->bodies.front().source).end;
  return sliceMesh(*input, how, nobody());
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
                        !options.rotaries.empty() || options.program.tipControl ||
                        !options.start.empty() || !options.dialect.empty() ||
                        options.program.defaultFeed;
  if (options.gcode.empty() && saysMore) {
    return "--tool-table, --offset, --rotary, --tcp, --start, --feed and --dialect are for "
           "--gcode";
  }
  if (options.stock.empty() == options.box.empty()) {
    return "the solid to mill is given by a file, or by --stock box:LENGTH,WIDTH,HEIGHT";
  }
  if (!options.html.empty() && options.output.path == "-") {
    return "--html needs the .t4d in a file";
  }
  return std::nullopt;
}

/// Fails if an output cannot be written, or is an input or another output.
Result<void> checkFiles(const MillArguments& options, const MillToolSpecs& specs) {
  std::vector<std::string> inputs = {options.path()};
  if (!options.stock.empty()) inputs.push_back(options.stock);
  if (!options.toolTable.empty()) inputs.push_back(options.toolTable);
  for (const auto& [number, spec] : specs) {
    for (std::string& file : spec.files()) inputs.push_back(std::move(file));
  }
  return checkOutputs(std::array{options.output.path, options.html}, inputs);
}

using TableTools = std::map<int, formats::TableTool>;

Result<TableTools> readTable(const MillArguments& options) {
  if (options.toolTable.empty()) return TableTools();
  return formats::readToolTable(options.toolTable);
}

MillOptions millOptions(const MillArguments& options) {
  MillOptions how = options.mill;
  how.memory = 1e9 * options.memory;
  how.caps = voxelCapStyle(options.caps);
  how.output = options.output.fileOptions();
  if (options.times.count || options.times.step) how.frames = options.times;
  return how;
}

/// Mills these files, which have been checked.
int millFiles(const MillArguments& options, const MillFiles& files) {
  MillOptions how = millOptions(options);
  // A part is the end of a process, which is written aside.
  std::optional<platform::TemporaryFolder> aside;
  if (isPart(options.output.path)) {
    auto made = platform::TemporaryFolder::create();
    if (!made) return report(made.error());
    aside.emplace(std::move(*made));
    how.output.path = (aside->path() / "process.t4d").string();
  }
  ConsoleObserver observer;
  const auto input = readMilling(files, how, observer);
  if (!input) return report(input.error());
  if (input->path.unknownMoves > 0) {
    printNotices({"--offset G53=x,y,z gives the machine's zero in the frame of the stock"});
  }
  if (!options.times.count && !options.times.step) noticeDefaultFrames();
  const auto milled = mill(*input, how, observer);
  if (!milled) return report(milled.error());
  printNotices(milled->notices);
  std::vector<std::string> losses = milled->losses;
  if (aside) {
    auto part = writePart(how.output.path, options.output.path);
    if (!part) return report(part.error());
    losses.insert(losses.end(), part->losses.begin(), part->losses.end());
  }
  if (!options.html.empty()) {
    if (auto written = writePage(how.output.path, options, milled->milled); !written) {
      return report(written.error());
    }
  }
  if (options.json) {
    printAsJson(*milled);
  } else {
    printText(options, *milled);
  }
  return reportLosses(losses);
}

int run(const MillArguments& options) {
  if (const auto misuse = misuseOf(options)) return wrongUsage(*misuse);
  auto program = pathOptions(options);
  if (!program) return wrongUsage(program.error().message);
  const auto table = readTable(options);
  if (!table) return report(table.error());
  const auto specs = millToolSpecs(options.tools, *table);
  if (!specs) return wrongUsage(specs.error().message);
  if (!specs->contains(0) && !options.motion.empty()) {
    return wrongUsage("tools with numbers are mounted by --gcode or --locations");
  }
  if (auto good = checkFiles(options, *specs); !good) return report(good.error());
  return millFiles(options, {.stock = {options.stock.empty() ? "stock" : options.stock,
                                       {},
                                       options.mending.given(options.mend)},
                             .box = options.box,
                             .tools = *specs,
                             .kind = options.kind(),
                             .path = options.path(),
                             .table = options.table.table,
                             .program = std::move(*program),
                             .toolTable = *table});
}

}  // namespace

void addMill(CLI::App& app, int& exitCode) {
  auto* command = app.add_subcommand(
      "mill", "Mill a solid with a moving tool; write the workpiece as a 4D mesh");
  auto options = std::make_shared<MillArguments>();
  command
      ->add_option("STOCK", options->stock,
                   "Solid to mill: " + formats::readableTriangleMeshExtensions())
      ->check(someName());
  command
      ->add_option("--stock", options->box,
                   "Block to mill instead: box:100,60,20, the middle of its top at the origin, or "
                   "with its lowest corner, box:100,60,20@0,0,-20")
      ->check(someName());
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
  command->add_option("--voxel-size", options->mill.voxelSize, "Voxel edge length, in length units")
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
                   "positions G28 and G30: G55=100,0,-20 (repeatable)")
      ->allow_extra_args(false);
  command
      ->add_option("--rotary", options->rotaries,
                   "Rotary axis of table or head: A=table:0,0,-50, B=head:0,0,150 (repeatable)")
      ->allow_extra_args(false);
  command->add_flag(
      "--tcp", options->program.tipControl,
      "Take X, Y and Z as the position of the tip in the frame of the stock, as after G43.4");
  command->add_option("--start", options->start,
                      "Where the tool is before the program says so, in the frame of the stock: "
                      "0,0,50");
  command
      ->add_option("--feed", options->program.defaultFeed,
                   "Feed rate where the program gives none, in mm/min")
      ->check(numberAboveZero());
  command
      ->add_option("--dialect", options->dialect,
                   "Control that the program is for (default: what it looks like)")
      ->check(CLI::IsMember({"linuxcnc", "grbl", "fanuc", "haas", "mach3", "siemens"}));
  command
      ->add_option("--tolerance", options->mill.tolerance,
                   "Maximum error of tool, arcs and turns, in length units (default: 0.01 voxels)")
      ->check(numberAboveZero());
  command
      ->add_option("--travel", options->mill.travel,
                   "Maximum travel of the tip per step, in length units (default: 4 voxels)")
      ->check(numberAboveZero());
  command->add_option("--rapid", options->program.rapidFeed, "Feed rate of rapid moves, in mm/min")
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
      ->check(htmlFile());
  options->mending.addTo(*command, options->mend);
  addNoPartOption(*command,
                  "milling cannot be divided: every cut starts from what the cuts before it left");
  options->output.addTo(*command, formats::writableTriangleMeshes());
  addJsonOption<MillReport>(
      *command, options->json,
      "What a tool removed from a stock, over time. Volumes are in cubic length units, those of "
      "the workpiece as the voxels have it.");
  command->footer(
      "Examples:\n  t4d mill cube.obj --tool ball:d=6,l=30 --gcode pocket.nc --voxel-size 0.5 --up "
      "z "
      "-o process.t4d\n"
      "  t4d slice process.t4d --time 5 -o at-5.glb");
  command->callback([=, &exitCode] { exitCode = run(*options); });
}

}  // namespace t4d::tools
