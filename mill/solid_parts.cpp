#include "mill/solid_parts.h"

#include <array>
#include <vector>

#include "model/union_find.h"

namespace t4d::mill {
namespace {

using Run = StockField::Run;

/// The runs of a plane of lines along z, one line after another.
struct Plane {
  std::vector<Run> runs;
  std::vector<std::uint32_t> ends;  // of the runs of each line
  std::uint32_t firstRun = 0;       // the number of the first one in the solid
};

}  // namespace

std::uint64_t countParts(const StockField& field) {
  const auto [sizeX, sizeY, sizeZ] = field.pointCounts();
  std::vector<std::array<std::uint32_t, 2>> joined;
  std::uint32_t count = 0;
  Plane before;
  std::vector<Run> line;
  for (std::int32_t x = 0; x < sizeX; ++x) {
    Plane plane;
    plane.firstRun = count;
    const auto join = [&](const Plane& other, std::int32_t yOther, std::int32_t y) {
      if (yOther < 0 || yOther >= sizeY || other.ends.empty()) return;
      const auto beginOf = [](const Plane& of, std::int32_t at) {
        return at == 0 ? 0U : of.ends[static_cast<std::size_t>(at) - 1];
      };
      std::uint32_t i = beginOf(plane, y);
      std::uint32_t j = beginOf(other, yOther);
      const std::uint32_t iEnd = plane.ends[static_cast<std::size_t>(y)];
      const std::uint32_t jEnd = other.ends[static_cast<std::size_t>(yOther)];
      while (i < iEnd && j < jEnd) {
        const Run& a = plane.runs[i];
        const Run& b = other.runs[j];
        // Neighbours if they overlap or one ends a point before the other begins.
        if (a.begin <= b.end && b.begin <= a.end) {
          joined.push_back({plane.firstRun + i, other.firstRun + j});
        }
        (a.end < b.end ? i : j) += 1;
      }
    };
    for (std::int32_t y = 0; y < sizeY; ++y) {
      field.runsOf(x, y, line);
      plane.runs.insert(plane.runs.end(), line.begin(), line.end());
      plane.ends.push_back(static_cast<std::uint32_t>(plane.runs.size()));
      join(plane, y - 1, y);
      for (const std::int32_t near : {y - 1, y, y + 1}) join(before, near, y);
    }
    count += static_cast<std::uint32_t>(plane.runs.size());
    before = std::move(plane);
  }
  model::UnionFind sets(count);
  std::uint64_t parts = count;
  for (const auto& [a, b] : joined) {
    if (sets.unite(a, b)) --parts;
  }
  return parts;
}

}  // namespace t4d::mill
