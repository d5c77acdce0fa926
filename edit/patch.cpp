#include "edit/patch.h"

#include <algorithm>
#include <limits>
#include <numeric>

#include <fmt/format.h>

#include "edit/cell_shape.h"
#include "model/attribute_rows.h"
#include "model/cell_normal.h"

namespace t4d::edit {
namespace {

using model::Attribute;
using model::Cell;
using model::Connectivity;
using model::Domain;
using model::Point4;
using model::Slab;

/// Appends the rows of an attribute from number `first` on to the one of the same name and domain,
/// or makes it.
void appendRows(const Attribute& from, std::size_t first, std::vector<Attribute>& to) {
  const auto found = std::ranges::find_if(
      to, [&](const Attribute& one) { return one.name == from.name && one.domain == from.domain; });
  Attribute& into =
      found != to.end()
          ? *found
          : to.emplace_back(Attribute{from.name, from.domain, from.type, from.components, {}});
  into.values.insert(into.values.end(), from.row(first), from.values.data() + from.values.size());
}

void append(const Slab& slab, double timeScale, Patch& patch) {
  const Connectivity& connectivity = *slab.connectivity;
  // The lower layer is there already, but for the first slab.
  const std::uint32_t known = patch.vertices.empty() ? 0 : connectivity.lowerCount;
  const std::uint32_t shift = patch.vertexCount() - known;
  for (std::uint32_t i = known; i < connectivity.vertexCount; ++i) {
    Point4& vertex = patch.vertices.emplace_back(slab.vertices[i]);
    vertex[3] *= timeScale;
  }
  for (const Cell& cell : connectivity.cells) {
    patch.cells.push_back({cell[0] + shift, cell[1] + shift, cell[2] + shift, cell[3] + shift});
  }
  for (const Attribute& attribute : connectivity.cellAttributes) {
    appendRows(attribute, 0, patch.attributes);
  }
  for (const Attribute& attribute : slab.attributes) {
    appendRows(attribute, attribute.domain == Domain::Vertex ? known : 0, patch.attributes);
  }
}

void setQuadrics(Patch& patch) {
  patch.quadrics.resize(patch.vertices.size());
  for (const Cell& cell : patch.cells) {
    const Eigen::Vector4d normal = model::cellNormal(cornersOf(patch.vertices, cell));
    const double size = normal.norm();
    if (!(size > 0)) continue;
    for (const std::uint32_t corner : cell) {
      patch.quadrics[corner].addHyperplane(normal / size, size / 6);
    }
  }
}

template <class Item>
std::vector<Item> rowsOf(const std::vector<Item>& items, std::span<const std::uint32_t> rows) {
  std::vector<Item> some;
  some.reserve(rows.size());
  for (const std::uint32_t row : rows) some.push_back(items[row]);
  return some;
}

std::vector<std::uint32_t> numbersFrom(std::uint32_t begin, std::uint32_t end) {
  std::vector<std::uint32_t> numbers(end - begin);
  std::iota(numbers.begin(), numbers.end(), begin);
  return numbers;
}

}  // namespace

Result<Patch> patchOf(std::span<const std::shared_ptr<const Slab>> slabs, double timeScale) {
  Patch patch;
  for (const auto& slab : slabs) {
    const std::uint32_t lower = slab->connectivity->lowerCount;
    if (!patch.vertices.empty() && lower != patch.upperCount) {
      return invalid(
          fmt::format("a lower layer has {} vertices, the upper layer of the slab before "
                      "has {}",
                      lower, patch.upperCount));
    }
    if (patch.vertices.empty()) patch.lowerCount = lower;
    append(*slab, timeScale, patch);
    patch.upperCount = slab->connectivity->upperCount;
  }
  patch.timeBegin = slabs.front()->timeBegin * timeScale;
  patch.timeEnd = slabs.back()->timeEnd * timeScale;
  setQuadrics(patch);
  patch.reaches.assign(patch.vertices.size(), std::numeric_limits<double>::infinity());
  return patch;
}

Patch joined(Patch lower, const Patch& upper) {
  Patch whole = std::move(lower);
  const std::uint32_t shift = whole.firstUpper();
  const std::uint32_t layer = whole.upperCount;
  whole.seamBegin = shift;
  whole.seamEnd = whole.vertexCount();
  whole.cellsBefore = static_cast<std::uint32_t>(whole.cells.size());
  whole.upperCount = upper.upperCount;
  whole.timeEnd = upper.timeEnd;
  for (std::uint32_t i = 0; i < layer; ++i) {
    whole.quadrics[shift + i] += upper.quadrics[i];
    double& reach = whole.reaches[shift + i];
    reach = std::min(reach, upper.reaches[i]);
  }
  const auto appendRest = [&](auto& to, const auto& from) {
    to.insert(to.end(), from.begin() + layer, from.end());
  };
  appendRest(whole.vertices, upper.vertices);
  appendRest(whole.quadrics, upper.quadrics);
  appendRest(whole.reaches, upper.reaches);
  for (const auto& [point, cell] : upper.samples) {
    whole.samples.push_back({point, cell + whole.cellsBefore});
  }
  for (const Cell& cell : upper.cells) {
    whole.cells.push_back({cell[0] + shift, cell[1] + shift, cell[2] + shift, cell[3] + shift});
  }
  for (const Attribute& attribute : upper.attributes) {
    appendRows(attribute, attribute.domain == Domain::Vertex ? layer : 0, whole.attributes);
  }
  return whole;
}

void selectFrom(Patch& patch, std::span<const std::uint32_t> vertices,
                std::span<const std::uint32_t> cells) {
  const auto countBelow = [](std::span<const std::uint32_t> numbers, std::uint32_t limit) {
    return static_cast<std::uint32_t>(std::ranges::lower_bound(numbers, limit) - numbers.begin());
  };
  const std::uint32_t firstUpper = countBelow(vertices, patch.firstUpper());
  patch.lowerCount = countBelow(vertices, patch.lowerCount);
  patch.upperCount = static_cast<std::uint32_t>(vertices.size()) - firstUpper;
  patch.seamBegin = countBelow(vertices, patch.seamBegin);
  patch.seamEnd = countBelow(vertices, patch.seamEnd);
  patch.cellsBefore = countBelow(cells, patch.cellsBefore);
  std::vector<std::uint32_t> number(patch.vertices.size());
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    number[vertices[i]] = static_cast<std::uint32_t>(i);
  }
  std::erase_if(patch.samples, [&](Sample& sample) {
    const auto found = std::ranges::lower_bound(cells, sample.cell);
    if (found == cells.end() || *found != sample.cell) return true;
    sample.cell = static_cast<std::uint32_t>(found - cells.begin());
    return false;
  });
  patch.vertices = rowsOf(patch.vertices, vertices);
  patch.quadrics = rowsOf(patch.quadrics, vertices);
  patch.reaches = rowsOf(patch.reaches, vertices);
  patch.cells = rowsOf(patch.cells, cells);
  for (Cell& cell : patch.cells) {
    for (std::uint32_t& corner : cell) corner = number[corner];
  }
  model::selectRows(patch.attributes, Domain::Vertex, vertices);
  model::selectRows(patch.attributes, Domain::Cell, cells);
}

PatchPair parted(const Patch& whole) {
  PatchPair parts{whole, whole};
  const std::uint32_t layer = whole.seamEnd - whole.seamBegin;
  const double seamTime = whole.vertices[whole.seamBegin][3];
  const auto cells = static_cast<std::uint32_t>(whole.cells.size());
  selectFrom(parts.lower, numbersFrom(0, whole.seamEnd), numbersFrom(0, whole.cellsBefore));
  selectFrom(parts.upper, numbersFrom(whole.seamBegin, whole.vertexCount()),
             numbersFrom(whole.cellsBefore, cells));
  for (Patch* part : {&parts.lower, &parts.upper}) part->forgetSeam();
  parts.lower.upperCount = layer;
  parts.upper.lowerCount = layer;
  parts.lower.timeEnd = seamTime;
  parts.upper.timeBegin = seamTime;
  return parts;
}

Slab slabOf(Patch patch, double timeScale) {
  Slab slab;
  slab.timeBegin = patch.timeBegin / timeScale;
  slab.timeEnd = patch.timeEnd / timeScale;
  auto connectivity = std::make_shared<Connectivity>();
  connectivity->vertexCount = patch.vertexCount();
  connectivity->lowerCount = patch.lowerCount;
  connectivity->upperCount = patch.upperCount;
  connectivity->cells = std::move(patch.cells);
  for (Point4& vertex : patch.vertices) vertex[3] /= timeScale;
  slab.vertices = std::move(patch.vertices);
  slab.attributes = std::move(patch.attributes);
  slab.connectivity = std::move(connectivity);
  return slab;
}

}  // namespace t4d::edit
