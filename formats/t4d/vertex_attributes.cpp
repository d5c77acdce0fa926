#include "formats/t4d/vertex_attributes.h"

#include <algorithm>
#include <span>
#include <string>
#include <tuple>

#include <fmt/format.h>

namespace t4d::formats {

using model::Attribute;
using model::Connectivity;

namespace {

bool sameKind(const Attribute& a, const Attribute& b) {
  return std::tie(a.name, a.type, a.components) == std::tie(b.name, b.type, b.components);
}

/// The names of attributes, for messages.
std::string listOf(std::span<const Attribute> attributes) {
  std::string list;
  for (const Attribute& attribute : attributes) {
    list += fmt::format("{}'{}'", list.empty() ? "" : ", ", attribute.name);
  }
  return list.empty() ? "none" : list;
}

}  // namespace

Result<std::vector<Attribute>> joinedAttributes(const Connectivity& connectivity,
                                                const PartAttributes& parts,
                                                std::uint64_t maxInherited) {
  const std::array<std::uint32_t, 3> first = {0, connectivity.lowerCount,
                                              connectivity.firstUpper()};
  const std::array<std::uint32_t, 3> end = {connectivity.lowerCount, connectivity.firstMean(),
                                            connectivity.vertexCount};
  const std::vector<Attribute>* kinds = nullptr;
  for (std::size_t part = 0; part < parts.size(); ++part) {
    if (first[part] == end[part]) continue;
    if (kinds == nullptr) kinds = &parts[part];
    if (!std::ranges::equal(*kinds, parts[part], sameKind)) {
      return invalid(
          fmt::format("some of its vertices have the attributes {}, others {}; names, types and "
                      "order have to be the same",
                      listOf(*kinds), listOf(parts[part])));
    }
  }
  std::vector<Attribute> joined;
  std::uint64_t rowBytes = 0;
  for (std::size_t i = 0; kinds != nullptr && i < kinds->size(); ++i) {
    rowBytes += (*kinds)[i].rowBytes();
  }
  if (connectivity.means.size() > maxInherited / std::max<std::uint64_t>(rowBytes, 1)) {
    return invalid(
        fmt::format("attributes of {} means with {} bytes each are too much for this file",
                    connectivity.means.size(), rowBytes));
  }
  for (std::size_t i = 0; kinds != nullptr && i < kinds->size(); ++i) {
    const Attribute& kind = (*kinds)[i];
    Attribute& attribute = joined.emplace_back(
        Attribute{kind.name, model::Domain::Vertex, kind.type, kind.components, {}});
    attribute.values.resize(connectivity.vertexCount * kind.rowBytes());
    for (std::size_t part = 0; part < parts.size(); ++part) {
      if (first[part] == end[part]) continue;
      std::ranges::copy(
          parts[part][i].values,
          attribute.values.begin() + static_cast<std::ptrdiff_t>(first[part] * kind.rowBytes()));
    }
    setMeans(connectivity, attribute);
  }
  return joined;
}

Result<void> checkVertexAttributes(const model::Slab& slab,
                                   const std::vector<Attribute>* upperBefore) {
  const Connectivity& connectivity = *slab.connectivity;
  if (upperBefore != nullptr && connectivity.lowerCount > 0) {
    const std::vector<Attribute> lower = vertexRows(slab.attributes, 0, connectivity.lowerCount);
    if (!std::ranges::equal(lower, *upperBefore, sameKind)) {
      return invalid(fmt::format(
          "its vertices have the attributes {}, those of the one before {}; names, types and "
          "order have to be the same",
          listOf(lower), listOf(*upperBefore)));
    }
    const auto [own, before] = std::ranges::mismatch(lower, *upperBefore);
    if (own != lower.end()) {
      return invalid(fmt::format(
          "the attribute '{}' of its lower layer is not that of the upper layer of the one before",
          own->name));
    }
  }
  if (connectivity.means.size() == 0) return {};
  for (const Attribute& attribute : slab.attributes) {
    if (attribute.domain != model::Domain::Vertex) continue;
    Attribute inherited = attribute;
    setMeans(connectivity, inherited);
    if (inherited != attribute) {
      return invalid(
          fmt::format("the attribute '{}' of a mean is not what it has from its sources (setMeans)",
                      attribute.name));
    }
  }
  return {};
}

}  // namespace t4d::formats
