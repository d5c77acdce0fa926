#include "formats/gltf/gltf_looks.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include <fmt/format.h>

#include "model/amount_text.h"

namespace t4d::formats {
namespace {

using Part = GltfGeometry::Part;

/// The accessors of one attribute: null where a part has none.
struct LookAccessors {
  std::vector<const tinygltf::Accessor*> ofParts;
  std::vector<int> numbers;
  std::size_t missing = 0;
  bool good = true;
};

LookAccessors lookAccessors(const tinygltf::Model& model, std::span<const Part> parts,
                            const std::string& name, std::initializer_list<int> types) {
  LookAccessors found;
  for (const Part& part : parts) {
    const auto attribute = part.primitive->attributes.find(name);
    const bool has = attribute != part.primitive->attributes.end();
    const int number = has ? attribute->second : -1;
    const auto* accessor = elementAt(model.accessors, number);
    found.ofParts.push_back(accessor);
    found.numbers.push_back(number);
    found.missing += !has;
    if (!has) continue;
    if (accessor == nullptr || accessor->count != part.pointCount ||
        std::ranges::find(types, accessor->type) == types.end()) {
      found.good = false;
    }
  }
  return found;
}

void append(model::Attribute& rows, double number) {
  const auto put = [&](const auto value) {
    const auto* bytes = reinterpret_cast<const std::byte*>(&value);
    rows.values.insert(rows.values.end(), bytes, bytes + sizeof value);
  };
  if (rows.type == model::ScalarType::Float32) return put(static_cast<float>(number));
  put(static_cast<std::uint16_t>(std::lround(65535 * std::clamp(number, 0.0, 1.0))));
}

}  // namespace

GltfLooks readGltfLooks(const InputFile& file, const tinygltf::Model& model,
                        std::span<const Part> parts) {
  GltfLooks looks;
  const auto read = [&](const std::string& name, const LookAccessors& from, model::Attribute rows,
                        double filling, std::string_view fillingText) {
    if (!from.good || from.missing == parts.size()) return;
    const bool isUv = rows.name == "uv";
    for (std::size_t i = 0; i < parts.size(); ++i) {
      if (from.ofParts[i] == nullptr) {
        for (std::size_t k = 0; k < parts[i].pointCount * rows.components; ++k) {
          append(rows, filling);
        }
        continue;
      }
      const int components =
          tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(from.ofParts[i]->type));
      const auto numbers = readGltfAccessor(file, model, from.numbers[i], components);
      if (!numbers) return;
      for (std::size_t point = 0; point < parts[i].pointCount; ++point) {
        for (int k = 0; k < static_cast<int>(rows.components); ++k) {
          // Opaque, where others have opacity.
          const double number = k < components
                                    ? (*numbers)[point * static_cast<std::size_t>(components) +
                                                 static_cast<std::size_t>(k)]
                                    : 1;
          append(rows, isUv && k == 1 ? 1 - number : number);
        }
      }
    }
    if (from.missing > 0) {
      looks.notices.push_back(fmt::format(
          "{} without {}: {} there", model::counted(from.missing, "primitive"), name, fillingText));
    }
    looks.rows.push_back(std::move(rows));
    looks.names.insert(name);
  };

  const auto colors =
      lookAccessors(model, parts, "COLOR_0", {TINYGLTF_TYPE_VEC3, TINYGLTF_TYPE_VEC4});
  bool isFloat = false;
  std::uint32_t components = 3;
  for (const auto* accessor : colors.ofParts) {
    if (accessor == nullptr) continue;
    isFloat = isFloat || accessor->componentType == TINYGLTF_COMPONENT_TYPE_FLOAT;
    if (accessor->type == TINYGLTF_TYPE_VEC4) components = 4;
  }
  const auto colorType = isFloat ? model::ScalarType::Float32 : model::ScalarType::UInt16;
  read("COLOR_0", colors, {"color", model::Domain::Vertex, colorType, components, {}}, 1, "white");
  const auto uv = lookAccessors(model, parts, "TEXCOORD_0", {TINYGLTF_TYPE_VEC2});
  read("TEXCOORD_0", uv, {"uv", model::Domain::Vertex, model::ScalarType::Float32, 2, {}}, 0,
       "0 0");
  return looks;
}

}  // namespace t4d::formats
