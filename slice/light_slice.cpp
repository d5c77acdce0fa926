#include <algorithm>
#include <array>
#include <cstring>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include <fmt/format.h>

#include "model/corner_attributes.h"
#include "slice/prisms.h"
#include "slice/slab_at_time.h"
#include "slice/slab_cutter.h"
#include "slice/surface_motion.h"
#include "t4d/mesh.h"
#include "t4d/slice.h"

namespace t4d::slice {

/// What is the same in all slices of slabs that share a connectivity.
struct LightSurface {
  Prisms prisms;
  std::vector<model::Triangle> triangles;  // of the slice's vertices
  std::vector<std::uint32_t> lower;        // for each vertex of the slice, that of the lower layer
};

namespace {

using model::Attribute;
using model::Connectivity;
using model::Point3;
using model::Slab;
using model::Triangle;

LightSurface surfaceOf(Prisms prisms, std::uint32_t lowerCount) {
  LightSurface surface;
  std::vector<std::uint32_t> number(lowerCount, model::kNoIndex);
  for (const Triangle& triangle : prisms.triangles) {
    for (const std::uint32_t corner : triangle) number[corner] = 0;
  }
  for (std::uint32_t i = 0; i < lowerCount; ++i) {
    if (number[i] == model::kNoIndex) continue;
    number[i] = static_cast<std::uint32_t>(surface.lower.size());
    surface.lower.push_back(i);
  }
  for (const Triangle& triangle : prisms.triangles) {
    surface.triangles.push_back({number[triangle[0]], number[triangle[1]], number[triangle[2]]});
  }
  surface.prisms = std::move(prisms);
  return surface;
}

/// The attribute of the slice: it has one row for each triangle, or vertex.
Attribute ofTriangles(const Attribute& of, const Prisms& prisms, std::vector<std::string>& losses) {
  Attribute carried{of.name, of.domain, of.type, of.components, {}};
  const std::size_t bytes = of.rowBytes();
  carried.values.reserve(prisms.bottoms.size() * bytes);
  for (const std::uint32_t cell : prisms.bottoms) {
    carried.values.insert(carried.values.end(), of.row(cell), of.row(cell) + bytes);
  }
  for (std::size_t i = 0; i < prisms.prismOf.size(); ++i) {
    if (std::memcmp(of.row(i), carried.row(prisms.prismOf[i]), bytes) == 0) continue;
    losses.push_back(fmt::format(
        "attribute '{}': cells of one prism differ in it; the one at its start counts", of.name));
    break;
  }
  return carried;
}

Attribute ofVertices(const Attribute& of, std::span<const std::uint32_t> lower, std::uint32_t up,
                     double fraction) {
  Attribute carried{of.name, of.domain, of.type, of.components, {}};
  const std::size_t bytes = of.rowBytes();
  carried.values.resize(lower.size() * bytes);
  for (std::size_t i = 0; i < lower.size(); ++i) {
    std::byte* into = carried.values.data() + i * bytes;
    if (fraction == 1) {
      std::memcpy(into, of.row(up + lower[i]), bytes);
    } else {
      interpolateRow(of, lower[i], up + lower[i], fraction, into);
    }
  }
  return carried;
}

/// The attribute of vertices that an attribute of corners stands for; nothing if corners at one
/// vertex differ, as texture coordinates do at a seam.
std::optional<Attribute> atVertices(const Attribute& corners, std::span<const Triangle> triangles,
                                    std::size_t vertexCount) {
  if (!corners.name.ends_with(model::kCornersOf) || corners.components % 3 != 0) {
    return std::nullopt;
  }
  Attribute made{corners.name.substr(0, corners.name.size() - model::kCornersOf.size()),
                 model::Domain::Vertex,
                 corners.type,
                 corners.components / 3,
                 {}};
  const std::size_t bytes = made.rowBytes();
  made.values.resize(vertexCount * bytes);
  std::vector<bool> known(vertexCount, false);
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t vertex = triangles[i][k];
      const std::byte* from = corners.row(i) + k * bytes;
      std::byte* to = made.values.data() + vertex * bytes;
      if (known[vertex] && std::memcmp(from, to, bytes) != 0) return std::nullopt;
      std::memcpy(to, from, bytes);
      known[vertex] = true;
    }
  }
  return made;
}

/// How the vertices of the slice move, and with them its triangles.
SurfaceMotion motionOf(const Slab& slab, const LightSurface& surface,
                       const model::TriangleMesh& mesh) {
  SurfaceMotion motion;
  motion.velocities.reserve(surface.lower.size());
  for (const std::uint32_t i : surface.lower) motion.velocities.push_back(layerVelocity(slab, i));
  motion.speeds.reserve(mesh.triangles.size());
  for (const Triangle& triangle : mesh.triangles) {
    Point3 mean = Point3::Zero();
    for (const std::uint32_t corner : triangle) mean += motion.velocities[corner] / 3;
    motion.speeds.push_back(areaVector(mesh, triangle).normalized().dot(mean));
  }
  return motion;
}

LightSlice lightSlice(const Slab& slab, const LightSurface& surface, double time) {
  const Connectivity& connectivity = *slab.connectivity;
  const double fraction =
      time == slab.timeEnd ? 1 : (time - slab.timeBegin) / (slab.timeEnd - slab.timeBegin);
  LightSlice made;
  model::TriangleMesh& mesh = made.slice.mesh;
  mesh.triangles = surface.triangles;
  mesh.vertices.reserve(surface.lower.size());
  for (const std::uint32_t i : surface.lower) {
    const Point3 from = slab.lowerLayer()[i].head<3>();
    const Point3 to = slab.upperLayer()[i].head<3>();
    // Exactly the layer's at both ends.
    mesh.vertices.emplace_back(fraction == 1 ? to : Point3(from + fraction * (to - from)));
  }
  const auto carry = [&](const Attribute& attribute) {
    mesh.attributes.push_back(
        attribute.domain == model::Domain::Cell
            ? ofTriangles(attribute, surface.prisms, made.slice.losses)
            : ofVertices(attribute, surface.lower, connectivity.firstUpper(), fraction));
  };
  for (const Attribute& attribute : connectivity.cellAttributes) carry(attribute);
  for (const Attribute& attribute : slab.attributes) carry(attribute);
  for (Attribute& attribute : mesh.attributes) {
    auto ofVertices = atVertices(attribute, mesh.triangles, mesh.vertices.size());
    if (ofVertices) attribute = std::move(*ofVertices);
  }
  made.distance = lightDistance(slab, surface.prisms.triangles, fraction);
  return made;
}

}  // namespace

double lightDistance(const model::Slab& slab, std::span<const model::Triangle> triangles,
                     double fraction) {
  const auto lower = slab.lowerLayer();
  const auto upper = slab.upperLayer();
  double edge = 0;
  double corner = 0;
  for (const model::Triangle& triangle : triangles) {
    std::array<model::Point3, 3> moved;
    for (int i = 0; i < 3; ++i) {
      moved[i] = (upper[triangle[i]] - lower[triangle[i]]).head<3>();
    }
    for (int i = 0; i < 3; ++i) {
      const model::Point3 next = moved[(i + 1) % 3] - moved[i];
      edge = std::max(edge, next.norm());
      corner = std::max(corner, (next + moved[(i + 2) % 3] - moved[i]).norm());
    }
  }
  const double nearest = std::min(fraction, 1 - fraction);
  return nearest * (0.5 - nearest) * std::max(edge, corner * 2 / 3);
}

/// Remembers the surface of the last connectivity, or why it has none.
class SurfaceMemory {
 public:
  using Surface = std::shared_ptr<const Result<LightSurface>>;

  Surface of(const std::shared_ptr<const model::Connectivity>& connectivity) {
    {
      const std::scoped_lock lock(mutex_);
      if (connectivity == connectivity_) return last_;
    }
    Surface made = find(*connectivity);
    const std::scoped_lock lock(mutex_);
    connectivity_ = connectivity;
    last_ = made;
    return made;
  }

 private:
  static Surface find(const model::Connectivity& connectivity) {
    auto prisms = prismsOf(connectivity);
    if (!prisms) return std::make_shared<const Result<LightSurface>>(prisms.error());
    return std::make_shared<const Result<LightSurface>>(
        surfaceOf(std::move(*prisms), connectivity.lowerCount));
  }

  std::mutex mutex_;
  std::shared_ptr<const model::Connectivity> connectivity_;
  Surface last_;
};

class LightSlicer::Impl {
 public:
  Impl(const model::Source& source, WithMotion withMotion)
      : source_(source), withMotion_(withMotion), exact_(source, withMotion) {}

  Result<LightSlice> at(double given) const {
    const auto at = slabAtTime(source_, given);
    if (!at) return at.error();
    if (!at->slab) {
      LightSlice nothing;
      nothing.slice.slabsSkipped = source_.slabCount();
      if (withMotion_ == WithMotion::Yes) nothing.slice.motion.emplace();
      return nothing;
    }
    const auto open = openSlab(source_, *at->slab);
    if (!open) return open.error();
    if (open->blocks) return exact(given, "its cells are stored in blocks, without means");
    const model::Slab& slab = *open->slab;
    if (auto checked = memory_.check(slab.connectivity); !checked) return checked.error();
    if (auto checked = checkSlab(slab); !checked) return checked.error();
    if (!(slab.timeEnd > slab.timeBegin)) return exact(given, "it is a cap");
    const auto surface = surfaces_.of(slab.connectivity);
    if (!*surface) return exact(given, surface->error().message);
    LightSlice made = lightSlice(slab, **surface, at->time);
    if (withMotion_ == WithMotion::Yes) {
      made.slice.motion = motionOf(slab, **surface, made.slice.mesh);
    }
    made.slice.slabsRead = 1;
    made.slice.slabsSkipped = source_.slabCount() - 1;
    made.slice.blocksRead = (slab.connectivity->cells.size() + kBlockCells - 1) / kBlockCells;
    return made;
  }

 private:
  Result<LightSlice> exact(double time, std::string why) const {
    auto slice = exact_.at(time);
    if (!slice) return slice.error();
    return LightSlice{std::move(*slice), false, 0, std::move(why)};
  }

  const model::Source& source_;
  WithMotion withMotion_;
  TimeSlicer exact_;
  mutable CutMemory memory_;
  mutable SurfaceMemory surfaces_;
};

LightSlicer::LightSlicer(const model::Source& source, WithMotion withMotion)
    : impl_(std::make_unique<Impl>(source, withMotion)) {}

LightSlicer::~LightSlicer() = default;

Result<LightSlice> LightSlicer::at(double time) const { return impl_->at(time); }

}  // namespace t4d::slice
