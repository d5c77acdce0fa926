#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <deque>
#include <string>
#include <vector>

#include <Eigen/LU>

#include "fixtures/polytopes.h"
#include "formats/mesh4d/mesh4d_formats.h"
#include "formats/test_files.h"

/// Helpers for tests of formats of 4D meshes.
namespace t4d::formats {

/// A body of tetrahedra with coordinates that need all digits of a double.
inline Mesh4d awkwardBody(const std::string& name, double shift) {
  const fixtures::Polytope polytope = fixtures::cell16();
  Mesh4d body{name, polytope.vertices, fixtures::tetrahedra(polytope)};
  double noise = 0.1;
  for (model::Point4& vertex : body.vertices) {
    for (double& coordinate : vertex) {
      noise = noise * 3.7 - static_cast<int>(noise * 3.7);
      coordinate += shift + noise / 7;
    }
  }
  body.vertices[0][0] = 5e-324;
  body.vertices[1][3] = -1.0 / 3;
  return body;
}

inline std::vector<Mesh4d> awkwardBodies() {
  return {awkwardBody("a body", 0), awkwardBody("another", 1e6)};
}

/// Two 4-simplices, whose files are short.
inline std::vector<Mesh4d> smallBodies() {
  std::vector<Mesh4d> bodies;
  for (const double shift : {0.0, 3.0}) {
    Mesh4d body{shift == 0 ? "a" : "b", {}, {}};
    body.vertices.push_back(model::Point4::Constant(shift));
    for (int i = 0; i < 4; ++i) {
      body.vertices.push_back(body.vertices[0] + model::Point4::Unit(i));
    }
    body.cells = {{1, 2, 3, 4}, {2, 0, 3, 4}, {0, 1, 3, 4}, {1, 0, 2, 4}, {0, 1, 2, 3}};
    bodies.push_back(body);
  }
  return bodies;
}

/// Bodies with the slabs and counts that writers take.
struct WrittenBodies {
  std::deque<model::Mesh> meshes;
  std::vector<CountedBody> bodies;

  explicit WrittenBodies(const std::vector<Mesh4d>& given) {
    for (const Mesh4d& body : given) {
      auto connectivity = std::make_shared<model::Connectivity>();
      connectivity->vertexCount = static_cast<std::uint32_t>(body.vertices.size());
      connectivity->cells = body.cells;
      model::Slab slab;
      slab.timeBegin = slab.timeEnd = body.vertices[0][3];
      for (const model::Point4& vertex : body.vertices) {
        slab.timeBegin = std::min(slab.timeBegin, vertex[3]);
        slab.timeEnd = std::max(slab.timeEnd, vertex[3]);
      }
      slab.vertices = body.vertices;
      slab.connectivity = connectivity;
      EXPECT_TRUE(meshes.emplace_back().put(slab));
      bodies.push_back({{body.name, &meshes.back()}, body.vertices.size(), body.cells.size()});
    }
  }
};

/// Writes bodies to a file and returns its path.
inline std::filesystem::path written4d(const Mesh4dFormat& format,
                                       const std::vector<Mesh4d>& bodies) {
  const auto path = temporaryPath(std::string(format.id) + std::string(format.extensions.front()));
  const WrittenBodies source(bodies);
  const auto flat = FlatBodies::of(source.bodies);
  EXPECT_TRUE(flat);
  const auto done = format.write(path, *flat);
  EXPECT_TRUE(done) << done.error().text();
  return path;
}

inline Result<LoadedMesh4d> read4d(const std::filesystem::path& path, std::string_view id = {}) {
  const Mesh4dFormat* found = nullptr;
  return readMesh4d(path, mesh4dFormat(id), found);
}

/// The mesh in a file of these bytes; the test fails when it is refused.
inline LoadedMesh4d read4dBytes(const std::string& name, const std::string& bytes) {
  auto loaded = read4d(writeFile(name, bytes));
  EXPECT_TRUE(loaded) << loaded.error().text();
  return loaded ? *loaded : LoadedMesh4d{};
}

/// Returns the text of the first error, as errorOf does.
inline std::string error4dOf(const std::string& name, const std::string& bytes) {
  const auto path = writeFile(name, bytes);
  const auto loaded = read4d(path);
  return loaded ? "(was accepted)" : textOf(loaded.error(), path);
}

/// The bits of a tetrahedron's corners in one order, and whether it takes an odd permutation.
using CellBits = std::array<std::uint64_t, 17>;

/// The tetrahedra of a body, whatever the order of its vertices and cells.
inline std::vector<CellBits> cellsOf(const Mesh4d& body) {
  std::vector<CellBits> all;
  for (const model::Cell& cell : body.cells) {
    std::array<std::array<std::uint64_t, 4>, 4> corners{};
    for (int i = 0; i < 4; ++i) {
      for (int k = 0; k < 4; ++k) {
        corners[i][k] = std::bit_cast<std::uint64_t>(body.vertices[cell[i]][k]);
      }
    }
    CellBits bits{};
    for (int i = 0; i < 4; ++i) {
      for (int j = i + 1; j < 4; ++j) bits[16] ^= corners[j] < corners[i] ? 1U : 0U;
    }
    std::ranges::sort(corners);
    for (int i = 0; i < 4; ++i) std::ranges::copy(corners[i], bits.begin() + std::ptrdiff_t{4} * i);
    all.push_back(bits);
  }
  std::ranges::sort(all);
  return all;
}

/// The cells of all bodies together.
inline std::vector<CellBits> cellsOf(const std::vector<Mesh4d>& bodies) {
  std::vector<CellBits> all;
  for (const Mesh4d& body : bodies) {
    const auto cells = cellsOf(body);
    all.insert(all.end(), cells.begin(), cells.end());
  }
  std::ranges::sort(all);
  return all;
}

/// Turns the tetrahedra of a convex body about the origin outward.
inline void turnOutward(Mesh4d& body) {
  for (model::Cell& cell : body.cells) {
    Eigen::Matrix4d matrix;
    for (int i = 0; i < 4; ++i) matrix.row(i) = body.vertices[cell[i]];
    if (matrix.determinant() < 0) std::swap(cell[2], cell[3]);
  }
}

/// The hypervolume that closed, oriented bodies enclose.
inline double hypervolumeOf(const std::vector<Mesh4d>& bodies) {
  double sum = 0;
  for (const Mesh4d& body : bodies) {
    for (const model::Cell& cell : body.cells) {
      Eigen::Matrix4d matrix;
      for (int i = 0; i < 4; ++i) matrix.row(i) = body.vertices[cell[i]];
      sum += matrix.determinant() / 24;
    }
  }
  return sum;
}

}  // namespace t4d::formats
