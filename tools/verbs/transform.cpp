#include "tools/verbs/transform.h"

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
#include "tools/verbs/members.h"
#include "tools/verbs/moved_bounds.h"
#include "tools/verbs/origin.h"
#include "tools/verbs/space_time_map.h"

namespace t4d::verbs {
namespace {

Result<void> checkMap(const TransformOptions& options) {
  const auto isZero = [](double number) { return number == 0; };
  if (!options.axes.empty() && !areAxes(options.axes)) {
    return fail(ErrorCode::Options, fmt::format("'{}' is not an order of axes", options.axes));
  }
  if (options.scale && std::ranges::any_of(*options.scale, isZero)) {
    return fail(ErrorCode::Options, "a scale of 0 leaves no solid");
  }
  if (options.rotate && std::ranges::all_of(options.rotate->axis, isZero)) {
    return fail(ErrorCode::Options, "the axis of the rotation is 0 0 0");
  }
  if (!(options.timeScale > 0)) {
    return fail(ErrorCode::Options, "times can only be scaled by a number above 0");
  }
  if (!options.matrix) return {};
  TransformOptions alone;
  alone.matrix = options.matrix;
  if (!transformOf(alone).flattens()) return {};
  return fail(ErrorCode::Options,
              "the matrix leaves no solid: its determinant is 0, up to rounding");
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
  if (auto good = checkMap(options); !good) return good.error();
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

}  // namespace t4d::verbs
