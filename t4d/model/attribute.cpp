#include "t4d/model/attribute.h"

namespace t4d::model {

std::size_t scalarSize(ScalarType type) {
  switch (type) {
    case ScalarType::UInt8:
    case ScalarType::Int8:
      return 1;
    case ScalarType::UInt16:
    case ScalarType::Int16:
      return 2;
    case ScalarType::UInt32:
    case ScalarType::Int32:
    case ScalarType::Float32:
      return 4;
    case ScalarType::UInt64:
    case ScalarType::Int64:
    case ScalarType::Float64:
      return 8;
  }
  return 0;
}

std::vector<Attribute> vertexRows(std::span<const Attribute> attributes, std::size_t first,
                                  std::size_t count) {
  std::vector<Attribute> cut;
  for (const Attribute& attribute : attributes) {
    if (attribute.domain != Domain::Vertex) continue;
    const std::byte* const begin = attribute.row(first);
    cut.push_back({attribute.name,
                   Domain::Vertex,
                   attribute.type,
                   attribute.components,
                   {begin, begin + count * attribute.rowBytes()}});
  }
  return cut;
}

}  // namespace t4d::model
