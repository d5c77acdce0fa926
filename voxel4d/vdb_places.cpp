#include "voxel4d/vdb_places.h"

#include <algorithm>

#include <fmt/format.h>

#include "voxel4d/natural_order.h"

namespace t4d::voxel4d {

namespace fs = std::filesystem;

namespace {

/// All .vdb files in a folder, except hidden ones, in natural order.
Result<std::vector<fs::path>> filesIn(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename().string();
    if (entry.path().extension() == ".vdb" && name.front() != '.') files.push_back(entry.path());
  }
  if (error) {
    return fail(ErrorCode::Io, "cannot read the folder: " + error.message(), folder.string());
  }
  if (files.empty()) return invalid("no frames: the folder has no .vdb files", folder.string());
  std::ranges::sort(files, [](const fs::path& a, const fs::path& b) {
    return naturallyLess(a.string(), b.string());
  });
  return files;
}

}  // namespace

Result<std::vector<fs::path>> vdbFilesOf(std::span<const fs::path> inputs) {
  std::vector<fs::path> files;
  for (const fs::path& input : inputs) {
    std::error_code ignored;
    if (!fs::is_directory(input, ignored)) {
      files.push_back(input);
      continue;
    }
    auto found = filesIn(input);
    if (!found) return found.error();
    files.insert(files.end(), found->begin(), found->end());
  }
  if (files.empty()) return invalid("no frames: no .vdb file is given");
  return files;
}

Result<std::vector<VdbPlace>> vdbPlacesOf(std::span<const fs::path> files, const std::string& grid,
                                          std::span<const std::string> without) {
  std::vector<VdbPlace> places;
  for (const fs::path& path : files) {
    auto file = VdbFile::open(path);
    if (!file) return file.error();
    const auto grids = (*file)->grids();
    std::vector<std::size_t> chosen;
    std::string names;
    for (std::size_t i = 0; i < grids.size(); ++i) {
      names += fmt::format("{}'{}'", i == 0 ? "" : ", ", grids[i].label);
      const bool taken = std::ranges::find(without, grids[i].name) == without.end();
      if (taken && (grid.empty() || grids[i].name == grid)) chosen.push_back(i);
    }
    if (grids.empty()) return invalid("holds no grid", path.string());
    if (chosen.empty()) {
      return invalid(grid.empty() ? fmt::format("holds no grid of a solid; it has {}", names)
                                  : fmt::format("holds no grid '{}'; it has {}", grid, names),
                     path.string());
    }
    if (files.size() > 1 && chosen.size() > 1) {
      return invalid(fmt::format("holds {} grids ({}); where there are several files, each must "
                                 "hold one",
                                 chosen.size(), names),
                     path.string(), Remedy::GridName);
    }
    std::stable_sort(chosen.begin(), chosen.end(), [&](std::size_t a, std::size_t b) {
      return naturallyLess(grids[a].label, grids[b].label);
    });
    for (const std::size_t i : chosen) {
      places.push_back({path, i, grids[i].where, grids[i].header, 0});
    }
  }
  return places;
}

Result<VdbGrid> VdbPlaceReader::read(const VdbPlace& place, const VdbTreeOptions& how) {
  if (!file_ || path_ != place.file) {
    file_.reset();
    auto file = VdbFile::open(place.file);
    if (!file) return file.error();
    file_ = std::move(*file);
    path_ = place.file;
  }
  if (place.grid >= file_->grids().size() || file_->grids()[place.grid].where != place.where) {
    return invalid("the file has changed while it was read", place.where);
  }
  return file_->read(place.grid, how);
}

}  // namespace t4d::voxel4d
