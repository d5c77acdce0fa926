#include "formats/mesh4d/flat_bodies.h"

#include <algorithm>
#include <limits>

#include <fmt/format.h>

namespace t4d::formats {
namespace {

/// Calls back for each slab with the number of its vertex 0 among all vertices of the body.
class NumberedSlabs : public model::Sink {
 public:
  using Take = std::function<Result<void>(const model::Slab&, std::uint64_t first)>;
  explicit NumberedSlabs(Take take) : take_(std::move(take)) {}

  Result<void> put(const model::Slab& slab) override {
    // The lower layer is the upper layer of the slab before.
    const std::uint64_t shared = begun_ ? slab.connectivity->lowerCount : 0;
    if (shared > count_) return invalid("a slab does not continue the one before");
    begun_ = true;
    const std::uint64_t first = count_ - shared;
    count_ = first + slab.vertices.size();
    return take_(slab, first);
  }

  std::uint64_t count() const { return count_; }

 private:
  Take take_;
  bool begun_ = false;
  std::uint64_t count_ = 0;
};

Result<void> checkCount(const CountedBody& body, std::uint64_t found, std::uint64_t stated,
                        const char* what) {
  if (found == stated) return {};
  return invalid(
      fmt::format("body '{}' has {} {}, where {} are stated", body.name, found, what, stated));
}

/// The attribute of a slab with this name and domain; null if there is none.
const model::Attribute* attributeOf(const model::Slab& slab, const model::Attribute& wanted) {
  for (const auto* some : {&slab.connectivity->cellAttributes, &slab.attributes}) {
    for (const model::Attribute& attribute : *some) {
      if (attribute.name == wanted.name && attribute.domain == wanted.domain) return &attribute;
    }
  }
  return nullptr;
}

}  // namespace

Result<FlatBodies> FlatBodies::of(std::span<const CountedBody> bodies) {
  FlatBodies flat;
  flat.bodies_ = bodies;
  for (const CountedBody& body : bodies) {
    flat.vertexCount_ += body.vertices;
    flat.cellCount_ += body.tetrahedra;
  }
  if (flat.vertexCount_ > std::numeric_limits<std::uint32_t>::max()) {
    return fail(ErrorCode::Unsupported,
                fmt::format("{} vertices are more than 32-bit indices can number; only .t4d, slab "
                            "by slab, holds them",
                            flat.vertexCount_));
  }
  return flat;
}

Result<void> FlatBodies::forVertices(
    const std::function<Result<void>(std::span<const model::Point4>)>& take) const {
  for (const CountedBody& body : bodies_) {
    std::uint64_t done = 0;
    NumberedSlabs slabs([&](const model::Slab& slab, std::uint64_t first) -> Result<void> {
      auto vertices = std::span(slab.vertices).subspan(done - first);
      done += vertices.size();
      while (!vertices.empty()) {
        const auto some = vertices.first(std::min(vertices.size(), kMostAtOnce));
        if (auto taken = take(some); !taken) return taken;
        vertices = vertices.subspan(some.size());
      }
      return {};
    });
    if (auto pumped = model::pump(*body.source, slabs); !pumped) return pumped;
    if (auto good = checkCount(body, done, body.vertices, "vertices"); !good) return good;
  }
  return {};
}

Result<void> FlatBodies::forCells(
    const std::function<Result<void>(std::size_t, std::span<const model::Cell>)>& take) const {
  std::uint64_t base = 0;
  std::vector<model::Cell> some;
  some.reserve(kMostAtOnce);
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    std::uint64_t done = 0;
    NumberedSlabs slabs([&](const model::Slab& slab, std::uint64_t first) -> Result<void> {
      auto cells = std::span(slab.connectivity->cells);
      done += cells.size();
      const auto offset = static_cast<std::uint32_t>(base + first);
      while (!cells.empty()) {
        some.clear();
        for (const model::Cell& cell : cells.first(std::min(cells.size(), kMostAtOnce))) {
          some.push_back({cell[0] + offset, cell[1] + offset, cell[2] + offset, cell[3] + offset});
        }
        if (auto taken = take(i, some); !taken) return taken;
        cells = cells.subspan(some.size());
      }
      return {};
    });
    if (auto pumped = model::pump(*bodies_[i].source, slabs); !pumped) return pumped;
    if (auto good = checkCount(bodies_[i], done, bodies_[i].tetrahedra, "tetrahedra"); !good) {
      return good;
    }
    base += bodies_[i].vertices;
  }
  return {};
}

Result<void> FlatBodies::findAttributes(bool (*keeps)(const model::Attribute&)) {
  bool first = true;
  for (const CountedBody& body : bodies_) {
    NumberedSlabs slabs([&](const model::Slab& slab, std::uint64_t) -> Result<void> {
      if (first) {
        for (const auto* some : {&slab.connectivity->cellAttributes, &slab.attributes}) {
          for (const model::Attribute& attribute : *some) {
            if (!keeps(attribute)) continue;
            attributes_.push_back(
                {attribute.name, attribute.domain, attribute.type, attribute.components, {}});
          }
        }
      }
      first = false;
      std::erase_if(attributes_, [&](const model::Attribute& attribute) {
        const model::Attribute* found = attributeOf(slab, attribute);
        return found == nullptr || found->type != attribute.type ||
               found->components != attribute.components;
      });
      return {};
    });
    if (auto pumped = model::pump(*body.source, slabs); !pumped) return pumped;
  }
  return {};
}

Result<void> FlatBodies::forRows(
    const model::Attribute& attribute,
    const std::function<Result<void>(std::span<const std::byte>)>& take) const {
  for (const CountedBody& body : bodies_) {
    std::uint64_t done = 0;
    NumberedSlabs slabs([&](const model::Slab& slab, std::uint64_t first) -> Result<void> {
      const model::Attribute* found = attributeOf(slab, attribute);
      if (found == nullptr) {
        return invalid(fmt::format("a slab has no attribute '{}'", attribute.name));
      }
      if (attribute.domain == model::Domain::Cell) return take(found->values);
      const std::uint64_t known = done - first;
      done += found->rows() - known;
      return take(std::span(found->values).subspan(known * found->rowBytes()));
    });
    if (auto pumped = model::pump(*body.source, slabs); !pumped) return pumped;
  }
  return {};
}

}  // namespace t4d::formats
