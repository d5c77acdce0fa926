#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "formats/mesh4d/mesh4d_builder.h"

namespace t4d::formats {

/// The contents of the sections of a Gmsh file, text or binary. Positions are those of
/// Mesh4dBuilder.
class GmshMesh {
 public:
  using Position = Mesh4dBuilder::Position;

  GmshMesh(const std::filesystem::path& path, Mesh4dBuilder::PlaceOf placeOf)
      : path_(path.string()), placeOf_(placeOf), mesh_(path_, std::move(placeOf)) {}

  void nameGroup(std::int64_t group, std::string name) { groupNames_[group] = std::move(name); }
  void setGroup(std::int64_t volume, std::int64_t group) { groupOf_[volume] = group; }

  /// False if another node has the tag.
  bool addTag(std::int64_t tag);
  /// The coordinates of the next node, in the order of the tags.
  void addPoint(const model::Point3& point, Position position);
  std::size_t pointCount() const { return points_.size(); }

  /// The number of the node with this tag.
  std::optional<std::size_t> nodeOf(std::int64_t tag) const;

  /// `corners` are numbers of nodes.
  void addTetrahedron(const std::array<std::uint64_t, 4>& corners, std::int64_t volume,
                      Position position) {
    cells_.push_back({corners, volume, position});
  }

  /// Whether this node data, with its name in quotes, is the time; notes a loss if it is not.
  bool isTime(const std::string& quotedName);
  /// False if there were times before.
  bool beginTimes() { return !std::exchange(timed_, true); }
  void setTime(std::size_t node, double time);

  /// Fails if the file has no times, or a node has none.
  Result<LoadedMesh4d> finish(std::string dialect) &&;

 private:
  struct GmshCell {
    std::array<std::uint64_t, 4> corners;
    std::int64_t volume;
    Position position;
  };

  std::string path_;
  Mesh4dBuilder::PlaceOf placeOf_;
  Mesh4dBuilder mesh_;
  std::vector<model::Point4> points_;
  std::vector<bool> hasTime_;
  std::vector<std::int64_t> tags_;
  std::vector<Position> positions_;
  std::unordered_map<std::int64_t, std::size_t> numberOf_;  // by tag
  std::vector<GmshCell> cells_;
  std::map<std::int64_t, std::int64_t> groupOf_;  // physical group of a volume
  std::map<std::int64_t, std::string> groupNames_;
  bool timed_ = false;
  std::vector<std::string> losses_;
};

}  // namespace t4d::formats
