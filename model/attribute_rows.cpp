#include "model/attribute_rows.h"

namespace t4d::model {

Attribute rowsOf(const Attribute& attribute, std::span<const std::uint32_t> rows) {
  Attribute made{attribute.name, attribute.domain, attribute.type, attribute.components, {}};
  const std::size_t bytes = attribute.rowBytes();
  made.values.reserve(rows.size() * bytes);
  for (const std::uint32_t row : rows) {
    made.values.insert(made.values.end(), attribute.row(row), attribute.row(row) + bytes);
  }
  return made;
}

void selectRows(std::vector<Attribute>& attributes, Domain domain,
                std::span<const std::uint32_t> rows) {
  for (Attribute& attribute : attributes) {
    if (attribute.domain == domain) attribute = rowsOf(attribute, rows);
  }
}

}  // namespace t4d::model
