#include "tools/t4d/transform.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <map>
#include <set>

#include <Eigen/LU>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "edit/map_space_time.h"
#include "formats/t4d/body_details.h"
#include "formats/triangle/rounding_loss.h"
#include "platform/stopwatch.h"
#include "t4d/file.h"
#include "t4d/mesh.h"
#include "tools/t4d/commands.h"
#include "tools/t4d/console.h"
#include "tools/t4d/console_observer.h"
#include "tools/t4d/input.h"
#include "tools/t4d/json_option.h"
#include "tools/t4d/members.h"
#include "tools/t4d/moved_bounds.h"
#include "tools/t4d/option_checks.h"
#include "tools/t4d/origin.h"
#include "tools/t4d/space_time_map.h"
#include "tools/t4d/t4d_output.h"
#include "tools/t4d/version.h"

namespace t4d::tools {
namespace {

/// Compares slabs that are moved with the same about the origin, where doubles are finest.
class MovingLoss : public model::Sink {
 public:
  explicit MovingLoss(const model::Transform& by) : by_(by), about_(by) {
    about_.space.col(3).setZero();
    about_.timeShift = 0;
  }

  Result<void> put(const model::Slab& slab) override {
    if (!slab.connectivity) return {};
    loss_.add(mapped(slab, about_), mapped(slab, by_));
    return {};
  }
  std::optional<std::string> line() const { return loss_.line(); }

 private:
  static model::Slab mapped(const model::Slab& slab, const model::Transform& by) {
    model::Slab moved;
    moved.connectivity = slab.connectivity;
    for (const model::Point4& vertex : slab.vertices) moved.vertices.push_back(by(vertex));
    return moved;
  }

  model::Transform by_;
  model::Transform about_;
  formats::RoundingLoss loss_ = formats::RoundingLoss::ofMoving();
};

/// Maps space and time of all bodies; `mapped` keeps what they are now. Returns their bounds.
Result<model::Bounds3> mapBodies(const Eigen::Matrix4d& axes, Input& input,
                                 std::deque<edit::MappedMesh>& mapped, Observer& observer) {
  const auto stage = observer.stage("mapping", slabCountOf(input.bodies), "slabs");
  model::Bounds3 bounds;
  for (model::Body& body : input.bodies) {
    auto done = edit::mapSpaceTime(*body.source, axes, stage->part(body.source->slabCount()));
    if (!done) return done.error();
    mapped.push_back(std::move(*done));
    const model::Mesh& mesh = mapped.back().cut.mesh;
    for (const model::Slab& slab : mesh.slabs()) {
      for (const model::Point4& vertex : slab.vertices) bounds.add(vertex.head<3>());
    }
    body.source = &mesh;
  }
  return bounds;
}

std::vector<std::string> lossesOfMapping(const std::deque<edit::MappedMesh>& mapped) {
  std::set<std::string> names;
  for (const edit::MappedMesh& mesh : mapped) {
    names.insert(mesh.droppedAttributes.begin(), mesh.droppedAttributes.end());
  }
  if (names.empty()) return {};
  return {fmt::format("attributes not kept where time is exchanged: {}", fmt::join(names, ", "))};
}

/// The metadata of the mapped mesh.
formats::Metadata mappedMetadata(const Input& input, const TransformOptions& options,
                                 const model::Transform& transform, TransformReport& report) {
  formats::Metadata metadata = metadataOf(input, options.generator);
  metadata.lengthUnit = options.lengthUnit.value_or(metadata.lengthUnit);
  metadata.timeUnit = options.timeUnit.value_or(metadata.timeUnit);
  metadata.up = options.up.value_or(metadata.up);
  // Where axes are scaled by different factors, nothing is known of the motion any more.
  const double scale = std::cbrt(std::abs(transform.space.leftCols<3>().determinant()));
  for (formats::BodyInfo& body : metadata.bodies) {
    if (const auto bound = chordBoundOf(body)) setChordBound(body, *bound * scale);
  }
  if (options.space) {
    metadata.space = *options.space;
  } else if (!metadata.space.empty() && mixesTime(options)) {
    report.losses.push_back(
        fmt::format("space {}: its axes are exchanged with time", metadata.space));
    metadata.space.clear();
  } else if (transform.mirrors()) {
    report.mirroredSpace = metadata.space;
  }
  // The origin of a mesh that was centred moves with it.
  model::Point4 origin = model::Point4::Zero();
  origin.head<3>() = originOf(metadata);
  if (mixesTime(options)) origin = *axesMatrix(options.axes) * origin;
  metadata.detailsJson =
      withOrigin(metadata.detailsJson, transform.space.leftCols<3>() * origin.head<3>());
  return metadata;
}

/// Writes the mapped bodies. `coarse`: doubles are coarse where they will be.
Result<void> writeMapped(const Input& input, const TransformOptions& options, bool coarse,
                         TransformReport& report, Observer& observer) {
  const model::Transform& transform = report.map;
  const formats::Metadata metadata = mappedMetadata(input, options, transform, report);
  auto writer =
      formats::T4dWriter::create(options.output, metadata, {.compression = options.compression});
  if (!writer) return writer.error();
  MovingLoss moved(transform);
  std::map<std::string, std::string> lost;
  {
    const auto stage = observer.stage("transforming", slabCountOf(input.bodies), "slabs");
    for (std::size_t i = 0; i < input.bodies.size(); ++i) {
      const model::Source& source = *input.bodies[i].source;
      model::Transformed sink(writer->body(i), transform, metadata.attributes);
      model::Tee both({&moved, &sink});
      model::Sink& into = coarse ? static_cast<model::Sink&>(both) : sink;
      if (auto done = model::pump(source, into, stage->part(source.slabCount())); !done) {
        return inInput(done.error(), input);
      }
      lost.insert(sink.lostAttributes().begin(), sink.lostAttributes().end());
    }
  }
  for (const auto& [name, why] : lost) {
    report.losses.push_back(fmt::format("attribute '{}': {}", name, why));
  }
  if (auto line = moved.line()) report.losses.push_back(std::move(*line));
  const auto bytes = finishEdited(*writer, input);
  if (!bytes) return bytes.error();
  report.bytes = *bytes;
  for (const std::string& loss : writer->losses()) report.losses.push_back(loss);
  return {};
}

}  // namespace

Result<TransformReport> transform(const Input& given, const TransformOptions& options,
                                  Observer& observer) {
  const platform::Stopwatch stopwatch;
  TransformReport report;
  report.bodies = given.bodies.size();
  report.axes = options.axes;
  report.map = transformOf(options);
  Input input = given;
  auto bounds = boundsOf(input);
  if (!bounds) return inInput(bounds.error(), input);
  std::deque<edit::MappedMesh> mapped;
  if (mixesTime(options)) {
    bounds = mapBodies(*axesMatrix(options.axes), input, mapped, observer);
    if (!bounds) return bounds.error();
    report.losses = lossesOfMapping(mapped);
  }
  const auto coarse =
      checkMovedBounds(*bounds, model::timeSpanOf(input.bodies), report.map, input.name);
  if (!coarse) return coarse.error();
  if (auto done = writeMapped(input, options, *coarse, report, observer); !done) {
    return done.error();
  }
  report.seconds = stopwatch.seconds();
  return report;
}

void describe(Members& members, const TransformReport& report) {
  std::array<double, 12> matrix{};
  for (std::size_t i = 0; i < matrix.size(); ++i) {
    matrix[i] = report.map.space(static_cast<int>(i / 4), static_cast<int>(i % 4));
  }
  members("bodies", report.bodies, "Bodies written.").atLeast(1);
  members("axes", report.axes, "The value of --axes; \"\" for nothing.");
  members("matrix", matrix,
          "The map of space, after axes that exchange or reverse time: 3 rows of 4 numbers, row by "
          "row, the last of each row a translation.");
  members("time_scale", report.map.timeScale, "The factor of times.").above(0);
  members("time_shift", report.map.timeShift, "The number added to times after that.");
  members("mirrored", report.map.mirrors(), "Whether the map mirrors space.");
  members("bytes", report.bytes, "Size of the file, in bytes.");
  addCosts(members, report.seconds);
}

namespace {

struct TransformArguments {
  std::string input;
  InputOptions bodies;
  std::vector<double> scale;
  std::vector<double> rotate;
  std::vector<double> matrix;
  std::vector<double> move;
  std::optional<std::string> space;
  TransformOptions transform;
  bool json = false;
};

CLI::Validator axesInSomeOrder() {
  return CLI::Validator(
      [](std::string& text) -> std::string {
        if (areAxes(text)) return {};
        return fmt::format(
            "'{}' is not x, y and z in some order, with signs or without, as y-xz, "
            "nor x, y, z and t, as xtzy",
            text);
      },
      "AXES");
}

std::optional<std::string> misuseOf(const TransformArguments& options) {
  if (options.scale.size() == 2) return "--scale is one factor, or three";
  const auto isZero = [](double number) { return number == 0; };
  if (std::ranges::any_of(options.scale, isZero)) return "--scale: 0 leaves no solid";
  const auto& r = options.rotate;
  if (!r.empty() && r[0] == 0 && r[1] == 0 && r[2] == 0) return "--rotate: the axis is 0 0 0";
  if (options.matrix.empty()) return std::nullopt;
  model::Transform matrix;
  matrix.space =
      Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>>(options.matrix.data());
  if (matrix.flattens()) return "--matrix leaves no solid: its determinant is 0, up to rounding";
  return std::nullopt;
}

TransformOptions optionsOf(const TransformArguments& arguments) {
  TransformOptions options = arguments.transform;
  if (const auto& s = arguments.scale; !s.empty()) {
    options.scale = {s.front(), s[s.size() / 2], s.back()};
  }
  if (const auto& r = arguments.rotate; !r.empty()) {
    options.rotate = Rotation{{r[0], r[1], r[2]}, r[3]};
  }
  if (const auto& m = arguments.matrix; !m.empty()) {
    std::ranges::copy(m, options.matrix.emplace().begin());
  }
  if (const auto& by = arguments.move; !by.empty()) options.move = {by[0], by[1], by[2]};
  if (arguments.space) options.space = *arguments.space == "none" ? "" : *arguments.space;
  options.generator = versionText();
  return options;
}

void printReport(const TransformReport& done, const std::string& output) {
  print("{}: {}{}\n", output, counted(done.bodies, "body", "bodies"),
        done.map.mirrors() ? ", mirrored" : "");
  print("  {}, {:.2f} s, peak memory {}\n", sizeText(done.bytes), done.seconds,
        sizeText(peakBytes()));
}

int run(const TransformArguments& options) {
  if (const auto misuse = misuseOf(options)) return wrongUsage(*misuse);
  const auto input = openInput(options.input, options.bodies);
  if (!input) return report(input.error());
  ConsoleObserver observer;
  const auto done = transform(*input, optionsOf(options), observer);
  if (!done) return report(done.error());
  const std::string& output = options.transform.output;
  if (!done->mirroredSpace.empty()) {
    printNotices(
        {fmt::format("{}: mirrored, and still called {}: left and right are exchanged; "
                     "--space names it anew",
                     output, done->mirroredSpace)});
  }
  if (options.json) {
    printAsJson(*done);
  } else {
    printReport(*done, output);
  }
  return reportLosses(done->losses);
}

}  // namespace

void addTransform(CLI::App& app, int& exitCode) {
  auto* command = app.add_subcommand(
      "transform", "Move, rotate, scale or mirror a 4D mesh, and change its times");
  auto options = std::make_shared<TransformArguments>();
  command->add_option("FILE", options->input, kT4dFileHelp)->required();
  options->bodies.addTo(*command);
  addT4dOutputOption(*command, options->transform.output);
  command
      ->add_option("--axes", options->transform.axes,
                   "First: axes that become x, y, z, as y-xz, or x, y, z, t, as xtzy or xyz-t")
      ->check(axesInSomeOrder());
  addNumbers(*command, "--scale", options->scale, "Then: scale by one factor, or by one per axis",
             1, 3, "S | SX SY SZ");
  addNumbers(*command, "--rotate", options->rotate,
             "Then: rotate about an axis through the origin, in degrees", 4, 4, "AX AY AZ DEGREES");
  addNumbers(*command, "--matrix", options->matrix,
             "Then: apply a matrix of 3 rows and 4 columns, row by row", 12, 12, "M00 M01 ... M23");
  addNumbers(*command, "--move", options->move, "Then: add to all positions", 3, 3, "DX DY DZ");
  command
      ->add_option("--time-scale", options->transform.timeScale,
                   "Multiply all times by a number above 0")
      ->check(numberAboveZero())
      ->capture_default_str();
  command->add_option("--time-shift", options->transform.timeShift, "Then: add to all times")
      ->check(finiteNumber())
      ->capture_default_str();
  command
      ->add_option("--length-unit", options->transform.lengthUnit,
                   "Set the name of the length unit; coordinates are not converted")
      ->type_name("NAME");
  command
      ->add_option("--time-unit", options->transform.timeUnit,
                   "Set the name of the time unit; times are not converted")
      ->type_name("NAME");
  command
      ->add_option("--up", options->transform.up,
                   "Set the axis that points up; the solid is not rotated")
      ->check(CLI::IsMember({"y", "z"}));
  command->add_option("--space", options->space, "Set the anatomical space; the solid is not moved")
      ->check(CLI::IsMember({"RAS", "LPS", "none"}));
  addCompressionOption(*command, options->transform.compression);
  addJsonOption<TransformReport>(
      *command, options->json,
      "The map that was applied to a 4D mesh, and the file that was written.");
  command->footer(
      "Example:\n  t4d transform bolt.t4d --rotate 1 0 0 90 --move 0 0 5 -o upright.t4d");
  command->callback([=, &exitCode] { exitCode = run(*options); });
}

}  // namespace t4d::tools
