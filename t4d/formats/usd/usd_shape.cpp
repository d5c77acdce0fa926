#include "t4d/formats/usd/usd_shape.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include <fmt/format.h>

#include "t4d/formats/animation/file_points.h"
#include "t4d/formats/text/text_scanner.h"
#include "t4d/formats/triangle/mesh_builder.h"

namespace t4d::formats {
namespace {

using model::Point3;

/// The values of a property over time, each as a sample or as the only one.
std::vector<UsdSample> valuesOf(const UsdPrim& prim, std::string_view name) {
  const UsdProperty* property = prim.property(name);
  if (property == nullptr) return {};
  std::vector<UsdSample> values = property->samples;
  if (values.empty() && property->value) values.push_back({0, *property->value});
  std::erase_if(values, [](const UsdSample& sample) { return sample.value == "None"; });
  return values;
}

/// Those that a time code needs: the last one up to it, or the first, and, for what is
/// interpolated, the one after it.
void keepAt(double timeCode, bool interpolated, std::vector<UsdSample>& values) {
  auto behind = std::ranges::upper_bound(values, timeCode, {}, &UsdSample::timeCode);
  const auto first = behind == values.begin() ? behind : behind - 1;
  const bool between = behind != values.begin() && behind != values.end() &&
                       first->timeCode != timeCode && interpolated;
  const std::vector<UsdSample> kept(first, first + (between ? 2 : 1));
  values = kept;
}

/// Whole numbers that are the same in all samples.
Result<std::vector<std::uint64_t>> constantNumbers(const UsdDocument& document, const UsdPrim& prim,
                                                   std::string_view name,
                                                   std::optional<double> timeCode) {
  std::vector<UsdSample> values = valuesOf(prim, name);
  if (values.empty()) {
    return invalid(fmt::format("Mesh {} has no {}", inQuotes(prim.name), name),
                   document.where(prim.name));
  }
  if (timeCode) keepAt(*timeCode, false, values);
  std::vector<double> first;
  for (const UsdSample& sample : values) {
    if (sample.value == values.front().value && !first.empty()) continue;
    auto numbers = usdNumbers(document, sample.value, 1, UsdShapeOf::Array, "int");
    if (!numbers) return numbers.error();
    if (first.empty()) first = *numbers;
    if (*numbers == first) continue;
    return fail(ErrorCode::Unsupported,
                fmt::format("the faces of Mesh {} change at time code {}: a solid that is swept "
                            "keeps its faces. Meshes of single frames can be woven",
                            inQuotes(prim.name), sample.timeCode),
                document.where(sample.value));
  }
  std::vector<std::uint64_t> whole;
  whole.reserve(first.size());
  for (const double number : first) {
    constexpr double kMostInt = 2147483647;
    if (!(number >= 0 && number <= kMostInt) || number != std::floor(number)) {
      return invalid(fmt::format("{} has {}, expected whole numbers from 0", name, number),
                     document.where(values.front().value));
    }
    whole.push_back(static_cast<std::uint64_t>(number));
  }
  return whole;
}

}  // namespace

Result<UsdShape::Points> UsdShape::filePoints(std::string_view text) const {
  const auto numbers = usdNumbers(*document_, text, 3, UsdShapeOf::Array, type_);
  if (!numbers) return numbers.error();
  Points points(numbers->size() / 3);
  for (std::size_t i = 0; i < points.size(); ++i) {
    points[i] = Eigen::Map<const Point3>(&(*numbers)[3 * i]);
    if (points[i].allFinite()) continue;
    return invalid(fmt::format("point {} (counted from 0) is ({}, {}, {}), expected finite "
                               "coordinates",
                               i, points[i].x(), points[i].y(), points[i].z()),
                   document_->where(text));
  }
  return points;
}

Result<UsdShape::Points> UsdShape::vertices(std::string_view text) const {
  const auto points = filePoints(text);
  if (!points) return points.error();
  if (points->size() != file_.vertexOf.size()) {
    return invalid(
        fmt::format("{} points, and {} in the first sample", points->size(), file_.vertexOf.size()),
        document_->where(text));
  }
  Points placed(vertexCount_);
  if (auto done = placeVertices(file_, *points, placed, {}); !done) {
    done.error().where = document_->where(text);  // which takes time to find
    return done.error();
  }
  return placed;
}

Result<LoadedMesh> UsdShape::readFaces(const UsdScene& scene, When when) {
  const UsdPrim& prim = *placed_.prim;
  std::optional<double> code;
  if (when == When::AtFirst) code = scene.beginCode;
  const auto counts = constantNumbers(*document_, prim, "faceVertexCounts", code);
  if (!counts) return counts.error();
  const auto corners = constantNumbers(*document_, prim, "faceVertexIndices", code);
  if (!corners) return corners.error();
  const UsdProperty* orientation = prim.property("orientation");
  const bool leftHanded = orientation != nullptr && orientation->value &&
                          usdUnquoted(*orientation->value) == "leftHanded";
  const std::vector<UsdSample> holes = valuesOf(prim, "holeIndices");
  if (!holes.empty() && holes.front().value != "[]") {
    return fail(ErrorCode::Unsupported, "holes (holeIndices) are not read; remove the faces",
                document_->where(holes.front().value));
  }
  std::vector<UsdSample> points = valuesOf(prim, "points");
  if (code && !points.empty()) keepAt(*code, true, points);
  if (points.empty()) {
    return invalid(fmt::format("Mesh {} has no points", inQuotes(prim.name)),
                   document_->where(prim.name));
  }
  type_ = prim.property("points")->type;
  for (const UsdSample& sample : points) {
    samples_.push_back({scene.seconds(sample.timeCode), sample.value});
  }
  const auto first = filePoints(samples_.front().text);
  if (!first) return first.error();
  const auto where = [&] {
    return document_->where(valuesOf(prim, "faceVertexIndices").front().value);
  };
  MeshBuilder builder(document_->file->path.string(), [&](auto) { return where(); });
  for (const Point3& point : *first) {
    if (auto added = builder.addPoint(point, 0); !added) return added.error();
  }
  std::span<const std::uint64_t> left(*corners);
  std::vector<std::uint64_t> face;
  for (const std::uint64_t count : *counts) {
    if (count > left.size()) {
      return invalid(fmt::format("faceVertexCounts adds up to more than the {} faceVertexIndices",
                                 corners->size()),
                     where());
    }
    face.assign(left.begin(), left.begin() + static_cast<std::ptrdiff_t>(count));
    if (leftHanded) std::ranges::reverse(face);
    if (auto added = builder.addPolygon(face, 0); !added) return added.error();
    left = left.subspan(count);
  }
  if (!left.empty()) {
    return invalid(fmt::format("faceVertexCounts adds up to {}, and there are {} faceVertexIndices",
                               corners->size() - left.size(), corners->size()),
                   where());
  }
  return std::move(builder).finish();
}

Result<std::shared_ptr<const UsdShape>> UsdShape::read(const UsdScene& scene,
                                                       const UsdPlacedMesh& placed, When when,
                                                       LoadedMesh& mesh) {
  std::shared_ptr<UsdShape> shape(new UsdShape(scene.document, scene.layer, placed));
  auto loaded = shape->readFaces(scene, when);
  if (!loaded) return loaded.error();
  mesh = std::move(*loaded);
  shape->file_ = mesh.points;
  shape->vertexCount_ = mesh.mesh.vertices.size();
  std::string_view before;
  for (const Sample& sample : shape->samples_) {
    if (sample.text == before) continue;
    before = sample.text;
    if (const auto checked = shape->vertices(sample.text); !checked) return checked.error();
  }
  return shape;
}

std::vector<double> UsdShape::times() const {
  std::set<double> times;
  if (deforms()) {
    for (const Sample& sample : samples_) times.insert(sample.time);
  }
  for (const UsdXformOp& op : placed_.ops) {
    if (op.moves()) times.insert(op.times().begin(), op.times().end());
  }
  return {times.begin(), times.end()};
}

std::shared_ptr<const UsdShape::Points> UsdShape::at(std::size_t sample) const {
  const std::lock_guard lock(mutex_);
  auto& kept = kept_[sample % kept_.size()];
  if (kept.second == nullptr || kept.first != sample) {
    kept = {sample, std::make_shared<const Points>(*vertices(samples_[sample].text))};
  }
  return kept.second;
}

UsdShape::Points UsdShape::pointsAt(double time) const {
  const auto behind = std::ranges::upper_bound(samples_, time, {}, &Sample::time);
  if (behind == samples_.begin()) return *at(0);
  const auto before = static_cast<std::size_t>(behind - samples_.begin()) - 1;
  if (behind == samples_.end() || samples_[before].time == time) return *at(before);
  const double fraction = (time - samples_[before].time) / (behind->time - samples_[before].time);
  const auto from = at(before);
  const auto to = at(before + 1);
  Points points(from->size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    points[i] = (*from)[i] + fraction * ((*to)[i] - (*from)[i]);
  }
  return points;
}

void UsdShape::place(double time, bool /*atEnd*/, std::span<Point3> into) const {
  const Points points = pointsAt(time);
  const model::Affine3x4 world = placed_.world(time).matrix().topRows<3>();
  if (world == model::Affine3x4::Identity()) {
    std::ranges::copy(points, into.begin());
    return;
  }
  for (std::size_t i = 0; i < points.size(); ++i) into[i] = model::posed(world, points[i]);
}

double UsdShape::accelerationBound(double begin, double end) const {
  // Points move straight, and so they do in coordinates that do not move.
  if (!placed_.moves()) return 0;
  const Points from = pointsAt(begin);
  const Points to = pointsAt(end);
  CurveBound bound;
  for (std::size_t i = 0; i < from.size(); ++i) {
    bound.value = std::max({bound.value, from[i].norm(), to[i].norm()});
    bound.first = std::max(bound.first, (to[i] - from[i]).norm() / (end - begin));
  }
  for (auto op = placed_.ops.rbegin(); op != placed_.ops.rend(); ++op) {
    bound = op->bound(bound, begin, end);
  }
  return bound.second;
}

}  // namespace t4d::formats
