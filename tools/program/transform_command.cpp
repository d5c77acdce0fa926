#include <algorithm>
#include <chrono>
#include <cmath>
#include <deque>
#include <map>
#include <numbers>
#include <set>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "t4d/edit/map_space_time.h"
#include "t4d/formats/t4d/body_details.h"
#include "t4d/formats/t4d/writer.h"
#include "t4d/formats/triangle/rounding_loss.h"
#include "t4d/model/limits.h"
#include "t4d/model/sinks.h"
#include "t4d/model/transformed.h"
#include "t4d/verbs/origin.h"
#include "tools/program/commands.h"
#include "tools/program/console.h"
#include "tools/program/input_options.h"
#include "tools/program/option_checks.h"
#include "tools/program/t4d_output.h"
#include "tools/program/version.h"

namespace t4d::tools {
namespace {

using nlohmann::ordered_json;

struct TransformArguments {
  std::string input;
  InputOptions bodies;
  std::string output;
  std::string axes;
  std::vector<double> scale;
  std::vector<double> rotate;
  std::vector<double> matrix;
  std::vector<double> move;
  double timeScale = 1;
  double timeShift = 0;
  std::optional<std::string> lengthUnit;
  std::optional<std::string> timeUnit;
  std::optional<std::string> up;
  std::optional<std::string> space;
  int compression = 3;
  bool json = false;
};

/// "yzx", "-yxz" or "tyzx": which axis of the input becomes x, y and z, and t if there are four.
std::optional<Eigen::Matrix4d> axesOf(const std::string& text) {
  const std::string letters = "xyzt";
  Eigen::Matrix4d axes = Eigen::Matrix4d::Zero();
  int row = 0;
  double sign = 1;
  for (const char c : text) {
    if (c == '-' && sign > 0) {
      sign = -1;
      continue;
    }
    const auto column = letters.find(c);
    if (column == std::string::npos || row == 4) return std::nullopt;
    axes(row++, static_cast<Eigen::Index>(column)) = sign;
    sign = 1;
  }
  if (row == 3) axes(row++, 3) = 1;
  if (row != 4 || sign < 0 || std::abs(axes.determinant()) != 1) return std::nullopt;
  return axes;
}

/// Whether time becomes something else, by exchange or reversal.
bool mixesTime(const TransformArguments& options) {
  return !options.axes.empty() && (*axesOf(options.axes))(3, 3) != 1;
}

CLI::Validator axesInSomeOrder() {
  return CLI::Validator(
      [](std::string& text) -> std::string {
        if (axesOf(text)) return {};
        return fmt::format(
            "'{}' is not x, y and z in some order, with signs or without, as y-xz, "
            "nor x, y, z and t, as xtzy",
            text);
      },
      "AXES");
}

/// The options in the order of their help.
model::Transform transformOf(const TransformArguments& options) {
  model::Transform transform;
  auto linear = transform.space.leftCols<3>();
  auto shift = transform.space.col(3);
  if (!options.axes.empty() && !mixesTime(options)) {
    linear = axesOf(options.axes)->topLeftCorner<3, 3>();
  }
  if (!options.scale.empty()) {
    const auto& s = options.scale;
    const Eigen::Vector3d factors(s.front(), s[s.size() / 2], s.back());
    linear = (factors.asDiagonal() * linear).eval();
  }
  if (!options.rotate.empty()) {
    const auto& r = options.rotate;
    const Eigen::AngleAxisd turn(r[3] * std::numbers::pi / 180,
                                 Eigen::Vector3d(r[0], r[1], r[2]).stableNormalized());
    linear = (turn.toRotationMatrix() * linear).eval();
  }
  if (!options.matrix.empty()) {
    const Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>> matrix(
        options.matrix.data());
    linear = (matrix.leftCols<3>() * linear).eval();
    shift = matrix.col(3);
  }
  if (!options.move.empty()) {
    shift += Eigen::Vector3d(options.move[0], options.move[1], options.move[2]);
  }
  transform.timeScale = options.timeScale;
  transform.timeShift = options.timeShift;
  return transform;
}

std::optional<std::string> misuseOf(const TransformArguments& options) {
  if (options.scale.size() == 2) return "--scale is one factor, or three";
  const auto isZero = [](double number) { return number == 0; };
  if (std::ranges::any_of(options.scale, isZero)) return "--scale: 0 leaves no solid";
  const auto& r = options.rotate;
  if (!r.empty() && r[0] == 0 && r[1] == 0 && r[2] == 0) return "--rotate: the axis is 0 0 0";
  if (options.matrix.empty()) return misuseOfOutput(options.output, {&options.input, 1});
  model::Transform matrix;
  matrix.space =
      Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>>(options.matrix.data());
  if (matrix.flattens()) return "--matrix leaves no solid: its determinant is 0, up to rounding";
  return misuseOfOutput(options.output, {&options.input, 1});
}

/// Fails if the solid would be so far from the origin, for its width, that doubles flatten it, or
/// so small that products of its extents vanish. `moves` is set if doubles are much coarser where
/// it will be than they need be for its size, so that parts of it may become flat.
Result<void> checkBounds(const model::Bounds3& bounds, const model::TimeSpan& span,
                         const model::Transform& transform, const std::string& where, bool& moves) {
  model::Bounds3 moved;
  for (unsigned corner = 0; corner < 8; ++corner) {
    model::Point3 point;
    for (unsigned axis = 0; axis < 3; ++axis) {
      point[axis] = (corner >> axis & 1U) != 0 ? bounds.max[axis] : bounds.min[axis];
    }
    moved.add(model::posed(transform.space, point));
  }
  const double farthest =
      std::max(moved.max.cwiseAbs().maxCoeff(), moved.min.cwiseAbs().maxCoeff());
  const double narrowest = (moved.max - moved.min).minCoeff();
  constexpr double kMostWidths = 4e12;  // doubles are finer there than a thousandth of the width
  constexpr double kFewWidths = 1e3;
  const model::TimeSpan times{transform.time(span.begin), transform.time(span.end)};
  const double latest = std::max(std::abs(times.begin), std::abs(times.end));
  const double duration = times.end - times.begin;
  if (!(latest <= model::kLargestCoordinate)) {
    return invalid(fmt::format("would reach the time {:.3g}; the largest possible time is {}. "
                               "Scale or shift times less",
                               latest, model::kLargestCoordinate),
                   where);
  }
  if (span.end > span.begin && !(duration >= model::kSmallestExtent)) {
    return invalid(fmt::format("would last for {:.3g}; the shortest possible duration is {}. Scale "
                               "times less",
                               duration, model::kSmallestExtent),
                   where);
  }
  if ((bounds.max - bounds.min).minCoeff() > 0 && !(narrowest >= model::kSmallestExtent)) {
    return invalid(fmt::format("would be {:.3g} wide where it is narrowest; the smallest possible "
                               "width is {}. Scale it less",
                               narrowest, model::kSmallestExtent),
                   where);
  }
  moves = farthest > kFewWidths * narrowest || latest > kFewWidths * duration;
  if (!(farthest <= model::kLargestCoordinate)) {
    return invalid(
        fmt::format("would reach {:.3g} from the origin; the largest possible coordinate "
                    "is {}. Scale or move it less",
                    farthest, model::kLargestCoordinate),
        where);
  }
  if (farthest <= kMostWidths * narrowest) return {};
  return invalid(fmt::format("would reach {:.3g} from the origin, and be {:.3g} wide where it is "
                             "narrowest: doubles are too coarse there to keep its shape. Move it "
                             "less, or scale all axes alike",
                             farthest, narrowest),
                 where);
}

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
Result<model::Bounds3> mapBodies(const Eigen::Matrix4d& axes, verbs::Input& input,
                                 std::deque<edit::MappedMesh>& mapped) {
  ProgressBar bar("mapping", verbs::slabCountOf(input.bodies), "slabs");
  model::Bounds3 bounds;
  for (model::Body& body : input.bodies) {
    auto done = edit::mapSpaceTime(*body.source, axes, bar.part(body.source->slabCount()));
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

std::vector<std::string> lossesOf(const std::deque<edit::MappedMesh>& mapped) {
  std::set<std::string> names;
  for (const edit::MappedMesh& mesh : mapped) {
    names.insert(mesh.droppedAttributes.begin(), mesh.droppedAttributes.end());
  }
  if (names.empty()) return {};
  return {fmt::format("attributes not kept where time is exchanged: {}", fmt::join(names, ", "))};
}

int run(const TransformArguments& options) {
  if (const auto misuse = misuseOf(options)) return wrongUsage(*misuse);
  const auto begin = std::chrono::steady_clock::now();
  const model::Transform transform = transformOf(options);
  auto input = verbs::openInput(options.input, options.bodies);
  if (!input) return report(input.error());

  std::deque<edit::MappedMesh> mapped;
  const auto boundsBefore = boundsOf(*input);
  if (!boundsBefore) return report(inInput(boundsBefore.error(), *input));
  model::Bounds3 bounds = *boundsBefore;
  std::vector<std::string> losses;
  if (mixesTime(options)) {
    auto done = mapBodies(*axesOf(options.axes), *input, mapped);
    if (!done) return report(done.error());
    bounds = *done;
    losses = lossesOf(mapped);
  }
  const model::TimeSpan span = model::timeSpanOf(input->bodies);
  bool moves = false;
  if (auto fits = checkBounds(bounds, span, transform, options.input, moves); !fits) {
    return report(fits.error());
  }

  formats::Metadata metadata = metadataOf(*input, versionText());
  metadata.lengthUnit = options.lengthUnit.value_or(metadata.lengthUnit);
  metadata.timeUnit = options.timeUnit.value_or(metadata.timeUnit);
  metadata.up = options.up.value_or(metadata.up);
  // Where axes are scaled by different factors, nothing is known of the motion any more.
  const double scale = std::cbrt(std::abs(transform.space.leftCols<3>().determinant()));
  for (formats::BodyInfo& body : metadata.bodies) {
    if (const auto bound = chordBoundOf(body)) setChordBound(body, *bound * scale);
  }
  if (options.space) {
    metadata.space = *options.space == "none" ? "" : *options.space;
  } else if (!metadata.space.empty() && mixesTime(options)) {
    losses.push_back(fmt::format("space {}: its axes are exchanged with time", metadata.space));
    metadata.space.clear();
  } else if (!metadata.space.empty() && transform.mirrors()) {
    printNotices(
        {fmt::format("{}: mirrored, and still called {}: left and right are exchanged; "
                     "--space names it anew",
                     options.output, metadata.space)});
  }
  // Of a mesh that was centred, the place of the origin moves with it.
  model::Point4 origin = model::Point4::Zero();
  origin.head<3>() = verbs::originOf(metadata);
  if (mixesTime(options)) origin = *axesOf(options.axes) * origin;
  metadata.detailsJson =
      verbs::withOrigin(metadata.detailsJson, transform.space.leftCols<3>() * origin.head<3>());
  auto writer =
      formats::T4dWriter::create(options.output, metadata, {.compression = options.compression});
  if (!writer) return report(writer.error());
  MovingLoss moved(transform);
  std::map<std::string, std::string> lost;
  {
    ProgressBar bar("transforming", verbs::slabCountOf(input->bodies), "slabs");
    for (std::size_t i = 0; i < input->bodies.size(); ++i) {
      const model::Source& source = *input->bodies[i].source;
      model::Transformed sink(writer->body(i), transform, metadata.attributes);
      model::Tee both({&moved, &sink});
      model::Sink& into = moves ? static_cast<model::Sink&>(both) : sink;
      if (auto done = model::pump(source, into, bar.part(source.slabCount())); !done) {
        return report(inInput(done.error(), *input));
      }
      lost.insert(sink.lostAttributes().begin(), sink.lostAttributes().end());
    }
  }
  for (const auto& [name, why] : lost) {
    losses.push_back(fmt::format("attribute '{}': {}", name, why));
  }
  if (auto line = moved.line()) losses.push_back(std::move(*line));
  const auto bytes = finishEdited(*writer, *input);
  if (!bytes) return report(bytes.error());

  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  std::vector<double> matrix;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) matrix.push_back(transform.space(row, column));
  }
  if (options.json) {
    printJson({{"bodies", input->bodies.size()},
               {"axes", options.axes},
               {"matrix", matrix},
               {"time_scale", transform.timeScale},
               {"time_shift", transform.timeShift},
               {"mirrored", transform.mirrors()},
               {"bytes", *bytes},
               {"seconds", seconds},
               {"peak_bytes", peakBytes()}});
  } else {
    print("{}: {}{}\n", options.output, counted(input->bodies.size(), "body", "bodies"),
          transform.mirrors() ? ", mirrored" : "");
    print("  {}, {:.2f} s, peak memory {}\n", sizeText(*bytes), seconds, sizeText(peakBytes()));
  }
  for (const std::string& loss : writer->losses()) losses.push_back(loss);
  return reportLosses(losses);
}

}  // namespace

void addTransform(CLI::App& app, int& exitCode) {
  auto* command = app.add_subcommand(
      "transform", "Move, rotate, scale or mirror a 4D mesh, and change its times");
  auto options = std::make_shared<TransformArguments>();
  command->add_option("FILE", options->input, kT4dFileHelp)->required();
  options->bodies.addTo(*command);
  addT4dOutputOption(*command, options->output);
  command
      ->add_option("--axes", options->axes,
                   "First: axes that become x, y, z, as y-xz, or x, y, z, t, as xtzy or xyz-t")
      ->check(axesInSomeOrder());
  addNumbers(*command, "--scale", options->scale, "Then: scale by one factor, or by one per axis",
             1, 3, "S | SX SY SZ");
  addNumbers(*command, "--rotate", options->rotate,
             "Then: rotate about an axis through the origin, in degrees", 4, 4, "AX AY AZ DEGREES");
  addNumbers(*command, "--matrix", options->matrix,
             "Then: apply a matrix of 3 rows and 4 columns, row by row", 12, 12, "M00 M01 ... M23");
  addNumbers(*command, "--move", options->move, "Then: add to all positions", 3, 3, "DX DY DZ");
  command->add_option("--time-scale", options->timeScale, "Multiply all times by a number above 0")
      ->check(numberAboveZero())
      ->capture_default_str();
  command->add_option("--time-shift", options->timeShift, "Then: add to all times")
      ->check(finiteNumber())
      ->capture_default_str();
  command
      ->add_option("--length-unit", options->lengthUnit,
                   "Set the name of the length unit; coordinates are not converted")
      ->type_name("NAME");
  command
      ->add_option("--time-unit", options->timeUnit,
                   "Set the name of the time unit; times are not converted")
      ->type_name("NAME");
  command->add_option("--up", options->up, "Set the axis that points up; the solid is not rotated")
      ->check(CLI::IsMember({"y", "z"}));
  command->add_option("--space", options->space, "Set the anatomical space; the solid is not moved")
      ->check(CLI::IsMember({"RAS", "LPS", "none"}));
  addCompressionOption(*command, options->compression);
  command->add_flag("--json", options->json, "Print the result as JSON");
  command->footer(
      "Example:\n  t4d transform bolt.t4d --rotate 1 0 0 90 --move 0 0 5 -o upright.t4d");
  command->callback([=, &exitCode] { exitCode = run(*options); });
}

}  // namespace t4d::tools
