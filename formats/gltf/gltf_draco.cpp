#include "formats/gltf/gltf_draco.h"

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>

#include <fmt/format.h>

#include "formats/gltf/draco_unpack.h"
#include "formats/gltf/gltf_member.h"
#include "formats/gltf/gltf_model.h"

namespace t4d::formats {
namespace {

using nlohmann::json;

/// The types of accessors that attributes of vertices have.
constexpr std::array<std::pair<std::string_view, std::uint64_t>, 4> kAttributeTypes = {
    std::pair{"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}};

/// The contents of the extension of a primitive.
struct DracoPrimitive {
  std::uint64_t bufferView = 0;
  DracoMesh mesh;
  /// Names in the primitive, and accessors without data, of the mesh's attributes.
  std::vector<std::pair<std::string, json>> accessors;
};

class DracoUnpacker {
 public:
  DracoUnpacker(json& document, std::vector<tinygltf::Buffer>& buffers)
      : document_(document), buffers_(buffers) {
    for (const auto& buffer : buffers) budget_ += buffer.data.size();
  }

  Result<void> unpack(json& primitive, const json& extension) {
    auto read = readExtension(primitive, extension);
    if (!read) return read.error();
    const auto unpacked = unpackMesh(*read);
    if (!unpacked) return unpacked.error();
    const auto& [firstView, cornerCount] = *unpacked;
    if (const json* indices = accessorAt(primitive, "indices")) {
      const auto count = wholeMember(*indices, "count");
      if (wholeMember(primitive, "mode", kTriangles) == kTriangles && count != cornerCount) {
        return invalid(fmt::format("it has {} corners of triangles, but the accessor {}",
                                   cornerCount, count.value_or(0)));
      }
    }
    std::uint64_t view = firstView;
    for (auto& [name, accessor] : read->accessors) {
      accessor.erase("byteOffset");
      accessor["bufferView"] = view++;
      primitive["attributes"][name] = addElement("accessors", std::move(accessor));
    }
    primitive["mode"] = kTriangles;
    primitive["indices"] = addElement("accessors", {{"bufferView", view},
                                                    {"componentType", kIndexType},
                                                    {"count", cornerCount},
                                                    {"type", "SCALAR"}});
    return {};
  }

  /// Whether the compressed data is there without compression, too.
  bool isPlain(const json& primitive) const {
    const auto attributes = primitive.find("attributes");
    if (attributes == primitive.end() || !attributes->is_object()) return false;
    const json* position = accessorAt(*attributes, "POSITION");
    const json* indices = accessorAt(primitive, "indices");
    return position != nullptr && position->contains("bufferView") &&
           (indices == nullptr || indices->contains("bufferView"));
  }

 private:
  static constexpr std::uint64_t kTriangles = TINYGLTF_MODE_TRIANGLES;
  static constexpr int kIndexType = TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
  static constexpr std::size_t kIndexBytes = 4;
  static constexpr auto kLastId = std::numeric_limits<std::uint32_t>::max();

  const json* accessorAt(const json& object, const char* member) const {
    return objectAt(std::as_const(document_), "accessors", wholeMember(object, member));
  }

  /// Returns its number.
  std::uint64_t addElement(const char* array, json element) {
    document_[array].push_back(std::move(element));
    return document_[array].size() - 1;
  }

  Result<DracoPrimitive> readExtension(const json& primitive, const json& extension) const {
    DracoPrimitive read;
    const auto attributes = primitive.find("attributes");
    if (!extension.is_object() || !wholeMember(extension, "bufferView") ||
        !extension.contains("attributes") || !extension["attributes"].is_object() ||
        attributes == primitive.end() || !attributes->is_object()) {
      return invalid("its extension lacks bufferView or attributes");
    }
    read.bufferView = extension["bufferView"].get<std::uint64_t>();
    const auto bytes = bytesOf(read.bufferView);
    if (!bytes) return bytes.error();
    read.mesh.bytes = *bytes;
    for (const auto& [name, id] : extension["attributes"].items()) {
      const json* accessor = accessorAt(*attributes, name.c_str());
      if (accessor == nullptr) {
        return invalid(
            fmt::format("its extension has {}, but the primitive has no such accessor", name));
      }
      const auto count = wholeMember(*accessor, "count");
      const auto componentType = wholeMember(*accessor, "componentType");
      const auto type = std::ranges::find_if(kAttributeTypes, [&](const auto& row) {
        return accessor->value("type", json()) == row.first;
      });
      const bool isNumber = id.is_number_unsigned() && id <= kLastId;
      if (!count || !componentType || type == kAttributeTypes.end() || !isNumber) {
        return invalid(fmt::format("{} lacks a number, count, component type or type", name));
      }
      if (!read.accessors.empty() && *count != read.mesh.pointCount) {
        return invalid(fmt::format("{} has {} elements, but {} has {}", name, *count,
                                   read.accessors.front().first, read.mesh.pointCount));
      }
      read.mesh.pointCount = *count;
      read.mesh.attributes.push_back(
          {id.get<std::uint32_t>(), static_cast<int>(*componentType), type->second});
      read.accessors.emplace_back(name, *accessor);
    }
    if (read.accessors.empty()) return invalid("its extension names no attributes");
    return read;
  }

  Result<std::span<const unsigned char>> bytesOf(std::uint64_t number) const {
    const json* view = objectAt(std::as_const(document_), "bufferViews", number);
    if (view == nullptr) return invalid(fmt::format("buffer view {} does not exist", number));
    const auto buffer = wholeMember(*view, "buffer");
    const auto offset = wholeMember(*view, "byteOffset", 0);
    const auto length = wholeMember(*view, "byteLength");
    if (!buffer || !offset || !length || *buffer >= buffers_.size()) {
      return invalid(fmt::format("buffer view {} is in no buffer", number));
    }
    const auto& data = buffers_[*buffer].data;
    if (*offset > data.size() || *length > data.size() - *offset) {
      return invalid(fmt::format("buffer view {} is {} bytes from byte {}, but its buffer has {}",
                                 number, *length, *offset, data.size()));
    }
    return std::span(data).subspan(*offset, *length);
  }

  /// The first of the buffer views with the arrays of a mesh, and the number of its corners.
  using Unpacked = std::pair<std::uint64_t, std::uint64_t>;

  Result<Unpacked> unpackMesh(const DracoPrimitive& primitive) {
    const DracoMesh& mesh = primitive.mesh;
    const auto key = std::tuple(primitive.bufferView, mesh.pointCount, mesh.attributes);
    if (const auto found = unpacked_.find(key); found != unpacked_.end()) return found->second;
    // Primitives that share bytes would make any amount of memory of a small file.
    if (mesh.bytes.size() > budget_) return invalid("primitives take different parts of one mesh");
    budget_ -= mesh.bytes.size();
    auto arrays = dracoUnpacked(mesh);
    if (!arrays) return arrays.error();
    const std::uint64_t buffer = buffers_.size();
    std::uint64_t offset = 0;
    const auto addView = [&](std::uint64_t bytes) {
      const std::uint64_t view = addElement(
          "bufferViews", {{"buffer", buffer}, {"byteOffset", offset}, {"byteLength", bytes}});
      offset += bytes;
      return view;
    };
    const std::uint64_t first = document_["bufferViews"].size();
    for (const DracoAttribute& attribute : mesh.attributes) {
      const int width =
          tinygltf::GetComponentSizeInBytes(static_cast<std::uint32_t>(attribute.componentType));
      addView(mesh.pointCount * attribute.components * static_cast<std::uint64_t>(width));
    }
    const std::uint64_t cornerBytes = arrays->size() - offset;
    addView(cornerBytes);
    buffers_.emplace_back();
    buffers_.back().data = std::move(*arrays);
    return unpacked_[key] = {first, cornerBytes / kIndexBytes};
  }

  json& document_;
  std::vector<tinygltf::Buffer>& buffers_;
  std::uint64_t budget_ = 0;
  std::map<std::tuple<std::uint64_t, std::uint64_t, std::vector<DracoAttribute>>, Unpacked>
      unpacked_;
};

}  // namespace

Result<void> unpackDracoPrimitives(const InputFile& file, json& document,
                                   std::vector<tinygltf::Buffer>& buffers) {
  const auto meshes = document.find("meshes");
  if (meshes == document.end() || !meshes->is_array()) return {};
  DracoUnpacker unpacker(document, buffers);
  for (std::size_t i = 0; i < meshes->size(); ++i) {
    json& mesh = (*meshes)[i];
    if (!mesh.is_object() || !mesh.contains("primitives")) continue;
    for (std::size_t j = 0; j < mesh["primitives"].size(); ++j) {
      json* primitive = objectAt(mesh, "primitives", j);
      if (primitive == nullptr || !primitive->contains("extensions")) continue;
      json& extensions = (*primitive)["extensions"];
      if (!extensions.is_object() || !extensions.contains(kDracoExtension)) continue;
      const json extension = extensions[kDracoExtension];
      extensions.erase(kDracoExtension);
      if (unpacker.isPlain(*primitive)) continue;
      if (auto done = unpacker.unpack(*primitive, extension); !done) {
        return fail(
            done.error().code,
            fmt::format("is compressed by {} and cannot be unpacked: {}", kDracoExtension,
                        done.error().message),
            gltfElement(file, "meshes", static_cast<int>(i), fmt::format(".primitives[{}]", j)),
            gltfRemedyFor(kDracoExtension));
      }
    }
  }
  return {};
}

}  // namespace t4d::formats
