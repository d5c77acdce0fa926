#include "formats/vtk/vtk_data.h"

#include "formats/t4d/names.h"
#include "model/attribute_rows.h"

namespace t4d::formats {

void VtkData::add(const VtkArray& data, model::Domain domain, std::uint64_t count,
                  std::size_t before, std::span<const std::uint32_t> rows) {
  auto& known = domain == model::Domain::Vertex ? ofPoints_ : ofCells_;
  constexpr std::uint64_t kMostComponents = 255;  // of .t4d
  const bool good = checkName(data.name) && VtkFile::scalarTypeOf(data) && data.components > 0 &&
                    data.components <= kMostComponents && skipped_.count(data.name) == 0;
  auto read = good ? vtk_.attribute(data, domain, count) : Result<model::Attribute>();
  if (read && !rows.empty()) *read = rowsOf(*read, rows);
  if (good && read && before == 0 && known.count(data.name) == 0) {
    known.emplace(data.name, std::move(*read));
    return;
  }
  const auto found = known.find(data.name);
  if (good && read && found != known.end() && found->second.rows() == before &&
      found->second.type == read->type && found->second.components == read->components) {
    found->second.values.insert(found->second.values.end(), read->values.begin(),
                                read->values.end());
    return;
  }
  known.erase(data.name);
  skipped_.insert(data.name);
}

std::vector<model::Attribute> VtkData::take(std::size_t points, std::size_t cells) {
  std::vector<model::Attribute> taken;
  for (const auto& [some, rows] : {std::pair{&ofPoints_, points}, std::pair{&ofCells_, cells}}) {
    for (auto& [name, attribute] : *some) {
      if (attribute.rows() == rows) {
        taken.push_back(std::move(attribute));
      } else {
        skipped_.insert(name);  // a piece does not have it
      }
    }
  }
  return taken;
}

}  // namespace t4d::formats
