#include "formats/mesh4d/gmsh_mesh.h"

#include <fmt/format.h>

#include "formats/text/text_scanner.h"
#include "t4d/file.h"

namespace t4d::formats {

bool GmshMesh::addTag(std::int64_t tag) {
  if (!numberOf_.try_emplace(tag, tags_.size()).second) return false;
  tags_.push_back(tag);
  return true;
}

void GmshMesh::addPoint(const model::Point3& point, Position position) {
  points_.emplace_back(point[0], point[1], point[2], 0);
  positions_.push_back(position);
  hasTime_.push_back(false);
}

std::optional<std::size_t> GmshMesh::nodeOf(std::int64_t tag) const {
  const auto found = numberOf_.find(tag);
  return found == numberOf_.end() ? std::nullopt : std::optional(found->second);
}

bool GmshMesh::isTime(const std::string& quotedName) {
  if (quotedName == "\"time\"") return true;
  losses_.push_back(fmt::format("{}: node data {} is not read", path_, inQuotes(quotedName)));
  return false;
}

void GmshMesh::setTime(std::size_t node, double time) {
  points_[node][3] = time;
  hasTime_[node] = true;
}

Result<LoadedMesh4d> GmshMesh::finish(std::string dialect) && {
  if (!timed_) {
    return invalid("has no $NodeData \"time\", which would be the fourth coordinate", path_);
  }
  for (std::size_t i = 0; i < points_.size(); ++i) {
    if (!hasTime_[i]) {
      return invalid(fmt::format("node {} has no time", tags_[i]), placeOf_(positions_[i]));
    }
    if (auto added = mesh_.addVertex(points_[i], positions_[i]); !added) return added.error();
  }
  for (const auto& [corners, volume, position] : cells_) {
    if (auto added = mesh_.addCell(corners, volume, position); !added) return added.error();
  }
  std::map<std::int64_t, std::string> names;
  for (const auto& [volume, group] : groupOf_) {
    if (const auto name = groupNames_.find(group); name != groupNames_.end()) {
      names[volume] = name->second;
    }
  }
  auto loaded = std::move(mesh_).finish(names);
  if (!loaded) return loaded;
  loaded->dialect = std::move(dialect);
  loaded->losses = std::move(losses_);
  return loaded;
}

}  // namespace t4d::formats
