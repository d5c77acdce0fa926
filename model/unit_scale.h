#pragma once

#include <initializer_list>
#include <span>

#include "t4d/mesh.h"
#include "t4d/surface.h"

/// Products and squares of coordinates leave the range of doubles beyond some 1e50 and below 1e-50.
/// Code that computes them scales its input to a size of about 1, and its results back.
namespace t4d::model {

/// Multiplication of lengths by a power of two, which is exact for all values except those smaller
/// than the largest by a factor of 1e250. Coordinates of ordinary size are not changed.
class UnitScale {
 public:
  UnitScale() = default;  ///< scales by 1
  /// `size` is about the magnitude of the largest coordinate.
  explicit UnitScale(double size);
  static UnitScale of(std::initializer_list<const TriangleMesh*> meshes);
  static UnitScale of(const Bounds3& bounds);

  bool changes() const { return exponent_ != 0; }
  /// Lengths, areas (power 2) and volumes (power 3) in the small unit, and back. Infinite or 0 if a
  /// result is beyond the range of doubles.
  double toUnit(double value, int power = 1) const;
  double fromUnit(double value, int power = 1) const;
  Point3 toUnit(const Point3& point) const;
  Point3 fromUnit(const Point3& point) const;
  /// The mesh in these units, without attributes.
  TriangleMesh toUnit(const TriangleMesh& mesh) const;

 private:
  int exponent_ = 0;  // the size is about 2^exponent
};

/// A 4D mesh with space and time scaled by UnitScale. Attributes are not changed.
class UnitSource : public Source {
 public:
  /// `source` must outlive this view.
  UnitSource(const Source& source, const UnitScale& space, const UnitScale& time)
      : source_(&source), space_(space), time_(time) {}

  std::size_t slabCount() const override { return source_->slabCount(); }
  TimeSpan timeSpan(std::size_t index) const override;
  std::optional<std::uint64_t> cellCount(std::size_t index) const override {
    return source_->cellCount(index);
  }
  Result<std::shared_ptr<const Slab>> slab(std::size_t index) const override;

 private:
  const Source* source_;
  UnitScale space_;
  UnitScale time_;
};

/// The scale for the first slab with a duration in any of the sources. Later slabs are not larger
/// or smaller by a factor that matters. Fails if a source does.
Result<UnitScale> spaceScaleOf(std::span<const Source* const> sources);
UnitScale timeScaleOf(std::span<const Source* const> sources);

}  // namespace t4d::model
