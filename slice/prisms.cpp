#include "slice/prisms.h"

#include <algorithm>
#include <array>
#include <optional>
#include <span>

#include <fmt/format.h>

#include "t4d/mesh.h"

namespace t4d::slice {
namespace {

using model::Cell;
using model::Connectivity;
using model::Triangle;

constexpr std::size_t kCells = 14;  // of a prism

/// The triangle with its smallest corner first, facing the same way.
Triangle turned(Triangle triangle) {
  std::rotate(triangle.begin(), std::ranges::min_element(triangle), triangle.end());
  return triangle;
}

/// The face opposite to corner `apex`, so that (face, apex) is oriented as the cell.
Triangle faceOpposite(const Cell& cell, std::size_t apex) {
  Triangle face{};
  std::size_t next = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    if (i != apex) face[next++] = cell[i];
  }
  if (apex % 2 == 0) std::swap(face[1], face[2]);
  return face;
}

class Finder {
 public:
  explicit Finder(const Connectivity& connectivity)
      : step_(connectivity), up_(connectivity.firstUpper()) {}

  Result<Prisms> find() {
    if (step_.lowerCount != step_.upperCount) {
      return no(
          fmt::format("its layers have {} and {} vertices", step_.lowerCount, step_.upperCount));
    }
    if (step_.cells.empty()) return no("it has no cells");
    std::vector<std::uint32_t> numberOf(step_.means.size(), model::kNoIndex);
    std::vector<std::array<std::uint32_t, kCells>> cells;
    std::vector<std::size_t> counts;
    Prisms prisms;
    for (std::uint32_t i = 0; i < step_.cells.size(); ++i) {
      const auto apex = apexOf(step_.cells[i]);
      if (!apex) return no(fmt::format("cell {} is not that of a prism", i));
      std::uint32_t& number = numberOf[step_.cells[i][*apex] - step_.firstMean()];
      if (number == model::kNoIndex) {
        number = static_cast<std::uint32_t>(cells.size());
        cells.emplace_back();
        counts.push_back(0);
      }
      if (counts[number] == kCells) {
        return no(fmt::format("cell {} is one more than the 14 of its prism", i));
      }
      cells[number][counts[number]++] = i;
      prisms.prismOf.push_back(number);
    }
    for (std::size_t i = 0; i < cells.size(); ++i) {
      const auto bottom = counts[i] == kCells ? bottomOf(cells[i]) : std::nullopt;
      if (!bottom) {
        return no(
            fmt::format("the cells about that of number {} are not those of a prism", cells[i][0]));
      }
      const Cell& cell = step_.cells[*bottom];
      prisms.bottoms.push_back(*bottom);
      prisms.triangles.push_back(faceOpposite(cell, *apexOf(cell)));
    }
    return prisms;
  }

 private:
  static Error no(const std::string& why) { return fail(ErrorCode::Unsupported, why); }

  std::span<const std::uint32_t> sourcesOf(std::uint32_t vertex) const {
    if (vertex < step_.firstMean() || vertex >= up_) return {};
    const std::uint32_t mean = vertex - step_.firstMean();
    return std::span(step_.means.sources)
        .subspan(step_.means.offsets[mean],
                 step_.means.offsets[mean + 1] - step_.means.offsets[mean]);
  }

  /// Whether a vertex is the mean of these vertices of the lower layer and their upper copies.
  template <std::size_t N>
  bool isMeanOf(std::uint32_t vertex, const std::array<std::uint32_t, N>& lower) const {
    const auto sources = sourcesOf(vertex);
    if (sources.size() != 2 * N) return false;
    std::array<std::uint32_t, 2 * N> found{};
    std::array<std::uint32_t, 2 * N> expected{};
    std::ranges::copy(sources, found.begin());
    for (std::size_t i = 0; i < N; ++i) {
      expected[i] = lower[i];
      expected[N + i] = up_ + lower[i];
    }
    std::ranges::sort(found);
    std::ranges::sort(expected);
    return found == expected;
  }

  /// The corner that is the mean of a prism.
  std::optional<std::size_t> apexOf(const Cell& cell) const {
    for (std::size_t i = 0; i < 4; ++i) {
      if (sourcesOf(cell[i]).size() == 6) return i;
    }
    return std::nullopt;
  }

  bool isLower(std::uint32_t vertex) const { return vertex < step_.lowerCount; }

  /// The cell that has the triangle below, if these 14 cells are those of its prism.
  std::optional<std::uint32_t> bottomOf(const std::array<std::uint32_t, kCells>& cells) const {
    std::array<Triangle, kCells> found{};
    std::optional<std::uint32_t> bottom;
    std::size_t apex = 0;
    for (std::size_t i = 0; i < kCells; ++i) {
      const Cell& cell = step_.cells[cells[i]];
      apex = *apexOf(cell);
      const Triangle face = faceOpposite(cell, apex);
      if (std::ranges::all_of(face, [&](std::uint32_t v) { return isLower(v); })) bottom = cells[i];
      found[i] = turned(face);
    }
    if (!bottom) return std::nullopt;
    const Cell& below = step_.cells[*bottom];
    apex = *apexOf(below);
    const Triangle a = faceOpposite(below, apex);
    if (!isMeanOf(below[apex], a)) return std::nullopt;

    std::array<Triangle, kCells> expected{a, {up_ + a[0], up_ + a[2], up_ + a[1]}};
    std::size_t next = 2;
    for (std::size_t side = 0; side < 3; ++side) {
      const std::uint32_t from = a[side];
      const std::uint32_t to = a[(side + 1) % 3];
      const auto middle = meanOfSide(found, from, to);
      if (!middle) return std::nullopt;
      expected[next++] = {to, from, *middle};
      expected[next++] = {from, up_ + from, *middle};
      expected[next++] = {up_ + from, up_ + to, *middle};
      expected[next++] = {up_ + to, to, *middle};
    }
    for (Triangle& triangle : expected) triangle = turned(triangle);
    std::ranges::sort(found);
    std::ranges::sort(expected);
    return found == expected ? bottom : std::nullopt;
  }

  std::optional<std::uint32_t> meanOfSide(const std::array<Triangle, kCells>& faces,
                                          std::uint32_t from, std::uint32_t to) const {
    for (const Triangle& face : faces) {
      for (const std::uint32_t vertex : face) {
        if (isMeanOf(vertex, std::array{from, to})) return vertex;
      }
    }
    return std::nullopt;
  }

  const Connectivity& step_;
  std::uint32_t up_;
};

}  // namespace

Result<Prisms> prismsOf(const Connectivity& connectivity) { return Finder(connectivity).find(); }

}  // namespace t4d::slice
