#include "formats/animation/mesh_steps.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <map>

#include <fmt/format.h>

#include "formats/file_extension.h"
#include "formats/text/text_scanner.h"
#include "formats/triangle/mesh_builder.h"
#include "formats/triangle/triangle_mesh_formats.h"
#include "formats/vtk/vtk_file.h"
#include "model/limits.h"
#include "model/number.h"
#include "platform/regular_file.h"

namespace t4d::formats {
namespace {

namespace fs = std::filesystem;

template <class T>
bool parsed(const std::string& text, T& value) {
  const auto number = model::numberIn<T>(text);
  value = number.value_or(value);
  return number.has_value();
}

/// The path of a file that a collection names.
Result<fs::path> fileOf(const VtkDataSet& listed, const InputFile& collection) {
  const fs::path folder = collection.path.parent_path();
  fs::path file = folder / listed.file;
  std::error_code ignored;
  if (listed.file.find('\\') != std::string::npos && !fs::exists(file, ignored)) {
    // Programs on Windows separate folders so.
    std::string portable = listed.file;
    std::ranges::replace(portable, '\\', '/');
    file = folder / portable;
  }
  if (fs::exists(file, ignored) && !platform::isWithinFolder(file, folder)) {
    return invalid(fmt::format("names the file {}; it must be in the same folder or below, so that "
                               "a collection from elsewhere cannot have other files read",
                               inQuotes(listed.file)),
                   collection.atLine(listed.line));
  }
  const auto wrong = [&](const Error& error) {
    return fail(error.code,
                fmt::format("names the file {}: {}", inQuotes(listed.file), error.message),
                collection.atLine(listed.line));
  };
  if (auto known = checkMeshExtension(file); !known) return wrong(known.error());
  if (auto size = platform::sizeOfRegularFile(file); !size) return wrong(size.error());
  return file;
}

Result<double> timeOf(const VtkDataSet& listed, const InputFile& collection) {
  double time = 0;
  if (!parsed(listed.timestep, time) || !std::isfinite(time)) {
    return invalid(fmt::format("the timestep is {}, expected a number", inQuotes(listed.timestep)),
                   collection.atLine(listed.line));
  }
  if (std::abs(time) <= model::kLargestCoordinate) return time;
  return invalid(fmt::format("the timestep is {}; the largest possible is {}",
                             inQuotes(listed.timestep), model::kLargestCoordinate),
                 collection.atLine(listed.line));
}

Result<MeshSteps> stepsOfCollection(const fs::path& path) {
  const auto file = readInputFile(path);
  if (!file) return file.error();
  const auto vtk = VtkFile::open(*file, VtkType::Collection);
  if (!vtk) return vtk.error();
  // Files by time and part; parts of the same number are in the order of the file.
  std::map<double, std::multimap<std::int64_t, fs::path>> files;
  for (const VtkDataSet& listed : vtk->dataSets()) {
    const auto time = timeOf(listed, *file);
    if (!time) return time.error();
    std::int64_t part = 0;
    if (!listed.part.empty() && !parsed(listed.part, part)) {
      return invalid(fmt::format("the part is {}, expected a whole number", inQuotes(listed.part)),
                     file->atLine(listed.line));
    }
    auto named = fileOf(listed, *file);
    if (!named) return named.error();
    files[*time].emplace(part, std::move(*named));
  }
  MeshSteps all;
  all.timed = true;
  for (auto& [time, parts] : files) {
    MeshStep& step = all.steps.emplace_back(MeshStep{time, {}});
    for (auto& [number, part] : parts) step.files.push_back(std::move(part));
  }
  return all;
}

Result<MeshSteps> stepsOfFiles(std::span<const fs::path> files) {
  for (const fs::path& file : files) {
    if (!isCollection(file)) continue;
    return invalid("a collection is given alone: it lists the meshes", file.string());
  }
  MeshSteps all;
  for (const fs::path& file : files) {
    all.steps.push_back({static_cast<double>(all.steps.size()), {file}});
  }
  return all;
}

void addNew(std::vector<std::string>& lines, const std::vector<std::string>& more) {
  for (const std::string& line : more) {
    if (std::ranges::find(lines, line) == lines.end()) lines.push_back(line);
  }
}

}  // namespace

std::vector<platform::FileFormat> collectionFormats() {
  return {{"ParaView collection of surfaces", {".pvd"}, {"triangles", "times"}, true}};
}

bool isCollection(const fs::path& path) { return isOneOf(collectionFormats(), path); }

Result<MeshSteps> meshSteps(std::span<const fs::path> files) {
  const bool collected = files.size() == 1 && isCollection(files.front());
  auto all = collected ? stepsOfCollection(files.front()) : stepsOfFiles(files);
  if (!all || all->steps.size() > 1) return all;
  return invalid(fmt::format("{}; a 4D mesh needs two or more",
                             all->steps.empty() ? "no frame" : "one frame only"),
                 files.empty() ? "" : files.front().string());
}

Result<LoadedMesh> readMeshStep(const MeshStep& step, Keep keep) {
  if (step.files.size() == 1) return readTriangleMesh(step.files.front(), keep);
  MeshBuilder builder(step.files.front().string(),
                      [&](auto part) { return step.files[part].string(); });
  LoadedMesh about;
  FilePoints points;
  for (std::size_t part = 0; part < step.files.size(); ++part) {
    const auto loaded = readTriangleMesh(step.files[part]);
    if (!loaded) return loaded;
    const auto first = static_cast<std::uint32_t>(builder.pointCount());
    for (const model::Point3& vertex : loaded->mesh.vertices) {
      if (auto added = builder.addPoint(vertex, part); !added) return added.error();
    }
    for (const auto& [a, b, c] : loaded->mesh.triangles) {
      const std::array<std::uint64_t, 3> corners = {
          first + std::uint64_t{a}, first + std::uint64_t{b}, first + std::uint64_t{c}};
      if (auto added = builder.addPolygon(corners, part); !added) return added.error();
    }
    for (const std::uint32_t vertex : loaded->points.vertexOf) {
      points.vertexOf.push_back(vertex == FilePoints::kUnused ? vertex : first + vertex);
    }
    points.faceCount += loaded->points.faceCount;
    points.faceHash = std::rotl(points.faceHash, 1) ^ loaded->points.faceHash;
    addNew(about.notices, loaded->notices);
    addNew(about.losses, loaded->losses);
    about.otherFiles.insert(about.otherFiles.end(), loaded->otherFiles.begin(),
                            loaded->otherFiles.end());
  }
  auto merged = std::move(builder).finish();
  if (!merged) return merged;
  for (std::uint32_t& vertex : points.vertexOf) {
    if (vertex != FilePoints::kUnused) vertex = merged->points.vertexOf[vertex];
  }
  addNew(about.notices, merged->notices);
  about.mesh = std::move(merged->mesh);
  about.points = std::move(points);
  return about;
}

}  // namespace t4d::formats
