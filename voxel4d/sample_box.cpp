#include "voxel4d/sample_box.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <numeric>
#include <type_traits>
#include <utility>

#include <fmt/format.h>

#include "model/parallel.h"

namespace t4d::voxel4d {
namespace {

/// Calls `work` with a null pointer to the type of a sample.
template <class Work>
auto withType(SampleType type, Work work) {
  switch (type) {
    case SampleType::Bool:
    case SampleType::UInt8:
      return work(static_cast<std::uint8_t*>(nullptr));
    case SampleType::Int8:
      return work(static_cast<std::int8_t*>(nullptr));
    case SampleType::Int16:
      return work(static_cast<std::int16_t*>(nullptr));
    case SampleType::UInt16:
      return work(static_cast<std::uint16_t*>(nullptr));
    case SampleType::Int32:
      return work(static_cast<std::int32_t*>(nullptr));
    case SampleType::UInt32:
      return work(static_cast<std::uint32_t*>(nullptr));
    case SampleType::Int64:
      return work(static_cast<std::int64_t*>(nullptr));
    case SampleType::UInt64:
      return work(static_cast<std::uint64_t*>(nullptr));
    case SampleType::Float32:
      return work(static_cast<float*>(nullptr));
    case SampleType::Float64:
      break;
  }
  return work(static_cast<double*>(nullptr));
}

template <class T>
T load(const std::byte* bytes) {
  T sample;
  std::memcpy(&sample, bytes, sizeof sample);
  return sample;
}

template <class T>
double valueOf(T sample, const SampleRule& rule) {
  const auto value = static_cast<double>(sample);
  return rule.slope == 1 && rule.intercept == 0 ? value : rule.slope * value + rule.intercept;
}

/// Samples as whole numbers in the same order: every question about signs and limits becomes a
/// range of keys, and compilers find vector instructions for loops over them. Bytes have unsigned
/// keys and the others signed ones, since these are what SSE2 compares. Floats that are not numbers
/// have the lowest and the highest keys.
template <class T>
struct Keys {
  static constexpr std::size_t kSize = sizeof(T);
  using Signed = std::conditional_t<
      kSize == 1, std::int8_t,
      std::conditional_t<kSize == 2, std::int16_t,
                         std::conditional_t<kSize == 4, std::int32_t, std::int64_t>>>;
  using Key = std::conditional_t<kSize == 1, std::uint8_t, Signed>;
  using Unsigned = std::make_unsigned_t<Signed>;
  static constexpr Unsigned kSignBit = Unsigned(Unsigned{1} << (8 * kSize - 1));

  static Key of(T sample) {
    if constexpr (std::is_floating_point_v<T>) {
      return withoutSign(std::bit_cast<Signed>(sample));
    } else if constexpr (std::is_signed_v<T> == std::is_signed_v<Key>) {
      return static_cast<Key>(sample);
    } else {
      return static_cast<Key>(static_cast<Unsigned>(sample) ^ kSignBit);
    }
  }
  /// The sample with a key.
  static T sample(Key key) {
    if constexpr (std::is_floating_point_v<T>) {
      return std::bit_cast<T>(withoutSign(key));
    } else if constexpr (std::is_signed_v<T> == std::is_signed_v<Key>) {
      return static_cast<T>(key);
    } else {
      return static_cast<T>(static_cast<Unsigned>(key) ^ kSignBit);
    }
  }

 private:
  /// Turns magnitudes with a sign into whole numbers in two's complement less one, and back.
  static Signed withoutSign(Signed bits) {
    return static_cast<Signed>(bits ^ ((bits >> (8 * kSize - 1)) & static_cast<Signed>(~kSignBit)));
  }
};

/// The keys from `first` to `last`; none if `first` is greater.
template <class Key>
struct KeyRange {
  Key first = 1;
  Key last = 0;

  bool contains(Key key) const { return first <= key && key <= last; }
};

/// The keys of `range` for which a claim holds that is false below some key and true from there on,
/// or, if `rising` is false, the other way round.
template <class Key, class Claim>
KeyRange<Key> narrowed(KeyRange<Key> range, bool rising, Claim claim) {
  // The first key for which the claim is what it is at the end of the range.
  Key low = range.first;
  Key high = range.last;
  if (range.first > range.last) return range;
  if (claim(low) == claim(high)) return claim(low) ? range : KeyRange<Key>{};
  while (low < high) {
    const Key middle = std::midpoint(low, high);  // rounded towards `low`
    if (claim(middle) == rising) {
      high = middle;
    } else {
      low = static_cast<Key>(middle + 1);
    }
  }
  return rising ? KeyRange<Key>{low, range.last}
                : KeyRange<Key>{range.first, static_cast<Key>(low - 1)};
}

/// The samples of a type that a rule allows and those that are inside.
template <class T>
struct Judged {
  using Key = typename Keys<T>::Key;
  KeyRange<Key> usable;
  KeyRange<Key> inside;

  explicit Judged(const SampleRule& rule) {
    usable = {std::numeric_limits<Key>::min(), std::numeric_limits<Key>::max()};
    const auto value = [&](Key key) { return valueOf(Keys<T>::sample(key), rule); };
    const auto isFinite = [&] {
      using Limits = std::numeric_limits<T>;
      return KeyRange<Key>{Keys<T>::of(Limits::lowest()), Keys<T>::of(Limits::max())};
    };
    if (rule.mask) {
      inside = insideOfMask(rule, isFinite());
      return;
    }
    // Values rise or fall with samples, and so do all differences from them, rounding included.
    const bool rising = rule.slope >= 0;
    usable = narrowed(isFinite(), rising, [&](Key key) {
      return value(key) >= -rule.largest && std::isgreater(value(key) - rule.iso, -kInfinity);
    });
    usable = narrowed(usable, !rising, [&](Key key) {
      return value(key) <= rule.largest && std::isless(value(key) - rule.iso, kInfinity);
    });
    inside = narrowed(usable, rising == (rule.sign < 0),
                      [&](Key key) { return rule.sign * (value(key) - rule.iso) < 0; });
  }

 private:
  static constexpr double kInfinity = std::numeric_limits<double>::infinity();

  static KeyRange<Key> insideOfMask(const SampleRule& rule, KeyRange<Key> finite) {
    if constexpr (std::is_floating_point_v<T>) {
      const auto label = static_cast<double>(rule.label.value_or(0));
      const auto from = narrowed(finite, true, [&](Key key) {
        return static_cast<double>(Keys<T>::sample(key)) >= label;
      });
      return narrowed(from, false,
                      [&](Key key) { return static_cast<double>(Keys<T>::sample(key)) <= label; });
    } else if (rule.label) {
      if (!std::in_range<T>(*rule.label)) return {};
      const Key key = Keys<T>::of(static_cast<T>(*rule.label));
      return {key, key};
    } else {
      return {1, finite.last};  // bools, whose samples are unsigned bytes
    }
  }
};

/// The axes of a box, the one whose samples are closest first.
std::array<std::size_t, 3> axesInMemory(const SampleBox& box) {
  std::array<std::size_t, 3> axes = {2, 1, 0};
  std::ranges::stable_sort(axes, {}, [&](std::size_t axis) { return std::abs(box.strides[axis]); });
  return axes;
}

std::size_t blocksAlong(std::size_t points) { return (points + kBlockSize - 1) / kBlockSize; }

/// The transpose of 8 x 8 bits: bit j of byte i becomes bit i of byte j.
std::uint64_t transposed(std::uint64_t bits) {
  const auto exchange = [&](unsigned distance, std::uint64_t mask) {
    const std::uint64_t differing = (bits ^ (bits >> distance)) & mask;
    bits ^= differing ^ (differing << distance);
  };
  exchange(7, 0x00AA00AA00AA00AAU);
  exchange(14, 0x0000CCCC0000CCCCU);
  exchange(28, 0x00000000F0F0F0F0U);
  return bits;
}

/// The signs of a block as they lie in memory: byte 8 s + m, bit f is that of the point that is
/// number s, m and f along the slowest, the middle and the fastest axis.
using SignBytes = std::array<std::uint8_t, 64>;

/// Converts the signs of a block to the order of BlockMask; `axes` from the fastest to the slowest.
BlockMask inOrderOfMask(const SignBytes& signs, const std::array<std::size_t, 3>& axes) {
  BlockMask mask{};
  const auto stride = [&](std::size_t axis) { return axes[1] == axis ? std::size_t{1} : 8; };
  if (axes[0] == 2) {
    for (std::size_t x = 0; x < 8; ++x) {
      for (std::size_t y = 0; y < 8; ++y) {
        mask[x] |= std::uint64_t{signs[x * stride(0) + y * stride(1)]} << (8 * y);
      }
    }
    return mask;
  }
  const std::size_t second = 1 - axes[0];  // y if x is the fastest axis, else x
  for (std::size_t i = 0; i < 8; ++i) {
    std::uint64_t bits = 0;
    for (std::size_t z = 0; z < 8; ++z) {
      bits |= std::uint64_t{signs[z * stride(2) + i * stride(second)]} << (8 * z);
    }
    bits = transposed(bits);
    if (second == 0) {
      mask[i] = bits;
      continue;
    }
    for (std::size_t x = 0; x < 8; ++x) mask[x] |= (bits >> (8 * x) & 0xFFU) << (8 * i);
  }
  return mask;
}

/// Finds the signs of the blocks that have the same place along the slowest and the middle axis.
template <class T>
class BlockRow {
 public:
  using Key = typename Keys<T>::Key;

  BlockRow(const SampleBox& box, const SampleRule& rule, const std::array<std::size_t, 3>& axes,
           const Judged<T>& judged)
      : box_(box),
        rule_(rule),
        axes_(axes),
        judged_(judged),
        count_(box.size[axes[0]]),
        signs_(blocksAlong(count_)),
        flags_(kBlockSize * signs_.size()) {}

  /// Appends them to `found`, in the order of the fastest axis.
  void find(std::size_t slow, std::size_t middle, SampleSigns& found) {
    std::ranges::fill(signs_, SignBytes{});
    const auto rowsLeft = [&](std::size_t axis, std::size_t block) {
      return std::min<std::size_t>(kBlockSize, box_.size[axes_[axis]] - kBlockSize * block);
    };
    for (std::size_t s = 0; s < rowsLeft(2, slow); ++s) {
      for (std::size_t m = 0; m < rowsLeft(1, middle); ++m) {
        const auto at = [&](std::size_t axis, std::size_t point) {
          return static_cast<std::ptrdiff_t>(point) * box_.strides[axes_[axis]];
        };
        takeRow(box_.first + at(2, kBlockSize * slow + s) + at(1, kBlockSize * middle + m),
                8 * s + m);
      }
    }
    for (std::size_t fast = 0; fast < signs_.size(); ++fast) {
      const SignBytes& signs = signs_[fast];
      const auto all = [&](std::uint8_t byte) {
        return std::ranges::all_of(signs, [&](std::uint8_t s) { return s == byte; });
      };
      if (all(0)) continue;
      std::array<std::int32_t, 3> coord{};
      coord[axes_[0]] = static_cast<std::int32_t>(fast);
      coord[axes_[1]] = static_cast<std::int32_t>(middle);
      coord[axes_[2]] = static_cast<std::int32_t>(slow);
      const Coord block{coord[0], coord[1], coord[2]};
      if (all(0xFF)) {
        found.tiles.push_back({block, 1, 0});
      } else {
        found.blocks.push_back({block, inOrderOfMask(signs, axes_)});
      }
    }
  }

  /// The least and the largest of all samples so far.
  Key least() const { return least_; }
  Key largest() const { return largest_; }

 private:
  void takeRow(const std::byte* row, std::size_t number) {
    if (box_.strides[axes_[0]] != static_cast<std::ptrdiff_t>(sizeof(T))) {
      gathered_.resize(count_ * sizeof(T));
      for (std::size_t i = 0; i < count_; ++i) {
        std::memcpy(gathered_.data() + i * sizeof(T),
                    row + static_cast<std::ptrdiff_t>(i) * box_.strides[axes_[0]], sizeof(T));
      }
      row = gathered_.data();
    }
    if (rule_.outside && !rule_.mask) {
      if (!flagData(row)) return;
    } else if (!flagAll(row)) {
      return;
    }
    for (std::size_t block = 0; block < signs_.size(); ++block) {
      // Bit 8 i of the flags moves to bit 56 + i.
      constexpr std::uint64_t kGather = 0x0102040810204080U;
      std::uint64_t eight = 0;
      std::memcpy(&eight, flags_.data() + 8 * block, sizeof eight);
      signs_[block][number] = static_cast<std::uint8_t>(eight * kGather >> 56U);
    }
  }

  /// Sets the flags of a row, or returns false if no sample of it is inside.
  bool flagAll(const std::byte* row) {
    // Local, so that compilers see that nothing written changes them.
    const std::size_t count = count_;
    const KeyRange<Key> inside = judged_.inside;
    const auto keyAt = [row](std::size_t i) { return Keys<T>::of(load<T>(row + i * sizeof(T))); };
    Key least = keyAt(0);
    Key largest = least;
    for (std::size_t i = 0; i < count; ++i) {
      least = std::min(least, keyAt(i));
      largest = std::max(largest, keyAt(i));
    }
    least_ = std::min(least_, least);
    largest_ = std::max(largest_, largest);
    if (inside.first > inside.last || largest < inside.first || least > inside.last) return false;
    std::uint8_t* const flags = flags_.data();
    for (std::size_t i = 0; i < count; ++i) {
      flags[i] = static_cast<std::uint8_t>(unsigned{keyAt(i) >= inside.first} &
                                           unsigned{keyAt(i) <= inside.last});
    }
    return true;
  }

  /// Does what flagAll does where some samples are no data.
  bool flagData(const std::byte* row) {
    bool any = false;
    for (std::size_t i = 0; i < count_; ++i) {
      const T sample = load<T>(row + i * sizeof(T));
      flags_[i] = 0;
      if (isNoData(valueOf(sample, rule_), rule_)) continue;
      const Key key = Keys<T>::of(sample);
      least_ = std::min(least_, key);
      largest_ = std::max(largest_, key);
      flags_[i] = static_cast<std::uint8_t>(judged_.inside.contains(key));
      any = any || flags_[i] != 0;
    }
    return any;
  }

  const SampleBox& box_;
  const SampleRule& rule_;
  const std::array<std::size_t, 3>& axes_;
  const Judged<T>& judged_;
  std::size_t count_;
  std::vector<SignBytes> signs_;     // of the blocks
  std::vector<std::uint8_t> flags_;  // of a row: whether samples are inside
  std::vector<std::byte> gathered_;  // a row whose samples do not follow one another
  Key least_ = std::numeric_limits<Key>::max();
  Key largest_ = std::numeric_limits<Key>::min();
};

template <class T>
SampleSigns signsOfType(const SampleBox& box, const SampleRule& rule) {
  using Key = typename Keys<T>::Key;
  const Judged<T> judged(rule);
  const auto axes = axesInMemory(box);
  const std::size_t slow = blocksAlong(box.size[axes[2]]);
  const std::size_t middle = blocksAlong(box.size[axes[1]]);
  struct Found {
    SampleSigns signs;
    Key least = std::numeric_limits<Key>::max();
    Key largest = std::numeric_limits<Key>::min();
  };
  std::vector<Found> found(slow);
  model::forEach(slow, [&](std::size_t s) {
    BlockRow<T> row(box, rule, axes, judged);
    for (std::size_t m = 0; m < middle; ++m) row.find(s, m, found[s].signs);
    found[s].least = row.least();
    found[s].largest = row.largest();
  });
  SampleSigns all;
  const auto field = [&](Key key) {
    return rule.sign * (valueOf(Keys<T>::sample(key), rule) - rule.iso);
  };
  for (Found& part : found) {
    if (part.least > part.largest) continue;  // no data
    all.blocks.insert(all.blocks.end(), part.signs.blocks.begin(), part.signs.blocks.end());
    all.tiles.insert(all.tiles.end(), part.signs.tiles.begin(), part.signs.tiles.end());
    for (const Key key : {part.least, part.largest}) {
      all.usable = all.usable && judged.usable.contains(key);
      if (!rule.mask) all.farthest = std::max(all.farthest, std::abs(field(key)));
    }
  }
  const auto before = [](const auto& a, const auto& b) { return a.coord < b.coord; };
  std::ranges::sort(all.blocks, before);
  std::ranges::sort(all.tiles, before);
  return all;
}

}  // namespace

bool isNoData(double value, const SampleRule& rule) {
  const double outside = *rule.outside;
  if (std::isnan(outside)) return std::isnan(value);
  if (value == outside) return true;
  // The nearest double of a decimal number is neither its nearest float nor a product.
  constexpr double kLargest = std::numeric_limits<float>::max();
  const bool exact = !rule.floats && rule.slope == 1 && rule.intercept == 0;
  return !exact && std::abs(value) <= kLargest && std::abs(outside) <= kLargest &&
         static_cast<float>(value) == static_cast<float>(outside);
}

SampleField::SampleField(const SampleBox& box, const SampleRule& rule, double outside)
    : box_(box), rule_(rule), outside_(outside) {
  value_ = withType(box.type, [](auto* type) -> decltype(value_) {
    using T = std::remove_pointer_t<decltype(type)>;
    return [](const std::byte* sample, const SampleRule& given) {
      return valueOf(load<T>(sample), given);
    };
  });
}

std::size_t SampleField::blocks() const {
  return blocksAlong(box_.size[0]) * blocksAlong(box_.size[1]) * blocksAlong(box_.size[2]);
}

SampleSigns signsOf(const SampleBox& box, const SampleRule& rule) {
  return withType(box.type, [&](auto* type) {
    return signsOfType<std::remove_pointer_t<decltype(type)>>(box, rule);
  });
}

std::optional<std::array<std::size_t, 3>> firstUnusable(const SampleBox& box,
                                                        const SampleRule& rule) {
  return withType(box.type, [&](auto* type) -> std::optional<std::array<std::size_t, 3>> {
    using T = std::remove_pointer_t<decltype(type)>;
    const Judged<T> judged(rule);
    const auto axes = axesInMemory(box);
    std::array<std::size_t, 3> at{};
    for (at[axes[2]] = 0; at[axes[2]] < box.size[axes[2]]; ++at[axes[2]]) {
      for (at[axes[1]] = 0; at[axes[1]] < box.size[axes[1]]; ++at[axes[1]]) {
        for (at[axes[0]] = 0; at[axes[0]] < box.size[axes[0]]; ++at[axes[0]]) {
          const T sample = load<T>(box.at(at));
          if (judged.usable.contains(Keys<T>::of(sample))) continue;
          if (!rule.outside || !isNoData(valueOf(sample, rule), rule)) return at;
        }
      }
    }
    return std::nullopt;
  });
}

Result<SampleRule> arrayRule(SampleType type, const std::string& typeName,
                             const ArrayInside& inside) {
  SampleRule rule;
  rule.label = inside.label;
  rule.mask = inside.label || type == SampleType::Bool;
  if (inside.outside && rule.mask) {
    return invalid("labels and bools say what is outside; no value for it can be given");
  }
  rule.outside = inside.outside;
  if (inside.label) {
    if (isInteger(type)) return rule;
    return invalid(fmt::format("the array is of {}; labels are whole numbers", typeName));
  }
  if (isInteger(type) && !inside.iso) {
    return invalid(
        fmt::format("the array is of {}; expected floats or bool, or whole numbers with an iso "
                    "or a label",
                    typeName));
  }
  if (inside.iso && (rule.mask || !std::isfinite(*inside.iso))) {
    return invalid(fmt::format("the iso value is {}; expected a finite number, and none for bools",
                               *inside.iso));
  }
  if (inside.iso) rule.sign = inside.below ? 1 : -1, rule.iso = *inside.iso;
  rule.floats = fitsFloat32(type);
  return rule;
}

Result<void> checkArraySize(const std::array<std::size_t, 3>& size) {
  std::size_t count = 1;
  for (const std::size_t points : size) {
    if (points == 0 || points > std::numeric_limits<std::int32_t>::max() ||
        count > std::numeric_limits<std::size_t>::max() / points) {
      return invalid(
          fmt::format("the size of the arrays is {} x {} x {}", size[0], size[1], size[2]));
    }
    count *= points;
  }
  return {};
}

Result<SampleSigns> usableSignsOf(const SampleBox& box, const SampleRule& rule) {
  SampleSigns signs = signsOf(box, rule);
  if (signs.usable) return signs;
  const std::array<std::size_t, 3> point = *firstUnusable(box, rule);
  const double value = withType(box.type, [&](auto* type) {
    return static_cast<double>(load<std::remove_pointer_t<decltype(type)>>(box.at(point)));
  });
  return invalid(
      fmt::format("the value at ({}, {}, {}) is {}", point[0], point[1], point[2], value));
}

Result<double> fieldOutside(const SampleRule& rule, double farthest) {
  if (rule.mask) return 0;
  double outside = rule.iso + rule.sign * (farthest > 0 ? farthest : 1);
  if (rule.floats) outside = static_cast<float>(outside);
  const double field = rule.sign * (outside - rule.iso);
  if (field > 0 && std::isfinite(field)) return field;
  return invalid(fmt::format("the values differ from the iso value {} by too little", rule.iso));
}

Frame frameOf(const SampleBox& box, const SampleRule& rule, SampleSigns signs, double outside,
              double time, std::shared_ptr<const void> owner) {
  Frame frame;
  frame.time = time;
  frame.blocks = std::move(signs.blocks);
  frame.tiles = std::move(signs.tiles);
  if (rule.mask) return frame;
  for (InsideTile& tile : frame.tiles) tile.value = -outside;
  frame.outsideValue = outside;
  frame.owner = std::move(owner);
  frame.samples = std::make_shared<SampleField>(box, rule, outside);
  return frame;
}

}  // namespace t4d::voxel4d
