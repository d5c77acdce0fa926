#include "formats/animation/deformation_reader.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "formats/animation/file_points.h"
#include "formats/animation/mdd_reader.h"
#include "formats/animation/mesh_steps.h"
#include "formats/animation/pc2_reader.h"
#include "formats/file_extension.h"
#include "formats/numbered_files.h"
#include "formats/triangle/triangle_mesh_formats.h"
#include "formats/triangle/written_mesh.h"
#include "model/corner_attributes.h"

namespace t4d::formats {
namespace {

using model::Point3;

/// The times of `count` keys; `own` are those of the file.
Result<std::vector<double>> timesOf(const KeyTimes& times, std::uint64_t count,
                                    const std::vector<double>& own, const std::string& where) {
  std::vector<double> all = times.between ? model::evenTimes(*times.between, count)
                            : times.step  ? model::steppedTimes(0, *times.step, count)
                                          : own;
  for (std::size_t i = 1; i < all.size(); ++i) {
    if (all[i] > all[i - 1]) continue;
    return invalid(fmt::format("key {} (counted from 0) is at time {}, not after the key before "
                               "it, at {}: a 4D mesh cannot go backward through time",
                               i, all[i], all[i - 1]),
                   where);
  }
  return all;
}

/// Drops attributes that may have other values at other keys. The dropped ones are losses.
void keepLook(LoadedMesh& loaded) {
  std::vector<std::string> dropped;
  std::erase_if(loaded.mesh.attributes, [&](const model::Attribute& attribute) {
    std::string_view name = attribute.name;
    if (name.ends_with(model::kCornersOf)) name.remove_suffix(model::kCornersOf.size());
    if (name == "color" || name == "uv" || name == kMaterial) return false;
    dropped.push_back(attribute.name);
    return true;
  });
  if (dropped.empty()) return;
  loaded.losses.push_back(
      fmt::format("{}: of a solid that is deformed, only color, uv and "
                  "material are read",
                  fmt::join(dropped, ", ")));
}

class SeriesKeys : public model::VertexKeys {
 public:
  SeriesKeys(std::vector<MeshStep> steps, std::vector<double> times, const LoadedMesh& first)
      : steps_(std::move(steps)),
        times_(std::move(times)),
        filePoints_(first.points),
        first_(first.mesh.vertices) {}

  std::uint64_t count() const override { return steps_.size(); }
  double time(std::uint64_t key) const override { return times_[key]; }

  Result<void> positions(std::uint64_t key, std::span<Point3> into) const override {
    if (key == 0) {
      std::ranges::copy(first_, into.begin());
      return {};
    }
    const auto loaded = readMeshStep(steps_[key]);
    if (!loaded) return loaded.error();
    const std::string where = steps_[key].files.front().string();
    if (auto same = checkSame(loaded->points, where); !same) return same;
    std::vector<Point3> points(filePoints_.vertexOf.size(), Point3::Zero());
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (filePoints_.vertexOf[i] == FilePoints::kUnused) continue;
      const std::uint32_t vertex = loaded->points.vertexOf[i];
      if (vertex == FilePoints::kUnused) {
        return invalid(fmt::format("all triangles about point {} (counted from 0) have two equal "
                                   "corners: the surface has collapsed there",
                                   i),
                       where);
      }
      points[i] = loaded->mesh.vertices[vertex];
    }
    return placeVertices(filePoints_, points, into, where);
  }

 private:
  Result<void> checkSame(const FilePoints& found, const std::string& where) const {
    const std::string first = steps_.front().files.front().filename().string();
    if (found.vertexOf.size() != filePoints_.vertexOf.size() ||
        found.faceCount != filePoints_.faceCount) {
      return invalid(
          fmt::format("has {} points and {} faces, {} has {} and {}; every mesh of a series must "
                      "have the same points and faces in the same order",
                      found.vertexOf.size(), found.faceCount, first, filePoints_.vertexOf.size(),
                      filePoints_.faceCount),
          where);
    }
    if (found.faceHash == filePoints_.faceHash) return {};
    return invalid(fmt::format("its faces join other points than those of {}; every mesh of a "
                               "series must have the same points and faces in the same order",
                               first),
                   where);
  }

  std::vector<MeshStep> steps_;
  std::vector<double> times_;
  FilePoints filePoints_;
  std::vector<Point3> first_;
};

class CacheKeys : public model::VertexKeys {
 public:
  CacheKeys(PointCache cache, std::vector<double> times, FilePoints filePoints)
      : cache_(std::move(cache)), times_(std::move(times)), filePoints_(std::move(filePoints)) {}

  std::uint64_t count() const override { return cache_.sampleCount(); }
  double time(std::uint64_t key) const override { return times_[key]; }

  Result<void> positions(std::uint64_t key, std::span<Point3> into) const override {
    std::vector<Point3> points(cache_.pointCount());
    if (auto read = cache_.read(key, points); !read) return read;
    auto placed = placeVertices(filePoints_, points, into, cache_.name());
    if (!placed)
      return invalid(fmt::format("sample {}: {}", key, placed.error().message),
                     placed.error().where);
    return placed;
  }

 private:
  PointCache cache_;
  std::vector<double> times_;
  FilePoints filePoints_;
};

}  // namespace

std::vector<platform::FileFormat> pointCacheFormats() {
  return {{"PC2", {".pc2"}, {"vertices of a triangle mesh", "times"}},
          {"MDD", {".mdd"}, {"vertices of a triangle mesh", "times"}}};
}

bool isPointCache(const std::filesystem::path& path) { return isOneOf(pointCacheFormats(), path); }

Result<LoadedDeformation> readMeshSeries(std::span<const std::filesystem::path> files,
                                         const KeyTimes& times) {
  if (auto whole = checkNumbers(files); !whole) return whole.error();
  auto series = meshSteps(files);
  if (!series) return series.error();
  std::vector<double> own;
  LoadedDeformation loaded;
  for (const MeshStep& step : series->steps) {
    own.push_back(step.time);
    loaded.files.push_back(step.files.front());
  }
  loaded.timed = series->timed;
  if (auto known = checkMeshExtension(loaded.files.front()); !known) return known.error();
  auto keyTimes = timesOf(times, own.size(), own, loaded.files.front().string());
  if (!keyTimes) return keyTimes.error();
  auto first = readMeshStep(series->steps.front(), Keep::Attributes);
  if (!first) return first.error();
  keepLook(*first);
  loaded.solid = std::move(*first);
  loaded.keys =
      std::make_unique<SeriesKeys>(std::move(series->steps), std::move(*keyTimes), loaded.solid);
  return loaded;
}

Result<LoadedDeformation> readCachedMesh(const std::filesystem::path& mesh,
                                         const std::filesystem::path& cache,
                                         const KeyTimes& times) {
  auto solid = readTriangleMesh(mesh, Keep::Attributes);
  if (!solid) return solid.error();
  keepLook(*solid);
  auto source = openFileSource(cache);
  if (!source) return source.error();
  auto opened = lowerCaseExtension(cache) == ".mdd" ? openMdd(std::move(*source))
                                                    : openPc2(std::move(*source));
  if (!opened) return opened.error();
  const std::size_t points = solid->points.vertexOf.size();
  if (opened->pointCount() != points) {
    return invalid(fmt::format("has {} points, {} has {}; a cache belongs to the mesh file that it "
                               "was made with",
                               opened->pointCount(), mesh.filename().string(), points),
                   cache.string());
  }
  auto keyTimes = timesOf(times, opened->sampleCount(), opened->times(), cache.string());
  if (!keyTimes) return keyTimes.error();
  LoadedDeformation loaded{std::move(*solid), nullptr};
  loaded.keys =
      std::make_unique<CacheKeys>(std::move(*opened), std::move(*keyTimes), loaded.solid.points);
  return loaded;
}

}  // namespace t4d::formats
