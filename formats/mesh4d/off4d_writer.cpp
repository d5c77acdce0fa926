#include "formats/mesh4d/off4d_writer.h"

#include <algorithm>
#include <array>
#include <new>
#include <utility>

#include "formats/mesh4d/text_output.h"
#include "model/facets.h"

namespace t4d::formats {
namespace {

using Triangle = std::array<std::uint32_t, 3>;

/// The triangles of all tetrahedra, once each, in increasing order; and the number of edges.
struct Skeleton {
  std::vector<Triangle> triangles;
  std::uint64_t edges = 0;
};

template <class T>
void sortUnique(std::vector<T>& items) {
  std::ranges::sort(items);
  items.erase(std::unique(items.begin(), items.end()), items.end());
}

Result<Skeleton> skeletonOf(const FlatBodies& mesh) {
  Skeleton skeleton;
  skeleton.triangles.reserve(4 * mesh.cellCount());
  auto done = mesh.forCells([&](std::size_t, std::span<const model::Cell> cells) -> Result<void> {
    for (const model::Cell& cell : cells) {
      for (int corner = 0; corner < 4; ++corner) {
        skeleton.triangles.push_back(model::facetOpposite(cell, corner).vertices);
      }
    }
    return {};
  });
  if (!done) return done.error();
  sortUnique(skeleton.triangles);
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;
  edges.reserve(3 * skeleton.triangles.size());
  for (const auto& [a, b, c] : skeleton.triangles) {
    edges.insert(edges.end(), {{a, b}, {a, c}, {b, c}});
  }
  sortUnique(edges);
  skeleton.edges = edges.size();
  return skeleton;
}

Result<void> addVertices(TextOutput& text, const FlatBodies& mesh) {
  return mesh.forVertices([&](std::span<const model::Point4> vertices) {
    for (const model::Point4& v : vertices) text.add("{} {} {} {}\n", v[0], v[1], v[2], v[3]);
    return text.flush();
  });
}

Result<void> addTriangles(TextOutput& text, const std::vector<Triangle>& triangles) {
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    const auto& [a, b, c] = triangles[i];
    text.add("3 {} {} {}\n", a, b, c);
    if (i % FlatBodies::kMostAtOnce != 0) continue;
    if (auto done = text.flush(); !done) return done;
  }
  return text.flush();
}

}  // namespace

Result<void> writeStellaOff(const std::filesystem::path& path, const FlatBodies& mesh) {
  const auto skeleton = skeletonOf(mesh);
  if (!skeleton) return skeleton.error();
  const auto& triangles = skeleton->triangles;
  auto text = TextOutput::create(path);
  if (!text) return text.error();
  text->add("4OFF\n# written by t4d: vertices, faces, edges, cells\n{} {} {} {}\n\n# Vertices\n",
            mesh.vertexCount(), triangles.size(), skeleton->edges, mesh.cellCount());
  if (auto done = addVertices(*text, mesh); !done) return done;
  text->add("\n# Faces\n");
  if (auto done = addTriangles(*text, triangles); !done) return done;
  text->add("\n# Cells\n");
  auto done = mesh.forCells([&](std::size_t, std::span<const model::Cell> cells) {
    for (const model::Cell& cell : cells) {
      text->add("4");
      for (int corner = 0; corner < 4; ++corner) {
        const Triangle facet = model::facetOpposite(cell, corner).vertices;
        text->add(" {}", std::ranges::lower_bound(triangles, facet) - triangles.begin());
      }
      text->add("\n");
    }
    return text->flush();
  });
  if (!done) return done;
  return text->commit();
}

Result<void> writeIjkOff(const std::filesystem::path& path, const FlatBodies& mesh) {
  auto text = TextOutput::create(path);
  if (!text) return text.error();
  text->add("4OFF\n# written by t4d: vertices, tetrahedra\n{} {} 0\n", mesh.vertexCount(),
            mesh.cellCount());
  if (auto done = addVertices(*text, mesh); !done) return done;
  auto done = mesh.forCells([&](std::size_t, std::span<const model::Cell> cells) {
    for (const auto& [a, b, c, d] : cells) text->add("4 {} {} {} {}\n", a, b, c, d);
    return text->flush();
  });
  if (!done) return done;
  return text->commit();
}

Result<void> writeGeomviewOff(const std::filesystem::path& path, const FlatBodies& mesh) {
  const auto skeleton = skeletonOf(mesh);
  if (!skeleton) return skeleton.error();
  auto text = TextOutput::create(path);
  if (!text) return text.error();
  text->add("nOFF\n4\n{} {} {}\n", mesh.vertexCount(), skeleton->triangles.size(), skeleton->edges);
  if (auto done = addVertices(*text, mesh); !done) return done;
  if (auto done = addTriangles(*text, skeleton->triangles); !done) return done;
  return text->commit();
}

}  // namespace t4d::formats
