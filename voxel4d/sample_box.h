#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "t4d/frames.h"
#include "voxel4d/sample_type.h"

/// Frames of dense samples, which stay in their own type and order: one pass finds the signs of the
/// blocks, and values are looked up only where an edge of the lattice is crossed.
namespace t4d::voxel4d {

/// Samples at the lattice points (0, 0, 0) to size - 1, in the byte order of this machine.
struct SampleBox {
  SampleType type = SampleType::Float32;
  const std::byte* first = nullptr;         ///< the sample of point (0, 0, 0)
  std::array<std::size_t, 3> size{};        ///< points along x, y, z
  std::array<std::ptrdiff_t, 3> strides{};  ///< bytes to the next sample along x, y, z

  /// The sample of a point, which must be in the box.
  const std::byte* at(const std::array<std::size_t, 3>& point) const {
    const std::byte* sample = first;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      sample += static_cast<std::ptrdiff_t>(point[axis]) * strides[axis];
    }
    return sample;
  }
};

/// The rule that makes a field, negative inside, of samples: sign * (slope * sample + intercept -
/// iso). For a mask, it says which samples are inside.
struct SampleRule {
  double slope = 1;
  double intercept = 0;
  double sign = 1;
  double iso = 0;
  /// Values (slope * sample + intercept) have at most this magnitude.
  double largest = std::numeric_limits<double>::infinity();
  /// Whether values are those of float32, so that crossings are rounded (CrossingGrid).
  bool floats = false;
  /// Samples of this value are no data: they lie outside, like points beyond the box. NaN stands
  /// for every sample that is not a number. Scaled values are compared as float32.
  std::optional<double> outside = {};

  bool mask = false;  ///< no values: what is not 0 is inside, or equals `label`
  std::optional<std::int64_t> label = {};
};

/// Whether a value is that of SampleRule::outside, which must be given.
bool isNoData(double value, const SampleRule& rule);

/// The field of a box of samples.
class SampleField {
 public:
  /// `outside`: the field at points that are not in the box, or whose samples are no data.
  SampleField(const SampleBox& box, const SampleRule& rule, double outside);

  /// The sample at a point of a block, by its index in the order of BlockMask.
  double at(const Coord& block, unsigned index) const {
    const std::array<std::int64_t, 3> point = {
        std::int64_t{block.x} * kBlockSize + (index >> 6U),
        std::int64_t{block.y} * kBlockSize + (index >> 3U & 7U),
        std::int64_t{block.z} * kBlockSize + (index & 7U)};
    const std::byte* sample = box_.first;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      // Negative coordinates are large ones here.
      if (static_cast<std::uint64_t>(point[axis]) >= box_.size[axis]) return outside_;
      sample += point[axis] * box_.strides[axis];
    }
    const double value = value_(sample, rule_);
    if (rule_.outside && isNoData(value, rule_)) return outside_;
    return rule_.sign * (value - rule_.iso);
  }
  bool hasFloats() const { return rule_.floats; }
  /// The number of blocks that the box reaches.
  std::size_t blocks() const;

 private:
  SampleBox box_;
  SampleRule rule_;
  double outside_;
  double (*value_)(const std::byte* sample, const SampleRule& rule);
};

/// The blocks of a box, and what their samples are.
struct SampleSigns {
  std::vector<Block> blocks;      ///< partly inside, without values; increasing by coord
  std::vector<InsideTile> tiles;  ///< blocks that are all inside; increasing by coord
  /// Whether all values are finite and no larger than the rule allows. If not, the rest is wrong.
  bool usable = true;
  /// The largest magnitude of the field, without samples that are no data; 0 for a mask.
  double farthest = 0;
};

SampleSigns signsOf(const SampleBox& box, const SampleRule& rule);

/// The first point, in the order in memory, whose value the rule does not allow.
std::optional<std::array<std::size_t, 3>> firstUnusable(const SampleBox& box,
                                                        const SampleRule& rule);

/// The choice of values that are inside an array.
struct ArrayInside {
  std::optional<double> iso = {};  ///< values above this; without it and `label`, those below 0
  bool below = false;              ///< values below `iso`, not above
  std::optional<std::int64_t> label = {};  ///< whole numbers that equal this
  std::optional<double> outside = {};      ///< as SampleRule::outside
};

/// The rule for an array in memory. Bools that are True are inside. `typeName` is what errors call
/// the type. Fails for labels of numbers that are not whole, whole numbers without `iso` or
/// `label`, `iso` with bools or not finite, and `outside` with bools or a label.
Result<SampleRule> arrayRule(SampleType type, const std::string& typeName,
                             const ArrayInside& inside);

/// For arrays in memory: fails for sizes of zero, or of more than 2^31 - 1 points along an axis.
Result<void> checkArraySize(const std::array<std::size_t, 3>& size);
/// signsOf; fails for a value that is not usable, and says where it is.
Result<SampleSigns> usableSignsOf(const SampleBox& box, const SampleRule& rule);

/// The field beyond a box: as far from the surface as its farthest value. Fails if the type of the
/// values cannot tell that from the iso value.
Result<double> fieldOutside(const SampleRule& rule, double farthest);

/// The frame of a box with usable samples. `owner` keeps the samples alive; masks let go of it.
Frame frameOf(const SampleBox& box, const SampleRule& rule, SampleSigns signs, double outside,
              double time, std::shared_ptr<const void> owner);

}  // namespace t4d::voxel4d
