#include "mesh4d/tetgen_cap.h"

// The header's terminatetetgen frees the mesh and then throws, and unwinding frees it again. The
// library calls our version instead, which only throws.
#define terminatetetgen terminatetetgen_unused
#include <tetgen.h>
#undef terminatetetgen
__attribute__((visibility("default"))) void terminatetetgen(tetgenmesh*, int reason);
void terminatetetgen(tetgenmesh*, int reason) { throw reason; }

#include <algorithm>
#include <cmath>
#include <cstring>
#include <new>

#include <fmt/format.h>

#include "model/facets.h"
#include "platform/isolated.h"
#include "t4d/mesh.h"

namespace t4d::mesh4d {
namespace {

using model::Cell;
using model::facetOpposite;
using model::orientedFacet;
using model::OrientedFacet;
using model::Point3;

void describe(const model::TriangleMesh& mesh, tetgenio& in) {
  in.firstnumber = 0;
  in.numberofpoints = static_cast<int>(mesh.vertices.size());
  in.pointlist = new REAL[3 * mesh.vertices.size()];
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    for (int k = 0; k < 3; ++k) in.pointlist[3 * i + k] = mesh.vertices[i][k];
  }
  in.numberoffacets = static_cast<int>(mesh.triangles.size());
  in.facetlist = new tetgenio::facet[mesh.triangles.size()];
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    tetgenio::facet& facet = in.facetlist[i];
    tetgenio::init(&facet);
    facet.numberofpolygons = 1;
    facet.polygonlist = new tetgenio::polygon[1];
    tetgenio::polygon& polygon = facet.polygonlist[0];
    tetgenio::init(&polygon);
    polygon.numberofvertices = 3;
    polygon.vertexlist = new int[3];
    for (int k = 0; k < 3; ++k) polygon.vertexlist[k] = static_cast<int>(mesh.triangles[i][k]);
  }
}

/// What TetGen made, as bytes that pass from its process to this one: the number of points and of
/// tetrahedra, the coordinates of the points, the corners of the tetrahedra.
class Filling {
 public:
  static std::string bytesOf(const tetgenio& out) {
    std::string bytes;
    append(bytes, &out.numberofpoints, 1);
    append(bytes, &out.numberoftetrahedra, 1);
    append(bytes, out.pointlist, 3 * static_cast<std::size_t>(out.numberofpoints));
    append(bytes, out.tetrahedronlist, 4 * static_cast<std::size_t>(out.numberoftetrahedra));
    return bytes;
  }

  explicit Filling(const std::string& bytes) {
    int counts[2];
    std::memcpy(counts, bytes.data(), sizeof(counts));
    coordinates_.resize(3 * static_cast<std::size_t>(counts[0]));
    corners_.resize(4 * static_cast<std::size_t>(counts[1]));
    const char* from = bytes.data() + sizeof(counts);
    std::memcpy(coordinates_.data(), from, coordinates_.size() * sizeof(double));
    from += coordinates_.size() * sizeof(double);
    std::memcpy(corners_.data(), from, corners_.size() * sizeof(int));
  }

  std::size_t points() const { return coordinates_.size() / 3; }
  std::size_t tetrahedra() const { return corners_.size() / 4; }
  Point3 point(std::size_t i) const {
    return {coordinates_[3 * i], coordinates_[3 * i + 1], coordinates_[3 * i + 2]};
  }
  int corner(std::size_t tetrahedron, int k) const { return corners_[4 * tetrahedron + k]; }

 private:
  template <class T>
  static void append(std::string& bytes, const T* values, std::size_t count) {
    if (count > 0) bytes.append(reinterpret_cast<const char*>(values), count * sizeof(T));
  }
  std::vector<double> coordinates_;
  std::vector<int> corners_;
};

Error gaveUp(const std::string& how) {
  return fail(ErrorCode::Failed,
              fmt::format("TetGen could not fill the solid ({}); close the ends with cones", how),
              {}, Remedy::ConeCaps);
}

/// The search for self-intersections compares all triangles around a vertex with each other.
Result<void> checkValences(const model::TriangleMesh& mesh) {
  constexpr std::uint32_t kMost = 10'000;
  std::vector<std::uint32_t> valence(mesh.vertices.size());
  for (const model::Triangle& triangle : mesh.triangles) {
    for (const std::uint32_t vertex : triangle) ++valence[vertex];
  }
  const auto largest = std::max_element(valence.begin(), valence.end());
  if (largest == valence.end() || *largest <= kMost) return {};
  return invalid(fmt::format("vertex {} has {} triangles; TetGen caps are possible up to {}; close "
                             "the ends with cones",
                             largest - valence.begin(), *largest, kMost),
                 {}, Remedy::ConeCaps);
}

/// More than ten times what a surface takes that can be filled: about 2 kB and 25 microseconds per
/// triangle.
platform::WorkLimits limitsFor(const model::TriangleMesh& mesh) {
  constexpr std::uint64_t kBytes = std::uint64_t{1} << 30;
  constexpr std::uint64_t kBytesPerTriangle = 20'000;
  constexpr std::uint64_t kSeconds = 30;
  constexpr std::uint64_t kTrianglesPerSecond = 2000;
  return {kBytes + kBytesPerTriangle * mesh.triangles.size(),
          kSeconds + mesh.triangles.size() / kTrianglesPerSecond};
}

/// The first byte of what comes back from the process that fills a solid.
constexpr char kFilled = 'f';
constexpr char kIntersects = 'i';
constexpr char kRefused = 'r';

std::string fillHere(const model::TriangleMesh& mesh) {
#ifdef T4D_WITH_CGAL
  if (auto checked = checkNoSelfIntersection(mesh); !checked) {
    return kIntersects + checked.error().message;
  }
#endif
  tetgenio in;
  tetgenio out;
  describe(mesh, in);
  try {
    // p: fill the surface; Y: add no points to it; Q: print nothing.
    char switches[] = "pYQ";
    ::tetrahedralize(switches, &in, &out);
  } catch (int code) {
    return kRefused + fmt::format("its code {}", code);
  }
  return kFilled + Filling::bytesOf(out);
}

/// Runs TetGen on the surface, in a process of its own: it asserts, and some surfaces keep it, or
/// the search for self-intersections, busy for ever.
Result<Filling> runTetGen(const model::TriangleMesh& mesh) {
  if (auto checked = checkValences(mesh); !checked) return checked.error();
  const platform::WorkLimits limits = limitsFor(mesh);
  const auto work = platform::runIsolated([&] { return fillHere(mesh); }, limits);
  if (!work) return work.error();
  using End = platform::IsolatedWork::End;
  switch (work->end) {
    case End::Crashed:
      return gaveUp(fmt::format("it crashed, by signal {}", work->signal));
    case End::OutOfTime:
      return gaveUp(fmt::format("it was stopped after {} s", limits.cpuSeconds));
    case End::OutOfMemory:
      return gaveUp(fmt::format("it needs more than {} MB", limits.memoryBytes / 1'000'000));
    case End::Returned:
      break;
  }
  const std::string rest = work->result.substr(1);
  if (work->result.front() == kIntersects) return invalid(rest, {}, Remedy::ConeCaps);
  if (work->result.front() == kRefused) return gaveUp(rest);
  return Filling(rest);
}

/// Fills the inside of the surface, including its cavities.
Result<Cap> tetrahedralize(const model::TriangleMesh& mesh) {
  const auto filling = runTetGen(mesh);
  if (!filling) return filling.error();
  const std::size_t given = mesh.vertices.size();
  Cap cap;
  for (std::size_t i = 0; i < filling->points(); ++i) {
    if (i >= given) {
      cap.inner.push_back(filling->point(i));
    } else if (filling->point(i) != mesh.vertices[i]) {
      return gaveUp(fmt::format("it moved the vertex {}", i));
    }
  }
  double volume6 = 0;
  const auto at = [&](std::uint32_t vertex) -> const Point3& {
    return vertex < given ? mesh.vertices[vertex] : cap.inner[vertex - given];
  };
  for (std::size_t i = 0; i < filling->tetrahedra(); ++i) {
    Cell cell;
    for (int k = 0; k < 4; ++k) {
      const int vertex = filling->corner(i, k);
      if (vertex < 0 || static_cast<std::size_t>(vertex) >= filling->points()) {
        return fail(ErrorCode::Failed, "TetGen returned a tetrahedron with a vertex out of range");
      }
      cell[k] = static_cast<std::uint32_t>(vertex);
    }
    const Point3& a = at(cell[0]);
    volume6 += (at(cell[1]) - a).dot((at(cell[2]) - a).cross(at(cell[3]) - a));
    cap.cells.push_back(cell);
  }
  // TetGen orients all cells alike, but the orientation depends on its version.
  if (volume6 < 0) {
    for (Cell& cell : cap.cells) std::swap(cell[0], cell[1]);
  }
  return cap;
}

/// Finds the input triangle that equals a facet, if any.
class TriangleIndex {
 public:
  explicit TriangleIndex(const model::TriangleMesh& mesh) {
    for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
      const auto& [a, b, c] = mesh.triangles[i];
      entries_.push_back({orientedFacet(a, b, c), i});
    }
    std::sort(entries_.begin(), entries_.end(),
              [](const Entry& a, const Entry& b) { return a.facet.vertices < b.facet.vertices; });
  }
  struct Entry {
    OrientedFacet facet;
    std::uint32_t triangle;
  };
  const Entry* find(const OrientedFacet& facet) const {
    const auto at = std::lower_bound(
        entries_.begin(), entries_.end(), facet.vertices,
        [](const Entry& entry, const auto& vertices) { return entry.facet.vertices < vertices; });
    return at != entries_.end() && at->facet.vertices == facet.vertices ? &*at : nullptr;
  }

 private:
  std::vector<Entry> entries_;
};

/// Keeps the cells on the inner side of the surface: TetGen fills cavities too. A cell with a
/// triangle of the surface that faces out of it is inside; others follow their neighbours.
Result<void> removeOutside(const model::TriangleMesh& mesh, Cap& cap) {
  const TriangleIndex index(mesh);
  enum Side : std::uint8_t { kUnknown, kInside, kOutside };
  std::vector<Side> side(cap.cells.size(), kUnknown);
  std::vector<bool> covered(mesh.triangles.size(), false);
  struct InnerFacet {
    OrientedFacet facet;
    std::uint32_t cell;
  };
  std::vector<InnerFacet> inner;
  std::vector<std::uint32_t> queue;
  for (std::uint32_t i = 0; i < cap.cells.size(); ++i) {
    for (int corner = 0; corner < 4; ++corner) {
      const OrientedFacet facet = facetOpposite(cap.cells[i], corner);
      const TriangleIndex::Entry* entry = index.find(facet);
      if (entry == nullptr) {
        inner.push_back({facet, i});
        continue;
      }
      const Side found = entry->facet.even == facet.even ? kInside : kOutside;
      if (found == kInside) covered[entry->triangle] = true;
      if (side[i] == kUnknown) queue.push_back(i);
      if (side[i] != kUnknown && side[i] != found) {
        return invalid(
            fmt::format("around triangle {} the surface faces both into and out of the "
                        "solid; turn its component round",
                        entry->triangle));
      }
      side[i] = found;
    }
  }
  std::sort(inner.begin(), inner.end(), [](const InnerFacet& a, const InnerFacet& b) {
    return a.facet.vertices < b.facet.vertices;
  });
  std::vector<std::array<std::uint32_t, 4>> neighbours(cap.cells.size());
  std::vector<std::uint8_t> neighbourCount(cap.cells.size(), 0);
  for (std::size_t i = 0; i + 1 < inner.size(); ++i) {
    if (inner[i].facet.vertices != inner[i + 1].facet.vertices) continue;
    const std::uint32_t a = inner[i].cell;
    const std::uint32_t b = inner[i + 1].cell;
    neighbours[a][neighbourCount[a]++] = b;
    neighbours[b][neighbourCount[b]++] = a;
    ++i;
  }
  while (!queue.empty()) {
    const std::uint32_t cell = queue.back();
    queue.pop_back();
    for (int k = 0; k < neighbourCount[cell]; ++k) {
      const std::uint32_t other = neighbours[cell][k];
      if (side[other] == kUnknown) {
        side[other] = side[cell];
        queue.push_back(other);
      } else if (side[other] != side[cell]) {
        return invalid(
            "one component of the surface faces the wrong way within another; turn it "
            "round");
      }
    }
  }
  for (std::size_t i = 0; i < covered.size(); ++i) {
    if (!covered[i]) {
      return invalid(
          fmt::format("triangle {} faces into the solid: its component is inside out; "
                      "turn it round",
                      i));
    }
  }
  // Cells are put in order from neighbour to neighbour: cells that follow one another share
  // vertices, and files get smaller.
  std::vector<Cell> kept;
  for (std::uint32_t first = 0; first < cap.cells.size(); ++first) {
    queue.push_back(first);
    while (!queue.empty()) {
      const std::uint32_t cell = queue.back();
      queue.pop_back();
      if (side[cell] != kInside) continue;
      side[cell] = kUnknown;  // taken
      kept.push_back(cap.cells[cell]);
      for (int k = 0; k < neighbourCount[cell]; ++k) queue.push_back(neighbours[cell][k]);
    }
  }
  cap.cells = std::move(kept);
  return {};
}

/// Removes inner points that no cell uses any more: those in cavities.
void dropUnusedPoints(std::uint32_t given, Cap& cap) {
  std::vector<std::uint32_t> number(cap.inner.size(), model::kNoIndex);
  std::vector<Point3> kept;
  for (Cell& cell : cap.cells) {
    for (std::uint32_t& vertex : cell) {
      if (vertex < given) continue;
      std::uint32_t& found = number[vertex - given];
      if (found == model::kNoIndex) {
        found = static_cast<std::uint32_t>(kept.size());
        kept.push_back(cap.inner[vertex - given]);
      }
      vertex = given + found;
    }
  }
  cap.inner = std::move(kept);
}

/// Checks that the volumes of the cells add up to the volume of the solid.
Result<void> checkVolume(const model::TriangleMesh& mesh, const Cap& cap) {
  const auto at = [&](std::uint32_t vertex) -> const Point3& {
    return vertex < mesh.vertices.size() ? mesh.vertices[vertex]
                                         : cap.inner[vertex - mesh.vertices.size()];
  };
  double volume6 = 0;
  for (const auto& [a, b, c, d] : cap.cells) {
    volume6 += (at(b) - at(a)).dot((at(c) - at(a)).cross(at(d) - at(a)));
  }
  constexpr double kRelative = 1e-6;  // far above rounding, far below a missing part
  const double expected = signedVolume(mesh);
  if (!(std::abs(volume6 / 6 - expected) <= kRelative * expected)) {
    return fail(ErrorCode::Failed,
                fmt::format("TetGen filled a volume of {}, but the surface encloses {}; close the "
                            "ends with cones",
                            volume6 / 6, expected),
                {}, Remedy::ConeCaps);
  }
  return {};
}

}  // namespace

Result<Cap> tetgenCap(const model::TriangleMesh& mesh) {
  auto cap = tetrahedralize(mesh);
  if (!cap) return cap;
  if (auto done = removeOutside(mesh, *cap); !done) return done.error();
  dropUnusedPoints(static_cast<std::uint32_t>(mesh.vertices.size()), *cap);
  if (auto done = checkVolume(mesh, *cap); !done) return done.error();
  return cap;
}

}  // namespace t4d::mesh4d
