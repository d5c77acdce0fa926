#include "model/unit_scale.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace t4d::model {

UnitScale::UnitScale(double size) {
  // The product of six lengths a trillion times as large or as small is within range.
  constexpr int kOrdinary = 64;
  int exponent = 0;
  if (std::isfinite(size) && size > 0) std::frexp(size, &exponent);
  if (std::abs(exponent) > kOrdinary) exponent_ = exponent;
}

UnitScale UnitScale::of(std::initializer_list<const TriangleMesh*> meshes) {
  Bounds3 bounds;
  for (const TriangleMesh* mesh : meshes) bounds.add(boundsOf(*mesh));
  return of(bounds);
}

UnitScale UnitScale::of(const Bounds3& bounds) {
  if (bounds.empty()) return {};
  return UnitScale(bounds.min.cwiseAbs().cwiseMax(bounds.max.cwiseAbs()).maxCoeff());
}

double UnitScale::toUnit(double value, int power) const {
  return changes() ? std::ldexp(value, -power * exponent_) : value;
}

double UnitScale::fromUnit(double value, int power) const {
  return changes() ? std::ldexp(value, power * exponent_) : value;
}

Point3 UnitScale::toUnit(const Point3& point) const {
  return point.unaryExpr([this](double value) { return toUnit(value); });
}

Point3 UnitScale::fromUnit(const Point3& point) const {
  return point.unaryExpr([this](double value) { return fromUnit(value); });
}

TriangleMesh UnitScale::toUnit(const TriangleMesh& mesh) const {
  TriangleMesh scaled{mesh.vertices, mesh.triangles, {}};
  for (Point3& vertex : scaled.vertices) vertex = toUnit(vertex);
  return scaled;
}

TimeSpan UnitSource::timeSpan(std::size_t index) const {
  const TimeSpan span = source_->timeSpan(index);
  return {time_.toUnit(span.begin), time_.toUnit(span.end)};
}

Result<std::shared_ptr<const Slab>> UnitSource::slab(std::size_t index) const {
  const auto read = source_->slab(index);
  if (!read) return read.error();
  auto slab = std::make_shared<Slab>(**read);
  slab->upperPose = nullptr;
  slab->timeBegin = time_.toUnit(slab->timeBegin);
  slab->timeEnd = time_.toUnit(slab->timeEnd);
  for (Point4& vertex : slab->vertices) {
    vertex.head<3>() = space_.toUnit(Point3(vertex.head<3>()));
    vertex[3] = time_.toUnit(vertex[3]);
  }
  return slab;
}

Result<UnitScale> spaceScaleOf(std::span<const Source* const> sources) {
  Bounds3 bounds;
  for (const Source* source : sources) {
    for (std::size_t i = 0; i < source->slabCount(); ++i) {
      const TimeSpan span = source->timeSpan(i);
      if (!(span.end > span.begin)) continue;
      const auto known = source->bounds(i);
      if (known) {
        bounds.add(*known);
        break;
      }
      const auto slab = source->slab(i);
      if (!slab) return slab.error();
      for (const Point4& vertex : (*slab)->vertices) bounds.add(Point3(vertex.head<3>()));
      break;
    }
  }
  return UnitScale::of(bounds);
}

UnitScale timeScaleOf(std::span<const Source* const> sources) {
  double most = 0;
  for (const Source* source : sources) {
    const TimeSpan span = timeSpanOf(*source);
    most = std::max({most, std::abs(span.begin), std::abs(span.end)});
  }
  return UnitScale(most);
}

}  // namespace t4d::model
