#include "mesh4d/motion_keys.h"

#include <algorithm>
#include <numeric>

#include <fmt/format.h>

#include "t4d/mesh.h"

namespace t4d::mesh4d {

MotionKeys::MotionKeys(const model::TriangleMesh& mesh, const model::Motion& motion,
                       const std::vector<std::uint64_t>& steps)
    : mesh_(mesh), motion_(motion), stepsUpTo_(steps.size()) {
  std::partial_sum(steps.begin(), steps.end(), stepsUpTo_.begin());
}

MotionKeys::Place MotionKeys::placeOf(std::uint64_t key) const {
  const auto found = std::lower_bound(stepsUpTo_.begin(), stepsUpTo_.end(), key);
  const std::uint64_t before = found == stepsUpTo_.begin() ? 0 : *(found - 1);
  return {static_cast<std::size_t>(found - stepsUpTo_.begin()), key - before, *found - before};
}

double MotionKeys::time(std::uint64_t key) const {
  const auto [segment, step, steps] = placeOf(key);
  return model::dividedTime(
      {motion_.segments[segment].timeBegin, motion_.segments[segment].timeEnd}, step, steps);
}

std::optional<model::Affine3x4> MotionKeys::pose(std::uint64_t key) const {
  const auto [segment, step, steps] = placeOf(key);
  return motion_.segments[segment]
      .at(static_cast<double>(step) / static_cast<double>(steps))
      .matrix();
}

Result<void> MotionKeys::positions(std::uint64_t key, std::span<model::Point3> into) const {
  if (key > 0 && !(time(key) > time(key - 1))) {
    const auto [index, step, steps] = placeOf(key);
    const model::Segment& segment = motion_.segments[index];
    return invalid(
        fmt::format("segment {} lasts {} from time {} on: doubles are too coarse there for {} "
                    "steps; start at a smaller time, or allow larger steps",
                    index, segment.timeEnd - segment.timeBegin, segment.timeBegin, steps),
        {}, Remedy::Motion);
  }
  const model::Affine3x4 matrix = *pose(key);
  std::transform(mesh_.vertices.begin(), mesh_.vertices.end(), into.begin(),
                 [&](const model::Point3& point) { return model::posed(matrix, point); });
  return {};
}

}  // namespace t4d::mesh4d
