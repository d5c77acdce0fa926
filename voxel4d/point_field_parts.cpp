#include "voxel4d/point_field_parts.h"

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <memory>
#include <vector>

#include <fmt/format.h>

#include "voxel4d/field_metadata.h"
#include "voxel4d/point_field.h"
#include "voxel4d/vdb_file.h"
#include "voxel4d/vdb_grid.h"
#include "voxel4d/vdb_series.h"

namespace t4d::voxel4d {
namespace {

namespace fs = std::filesystem;
using Identity = std::map<std::string, std::string>;

/// A file, without the values of its grid.
struct FieldPart {
  fs::path file;
  openvdb::GridBase::Ptr header;
  Lattice lattice = {};
  model::Part part = {};
  std::array<std::uint64_t, 3> points = {0, 0, 0};  ///< of the whole field
  Identity identity = {};  ///< what is the same in all parts of a field, by name
};

/// A number from 1 on in the metadata; 0 if there is none.
std::uint64_t numberOf(const openvdb::MetaMap& metadata, const char* name) {
  const auto number = metadata.getMetadata<openvdb::Int64Metadata>(name);
  return number && number->value() > 0 ? static_cast<std::uint64_t>(number->value()) : 0;
}

Identity identityOf(const FieldPart& part) {
  const model::Point3& origin = part.lattice.origin;
  const auto& [x, y, z] = part.points;
  Identity identity = {
      {"field", part.header->getName()},
      {"type of values", typeOf(*part.header)},
      {"number of parts", fmt::format("{}", part.part.count)},
      {"voxel size", fmt::format("{}", part.lattice.voxelSize)},
      {"first point", fmt::format("{}, {}, {}", origin.x(), origin.y(), origin.z())},
      {"number of points", fmt::format("{} x {} x {}", x, y, z)}};
  const std::string_view prefix = kPartRun;
  for (auto meta = part.header->beginMeta(); meta != part.header->endMeta(); ++meta) {
    if (!meta->first.starts_with(prefix)) continue;
    identity[meta->first.substr(prefix.size())] = meta->second->str();
  }
  return identity;
}

bool isSound(const FieldPart& part) {
  constexpr std::uint64_t kMostPoints = std::numeric_limits<std::int32_t>::max();
  return part.part.number >= 1 && part.part.number <= part.part.count &&
         part.part.count <= mostFieldParts(part.points[0]) &&
         std::ranges::all_of(part.points, [](auto n) { return n >= 1 && n <= kMostPoints; }) &&
         (part.header->isType<openvdb::FloatGrid>() || part.header->isType<openvdb::Int32Grid>());
}

Result<FieldPart> readPart(const fs::path& path) {
  auto file = VdbFile::open(path);
  if (!file) return file.error();
  const auto noPart = [&] {
    return invalid("is not a part of a field", path.string(), Remedy::FieldParts);
  };
  if ((*file)->grids().size() != 1) return noPart();
  FieldPart part = {.file = path, .header = (*file)->grids()[0].header};
  part.part = {numberOf(*part.header, kPartNumber), numberOf(*part.header, kPartCount)};
  for (int axis = 0; axis < 3; ++axis)
    part.points[axis] = numberOf(*part.header, kPartPoints[axis]);
  if (!isSound(part)) return noPart();
  auto lattice = latticeOf(*part.header, path.string());
  if (!lattice) return lattice.error();
  part.lattice = *lattice;
  if (auto good = checkVdbContents(path); !good) return good.error();
  part.identity = identityOf(part);
  return part;
}

/// How the field of a part differs from that of the first one; "" if it does not.
std::string differenceOf(const FieldPart& first, const FieldPart& other) {
  const auto valueIn = [](const FieldPart& part, const std::string& name) {
    const auto found = part.identity.find(name);
    return found == part.identity.end() ? "not there" : found->second;
  };
  Identity all = first.identity;
  all.insert(other.identity.begin(), other.identity.end());
  for (const auto& [name, ignored] : all) {
    const std::string own = valueIn(other, name);
    const std::string expected = valueIn(first, name);
    if (own == expected) continue;
    return fmt::format("its {} is {}, and that of {} is {}", name, own, first.file.string(),
                       expected);
  }
  return {};
}

/// Sorts the parts by their numbers; fails unless they are all parts of one field.
Result<void> putInOrder(std::vector<FieldPart>& parts) {
  for (const FieldPart& part : parts) {
    const std::string difference = differenceOf(parts.front(), part);
    if (!difference.empty()) {
      return invalid("is of another run: " + difference, part.file.string());
    }
  }
  const auto number = [](const FieldPart& part) { return part.part.number; };
  std::ranges::stable_sort(parts, {}, number);
  const std::uint64_t count = parts.front().part.count;
  const auto twice = std::ranges::adjacent_find(parts, {}, number);
  if (twice != parts.end()) {
    return invalid(fmt::format("part {} of {} is given twice, also as {}", number(*twice), count,
                               twice->file.string()),
                   std::next(twice)->file.string());
  }
  if (parts.size() == count) return {};
  std::size_t missing = 0;
  while (missing < parts.size() && number(parts[missing]) == missing + 1) ++missing;
  return invalid(fmt::format("part {} of {} is missing", missing + 1, count),
                 parts[std::min(missing, parts.size() - 1)].file.string());
}

/// Whether all values of a grid are at points of its part.
bool hasItsShare(const openvdb::GridBase& grid, const FieldPart& part) {
  const model::PartRange planes = planesOf(part.part, part.points[0]);
  const auto last = [](std::uint64_t count) { return static_cast<std::int32_t>(count) - 1; };
  const openvdb::CoordBBox share({static_cast<std::int32_t>(planes.begin), 0, 0},
                                 {last(planes.end), last(part.points[1]), last(part.points[2])});
  const openvdb::CoordBBox active = grid.evalActiveVoxelBoundingBox();
  return active.empty() || share.isInside(active);
}

/// Adds the values of a part. Tiles, which no part has, are left out.
template <class Grid>
void addLeaves(const Grid& part, Grid& field) {
  using Leaf = typename Grid::TreeType::LeafNodeType;
  for (auto leaf = part.tree().cbeginLeaf(); leaf; ++leaf) {
    if (leaf->getValueMask().isOff()) continue;
    auto own = std::make_unique<Leaf>(leaf->origin(), field.background());
    for (auto value = leaf->cbeginValueOn(); value; ++value) own->setValueOn(value.pos(), *value);
    field.tree().addLeaf(own.release());
  }
}

template <class Grid>
Result<openvdb::GridBase::Ptr> joinedGrid(const std::vector<FieldPart>& parts) {
  auto field = Grid::create(typename Grid::ValueType(0));
  field->setName(parts.front().header->getName());
  field->setTransform(parts.front().header->transformPtr());
  for (const FieldPart& part : parts) {
    auto file = VdbFile::open(part.file);
    if (!file) return file.error();
    auto read = (*file)->read(0, {.largeTree = std::numeric_limits<std::size_t>::max()});
    if (!read) return read.error();
    const auto grid = openvdb::gridConstPtrCast<Grid>(read->grid);
    if (!grid || !hasItsShare(*grid, part)) {
      return invalid("is damaged: it has values outside its part", part.file.string());
    }
    addLeaves(*grid, *field);
  }
  return field;
}

}  // namespace

Result<JoinedField> joinPointFields(std::span<const fs::path> parts, const fs::path& path) {
  std::vector<FieldPart> read;
  for (const fs::path& file : parts) {
    auto part = readPart(file);
    if (!part) return part.error();
    read.push_back(std::move(*part));
  }
  if (read.empty()) return invalid("no part of a field is to be joined");
  if (auto good = putInOrder(read); !good) return good.error();
  const FieldPart& first = read.front();
  const auto grid = first.header->isType<openvdb::FloatGrid>()
                        ? joinedGrid<openvdb::FloatGrid>(read)
                        : joinedGrid<openvdb::Int32Grid>(read);
  if (!grid) return grid.error();
  const auto bytes = writeVdb(path, *grid);
  if (!bytes) return bytes.error();
  return JoinedField{(*grid)->getName(), (*grid)->activeVoxelCount(), *bytes};
}

}  // namespace t4d::voxel4d
