#pragma once

#include <initializer_list>
#include <span>

#include "t4d/model/slab.h"
#include "t4d/model/triangle_mesh.h"

/// Products and squares of coordinates leave the range of doubles beyond some 1e50 and below
/// 1e-50. What computes with them scales its input to a size of about 1, and its results back.
namespace t4d::model {

/// Multiplication of lengths by a power of two, which is exact for all that is not smaller by a
/// factor of 1e250 than the largest. Coordinates of ordinary size stay as they are.
class UnitScale {
 public:
  UnitScale() = default;  ///< leaves all as it is
  /// `size` is about that of the largest coordinate.
  explicit UnitScale(double size);
  static UnitScale of(std::initializer_list<const TriangleMesh*> meshes);
  static UnitScale of(const Bounds3& bounds);

  bool changes() const { return exponent_ != 0; }
  /// Lengths, areas (power 2) and volumes (power 3) in the small unit, and back. Infinite or 0
  /// where a result is beyond the range of doubles.
  double toUnit(double value, int power = 1) const;
  double fromUnit(double value, int power = 1) const;
  Point3 toUnit(const Point3& point) const;
  Point3 fromUnit(const Point3& point) const;
  /// Without attributes.
  TriangleMesh toUnit(const TriangleMesh& mesh) const;

 private:
  int exponent_ = 0;  // of two: the size
};

/// A 4D mesh in such units of space and of time. Attributes stay as they are.
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

/// The scale of the first slab of some sources in which something lasts: those after it are not
/// larger or smaller by a factor that matters. Fails if a source does.
Result<UnitScale> spaceScaleOf(std::span<const Source* const> sources);
UnitScale timeScaleOf(std::span<const Source* const> sources);

}  // namespace t4d::model
