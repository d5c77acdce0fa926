#include "edit/derived_keys.h"

#include <utility>

#include <fmt/format.h>

#include "edit/thicken_sheets.h"

namespace t4d::edit {

using model::Point3;

KeysOfOrigins::KeysOfOrigins(std::shared_ptr<const model::VertexKeys> all, std::size_t vertices,
                             std::vector<VertexOrigin> origins, std::vector<MergedPair> merged,
                             std::shared_ptr<const std::vector<Point3>> mesh)
    : all_(std::move(all)),
      places_(vertices),
      origins_(std::move(origins)),
      merged_(std::move(merged)),
      mesh_(std::move(mesh)) {}

Result<void> KeysOfOrigins::positions(std::uint64_t key, std::span<Point3> into) const {
  if (const auto matrix = pose(key)) {  // which leaves the shape as it is
    for (std::size_t i = 0; i < into.size(); ++i) into[i] = model::posed(*matrix, (*mesh_)[i]);
    return {};
  }
  if (auto read = all_->positions(key, places_); !read) return read;
  for (const MergedPair& pair : merged_) {
    const double apart = (places_[pair.gone] - places_[pair.kept]).cwiseAbs().maxCoeff();
    if (apart <= pair.apart) continue;
    return invalid(fmt::format("vertices {} and {} were merged, but are {:.6g} apart at time {}",
                               pair.kept, pair.gone, apart, time(key)),
                   {}, Remedy::Motion);
  }
  for (std::size_t i = 0; i < origins_.size(); ++i) into[i] = middleOf(places_, origins_[i]);
  return {};
}

KeysOfThickSheets::KeysOfThickSheets(std::shared_ptr<const model::VertexKeys> all,
                                     std::vector<model::Triangle> triangles,
                                     std::vector<std::uint32_t> sheet, double thickness)
    : all_(std::move(all)),
      triangles_(std::move(triangles)),
      sheet_(std::move(sheet)),
      thickness_(thickness) {}

Result<void> KeysOfThickSheets::positions(std::uint64_t key, std::span<Point3> into) const {
  if (auto read = all_->positions(key, into.first(into.size() - sheet_.size())); !read) return read;
  placeSides(into, triangles_, sheet_, thickness_);
  return {};
}

}  // namespace t4d::edit
