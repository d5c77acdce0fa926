#pragma once

#include "model/units.h"
#include "t4d/mesh.h"

namespace t4d::model {

/// A 4D mesh in other units: the slabs of `source` with every coordinate and time converted when
/// they are requested. Connectivity and attributes stay as they are.
class ConvertedSource : public Source {
 public:
  /// `source` must outlive this view.
  ConvertedSource(const Source& source, const UnitConversion& length, const UnitConversion& time)
      : source_(&source), length_(length), time_(time) {}

  std::size_t slabCount() const override { return source_->slabCount(); }
  TimeSpan timeSpan(std::size_t index) const override;
  std::optional<std::uint64_t> cellCount(std::size_t index) const override {
    return source_->cellCount(index);
  }
  Result<std::shared_ptr<const Slab>> slab(std::size_t index) const override;

 private:
  const Source* source_;
  UnitConversion length_;
  UnitConversion time_;
};

}  // namespace t4d::model
