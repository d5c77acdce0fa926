#include <algorithm>
#include <span>
#include <utility>

#include <Eigen/LU>
#include <fmt/format.h>

#include "t4d/mesh.h"

namespace t4d::model {
namespace {

void transform(const Transform& by, std::span<Point4> vertices) {
  for (Point4& vertex : vertices) vertex = by(vertex);
}

/// The map that first applies `first`.
Affine3x4 product(const Affine3x4& then, const Affine3x4& first) {
  Affine3x4 both = then.leftCols<3>() * first;
  both.col(3) += then.col(3);
  return both;
}

void mirror(std::span<Cell> cells) {
  for (Cell& cell : cells) std::swap(cell[2], cell[3]);
}

/// Rows and columns scaled to about 1, so that nothing overflows and no large entry hides others.
Eigen::Matrix3d balanced(Eigen::Matrix3d linear) {
  const auto factor = [](double largest) { return largest > 0 ? largest : 1; };
  for (int row = 0; row < 3; ++row) {
    linear.row(row) /= factor(linear.row(row).cwiseAbs().maxCoeff());
  }
  for (int column = 0; column < 3; ++column) {
    linear.col(column) /= factor(linear.col(column).cwiseAbs().maxCoeff());
  }
  return linear;
}

class TransformedSlab : public StreamedSlab {
 public:
  /// `moved` are the times after the map, `lower` the lower layer if that is known.
  TransformedSlab(const StreamedSlab& slab, const Transform& by, bool mirrors,
                  const TimeSpan& moved, std::span<const Point4> lower)
      : slab_(slab), by_(by), mirrors_(mirrors), lower_(lower) {
    static_cast<VertexCounts&>(*this) = slab;
    time = moved;
    cellCount = slab.cellCount;
  }
  void vertices(std::uint32_t first, std::span<Point4> into) const override {
    slab_.vertices(first, into);
    transform(by_, into);
    if (first >= lower_.size()) return;
    const auto known = lower_.subspan(first, std::min(into.size(), lower_.size() - first));
    std::ranges::copy(known, into.begin());
  }
  void cells(std::uint64_t first, std::span<Cell> into) const override {
    slab_.cells(first, into);
    if (mirrors_) mirror(into);
  }

 private:
  const StreamedSlab& slab_;
  const Transform& by_;
  bool mirrors_;
  std::span<const Point4> lower_;
};

}  // namespace

Point4 Transform::operator()(const Point4& point) const {
  const Point3 moved = posed(space, point.head<3>());
  return {moved[0], moved[1], moved[2], time(point[3])};
}

bool Transform::mirrors() const {
  return Eigen::FullPivLU<Eigen::Matrix3d>(balanced(space.leftCols<3>())).determinant() < 0;
}

/// Judges by the sum of |inverse(j, i) A(i, j)|, the factor by which relative errors of the entries
/// grow in the determinant. It does not depend on the units of the axes before and after.
bool Transform::flattens() const {
  constexpr double kMostGrowth = 1e12;
  const Eigen::Matrix3d linear = balanced(space.leftCols<3>());
  const Eigen::FullPivLU<Eigen::Matrix3d> lu(linear);
  return !lu.isInvertible() ||
         !(lu.inverse().transpose().cwiseProduct(linear).cwiseAbs().sum() <= kMostGrowth);
}

/// The times of a slab after the map.
Result<TimeSpan> Transformed::timesOf(double begin, double end) const {
  const TimeSpan moved = {by_.time(begin), by_.time(end)};
  if (end > begin && !(moved.end > moved.begin)) {
    return invalid(
        fmt::format("the times {} and {} both become {}: doubles are too coarse there; scale or "
                    "shift times less",
                    begin, end, moved.end));
  }
  return moved;
}

Result<void> Transformed::put(const Slab& slab) {
  const auto time = timesOf(slab.timeBegin, slab.timeEnd);
  if (!time) return time.error();
  Slab moved = slab;
  moved.timeBegin = time->begin;
  moved.timeEnd = time->end;
  transform(by_, moved.vertices);
  if (slab.connectivity) {
    moveLayers(slab, moved);
    setMeans(*slab.connectivity, moved.vertices);
  }
  if (slab.connectivity) {
    if (auto done = mapAttributes(moved.attributes, *slab.connectivity); !done) {
      return done.error();
    }
    if (auto done = mapConnectivity(moved); !done) return done;
  }
  return into_.put(moved);
}

/// Returns whether any of them has changed or is gone.
Result<bool> Transformed::mapAttributes(std::vector<Attribute>& attributes,
                                        const Connectivity& connectivity) {
  bool changed = false;
  std::vector<Attribute> kept;
  for (Attribute& attribute : attributes) {
    const auto mapped = mapValues(attribute, meaningOf(attribute, meanings_), by_);
    if (!mapped && mapped.error().code != ErrorCode::Unsupported) {
      return invalid(fmt::format("attribute '{}': {}", attribute.name, mapped.error().message));
    }
    changed = changed || !mapped || *mapped;
    if (!mapped) {
      lost_.emplace(attribute.name, mapped.error().message);
      continue;
    }
    if (*mapped && attribute.domain == Domain::Vertex) setMeans(connectivity, attribute);
    kept.push_back(std::move(attribute));
  }
  attributes = std::move(kept);
  return changed;
}

Result<void> Transformed::mapConnectivity(Slab& moved) {
  if (moved.connectivity != given_) {
    std::vector<Attribute> attributes = moved.connectivity->cellAttributes;
    const auto changed = mapAttributes(attributes, *moved.connectivity);
    if (!changed) return changed.error();
    given_ = moved.connectivity;
    mapped_ = moved.connectivity;
    if (*changed || mirrors_) {
      auto mapped = std::make_shared<Connectivity>(*given_);
      mapped->cellAttributes = std::move(attributes);
      if (mirrors_) mirror(mapped->cells);
      mapped_ = std::move(mapped);
    }
  }
  moved.connectivity = mapped_;
  return {};
}

/// A translation moves the reference, too: far from the origin float32 could not hold it. Any other
/// map leaves it, because its inverse would round.
LayerPose Transformed::poseOf(const LayerPose& given) {
  LayerPose moved = given;
  moved.pose = product(by_.space, given.pose);
  if (by_.space.leftCols<3>() != Eigen::Matrix3d::Identity()) return moved;
  if (given.reference != givenReference_) {
    auto reference = std::make_shared<std::vector<Point3>>(*given.reference);
    for (Point3& point : *reference) point += by_.space.col(3);
    givenReference_ = given.reference;
    movedReference_ = std::move(reference);
  }
  moved.reference = movedReference_;
  moved.pose.col(3) -= given.pose.leftCols<3>() * by_.space.col(3);
  return moved;
}

/// The lower layer after the map if it is the upper one of the last slab and was posed, else
/// nothing. A posed layer is computed from its reference, which rounds otherwise than moving its
/// points.
std::vector<Point4> Transformed::takeLower(std::span<const Point4> given) {
  std::vector<Point4> moved;
  if (!givenUpper_.empty() && std::ranges::equal(given, givenUpper_)) moved.swap(movedUpper_);
  givenUpper_.clear();
  return moved;
}

void Transformed::moveLayers(const Slab& slab, Slab& moved) {
  const std::span<Point4> vertices(moved.vertices);
  std::ranges::copy(takeLower(slab.lowerLayer()), vertices.begin());
  // One rounded to float32 would be rounded again.
  const bool posed = slab.upperPose && !slab.upperPose->float32;
  if (!posed || !slab.upperPose->gives(slab.upperLayer())) {
    moved.upperPose = nullptr;
    return;
  }
  auto pose = std::make_shared<LayerPose>(poseOf(*slab.upperPose));
  const auto upper = vertices.last(slab.connectivity->upperCount);
  for (std::size_t i = 0; i < upper.size(); ++i) upper[i].head<3>() = pose->at(i);
  givenUpper_.assign(slab.upperLayer().begin(), slab.upperLayer().end());
  movedUpper_.assign(upper.begin(), upper.end());
  moved.upperPose = std::move(pose);
}

Result<void> Transformed::putStreamed(const StreamedSlab& slab) {
  const auto time = timesOf(slab.time.begin, slab.time.end);
  if (!time) return time.error();
  std::vector<Point4> given(givenUpper_.empty() ? 0 : slab.lowerCount);
  slab.vertices(0, given);
  const std::vector<Point4> lower = takeLower(given);
  return into_.putStreamed(TransformedSlab(slab, by_, mirrors_, *time, lower));
}

}  // namespace t4d::model
