#include "voxel4d/vdb_velocity.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <fmt/format.h>
#include <openvdb/tools/ValueTransformer.h>

#include "voxel4d/mean_of_known.h"
#include "voxel4d/vdb_places.h"

namespace t4d::voxel4d {

namespace fs = std::filesystem;

namespace {

/// One component of a velocity at points of space.
struct Component {
  Lattice lattice;  // of its points: in a staggered grid each component has its own
  std::function<std::optional<double>(const openvdb::Coord& point)> at;  // where it is stored

  std::optional<double> operator()(const model::Point3& position) const {
    constexpr double kRounding = 1e-6;  // voxels
    Eigen::Vector3d point = (position - lattice.origin) / lattice.voxelSize;
    if (!(point.cwiseAbs().maxCoeff() < kMaxPoint)) return std::nullopt;
    for (double& x : point) x = std::abs(x - std::round(x)) < kRounding ? std::round(x) : x;
    return meanOfKnown<double>({point.x(), point.y(), point.z()}, at);
  }

 private:
  static constexpr double kMaxPoint = 1 << 30;
};

/// Fails for an active value that is not finite; those that are zero become inactive.
template <class Grid>
Result<void> judgeValues(Grid& grid, const Place& where) {
  using Value = typename Grid::ValueType;
  for (auto value = grid.cbeginValueOn(); value; ++value) {
    if (openvdb::math::isFinite(*value)) continue;
    const openvdb::Coord at = value.getCoord();
    return invalid(fmt::format("has a velocity that is not finite, at the voxel ({}, {}, {})",
                               at.x(), at.y(), at.z()),
                   where);
  }
  if constexpr (std::is_same_v<Value, openvdb::Vec3f>) {
    openvdb::tools::foreach (grid.beginValueOn(), [](const typename Grid::ValueOnIter& at) {
      if (*at == Value(0)) at.setValueOff();
    });
  }
  return {};
}

class VdbVelocity : public VelocitySource {
 public:
  VdbVelocity(std::vector<std::vector<VdbPlace>> places, const Lattice& lattice)
      : places_(std::move(places)), lattice_(lattice) {}

  Place placeOf(std::size_t index) const override { return places_[0][index].where; }

  Result<VelocityField> field(std::size_t index) override {
    const VdbTreeOptions inMemory = {std::numeric_limits<std::size_t>::max(), {}};
    std::vector<Component> components;
    VelocityField field;
    for (const auto& frames : places_) {
      const VdbPlace& place = frames[index];
      auto read = reader_.read(place, inMemory);
      if (!read) return read.error();
      const auto lattice = latticeOf(*read->grid, place.where);
      if (!lattice) return lattice.error();
      auto added = places_.size() == 1 ? addVector(*read->grid, *lattice, place.where, components)
                                       : addFloat(*read->grid, *lattice, place.where, components);
      if (!added) return added.error();
      field.moves = field.moves || read->grid->activeVoxelCount() > 0;
    }
    field.at = [components = std::move(components),
                lattice = lattice_](const Coord& point) -> std::optional<Eigen::Vector3d> {
      const model::Point3 position = lattice({double(point.x), double(point.y), double(point.z)});
      Eigen::Vector3d velocity;
      for (int axis = 0; axis < 3; ++axis) {
        const auto value = components[axis](position);
        if (!value) return std::nullopt;
        velocity[axis] = *value / lattice.voxelSize;
      }
      if (velocity.isZero(0)) return std::nullopt;
      return velocity;
    };
    return field;
  }

 private:
  static Result<void> addVector(openvdb::GridBase& any, const Lattice& lattice, const Place& where,
                                std::vector<Component>& into) {
    const auto grid = openvdb::gridPtrCast<openvdb::Vec3SGrid>(any.copyGrid());
    if (auto good = judgeValues(*grid, where); !good) return good;
    const bool staggered = any.getGridClass() == openvdb::GRID_STAGGERED;
    for (int axis = 0; axis < 3; ++axis) {
      Lattice own = lattice;
      if (staggered) own.origin[axis] -= lattice.voxelSize / 2;  // on the lower face of its voxel
      into.push_back({own, [grid, axis](const openvdb::Coord& point) -> std::optional<double> {
                        openvdb::Vec3f value;
                        if (!grid->tree().probeValue(point, value)) return std::nullopt;
                        return value[axis];
                      }});
    }
    return {};
  }

  static Result<void> addFloat(openvdb::GridBase& any, const Lattice& lattice, const Place& where,
                               std::vector<Component>& into) {
    const auto grid = openvdb::gridPtrCast<openvdb::FloatGrid>(any.copyGrid());
    if (auto good = judgeValues(*grid, where); !good) return good;
    into.push_back({lattice, [grid](const openvdb::Coord& point) -> std::optional<double> {
                      float value = 0;
                      if (!grid->tree().probeValue(point, value)) return std::nullopt;
                      return value;
                    }});
    return {};
  }

  std::vector<std::vector<VdbPlace>> places_;  // of one vector or three components, by frame
  Lattice lattice_;
  VdbPlaceReader reader_;
};

}  // namespace

Result<std::vector<std::string>> vdbVelocityGrids(const fs::path& path, const std::string& name) {
  const auto file = VdbFile::open(path);
  if (!file) return file.error();
  std::string names;
  const auto has = [&](const std::string& wanted) {
    return std::ranges::any_of((*file)->grids(),
                               [&](const VdbFile::Entry& grid) { return grid.name == wanted; });
  };
  if (has(name)) return std::vector{name};
  for (const std::array<const char*, 3>& ends :
       std::initializer_list<std::array<const char*, 3>>{{".x", ".y", ".z"},
                                                         {"_x", "_y", "_z"},
                                                         {"x", "y", "z"},
                                                         {".X", ".Y", ".Z"},
                                                         {"_X", "_Y", "_Z"},
                                                         {"X", "Y", "Z"}}) {
    if (has(name + ends[0]) && has(name + ends[1]) && has(name + ends[2])) {
      return std::vector{name + ends[0], name + ends[1], name + ends[2]};
    }
  }
  for (const VdbFile::Entry& grid : (*file)->grids()) {
    names += fmt::format("{}'{}'", names.empty() ? "" : ", ", grid.label);
  }
  return invalid(fmt::format("holds no velocity '{0}', neither as a vec3s grid nor as three float "
                             "grids such as '{0}.x'; it has {1}",
                             name, names),
                 path.string());
}

Result<std::unique_ptr<VelocitySource>> openVdbVelocity(std::span<const fs::path> files,
                                                        std::span<const std::string> grids,
                                                        const Lattice& lattice,
                                                        std::size_t frames) {
  std::vector<std::vector<VdbPlace>> places;
  for (const std::string& grid : grids) {
    auto found = vdbPlacesOf(files, grid);
    if (!found) return found.error();
    if (found->size() != frames) {
      return invalid(fmt::format("has {} grids '{}' for {} frames; each frame needs its velocity",
                                 found->size(), grid, frames),
                     files.front().string());
    }
    for (const VdbPlace& place : *found) {
      const bool vector = grids.size() == 1;
      const openvdb::GridBase& header = *place.header;
      if (vector ? header.isType<openvdb::Vec3SGrid>() : header.isType<openvdb::FloatGrid>()) {
        if (auto good = latticeOf(header, place.where); !good) return good.error();
        continue;
      }
      return invalid(fmt::format("is a grid of type {}; a velocity is a vec3s grid, or three float "
                                 "grids",
                                 typeOf(header)),
                     place.where);
    }
    places.push_back(std::move(*found));
  }
  return std::make_unique<VdbVelocity>(std::move(places), lattice);
}

}  // namespace t4d::voxel4d
