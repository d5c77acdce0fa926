#include "formats/gltf/gltf_material_names.h"

#include <fmt/format.h>

#include "formats/gltf/gltf_builder.h"
#include "formats/gltf/gltf_model.h"
#include "formats/t4d/names.h"
#include "formats/triangle/written_mesh.h"

namespace t4d::formats {

std::uint32_t GltfMaterialNames::numberOf(int material) {
  const auto* found = elementAt(model_.materials, material);
  if (found == nullptr) return 0;
  const std::string& name = found->name;
  if (model_.asset.generator == kGltfGenerator &&
      (name == kGltfPlainMaterial || name.starts_with(kGltfColorMaterial))) {
    return 0;
  }
  const auto [number, added] =
      numbers_.try_emplace(material, static_cast<std::uint32_t>(names_.size()));
  if (added) names_.push_back(name.empty() ? fmt::format("material {}", material) : asName(name));
  return number->second;
}

void GltfMaterialNames::addTo(model::TriangleMesh& mesh, std::span<const GltfGeometry::Part> parts,
                              std::span<const std::uint32_t> partOf) {
  std::vector<std::uint32_t> ofParts;
  for (const GltfGeometry::Part& part : parts) {
    ofParts.push_back(numberOf(part.primitive->material));
  }
  std::vector<std::uint32_t> numbers;
  numbers.reserve(partOf.size());
  bool hasAny = false;
  for (const std::uint32_t part : partOf) {
    numbers.push_back(ofParts[part]);
    hasAny = hasAny || ofParts[part] != 0;
  }
  if (!hasAny) return;
  mesh.attributes.push_back(model::makeAttribute(kMaterial, model::Domain::Cell, numbers));
}

std::vector<std::string> GltfMaterialNames::names() const {
  return names_.size() > 1 ? names_ : std::vector<std::string>();
}

}  // namespace t4d::formats
