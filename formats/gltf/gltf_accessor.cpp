#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include <fmt/format.h>

#include "formats/gltf/gltf_meshopt.h"
#include "formats/gltf/gltf_model.h"

namespace t4d::formats {
namespace {

/// Elements in a buffer, checked to lie within it.
struct Elements {
  const unsigned char* first = nullptr;
  std::size_t stride = 0;  // bytes
  int componentType = 0;
  bool normalized = false;

  double number(std::size_t element, std::size_t component) const {
    const auto* from = reinterpret_cast<const char*>(first + element * stride);
    switch (componentType) {
      case TINYGLTF_COMPONENT_TYPE_BYTE:
        return integer<std::int8_t>(from + component);
      case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
        return integer<std::uint8_t>(from + component);
      case TINYGLTF_COMPONENT_TYPE_SHORT:
        return integer<std::int16_t>(from + 2 * component);
      case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
        return integer<std::uint16_t>(from + 2 * component);
      case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
        return integer<std::uint32_t>(from + 4 * component);
      default:
        return loadNumber<float>(from + 4 * component);
    }
  }

 private:
  template <class T>
  double integer(const char* from) const {
    const double value = loadNumber<T>(from);
    if (!normalized) return value;
    return std::max(value / std::numeric_limits<T>::max(), -1.0);
  }
};

/// Bytes of a number; 0 for a type that glTF 2.0 does not have in accessors.
std::size_t componentBytes(int type) {
  switch (type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return 1;
    case TINYGLTF_COMPONENT_TYPE_SHORT:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return 2;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
    case TINYGLTF_COMPONENT_TYPE_FLOAT:
      return 4;
    default:
      return 0;
  }
}

class AccessorReader {
 public:
  AccessorReader(const tinygltf::Model& model, Place where)
      : model_(model), where_(std::move(where)) {}

  Result<std::vector<double>> read(const tinygltf::Accessor& accessor, int components) const {
    const int found = tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(accessor.type));
    if (found != components) {
      return invalid(fmt::format("elements of {} numbers, expected {}", found, components), where_);
    }
    const auto width = static_cast<std::size_t>(components);
    std::vector<double> numbers;
    if (accessor.bufferView >= 0) {
      const auto elements = locate(accessor.bufferView, accessor.byteOffset, accessor.componentType,
                                   width, accessor.count);
      if (!elements) return elements.error();
      numbers.reserve(accessor.count * width);
      copy(*elements, accessor, width, numbers);
    } else {
      // All zeros: the file gives only their count, which must be limited.
      if (!accessor.sparse.isSparse || accessor.count > bufferBytes()) {
        return invalid(fmt::format("{} elements without a buffer view", accessor.count), where_);
      }
      numbers.assign(accessor.count * width, 0.0);
    }
    if (accessor.sparse.isSparse) {
      if (auto done = putSparse(accessor, width, numbers); !done) return done.error();
    }
    return numbers;
  }

 private:
  std::size_t bufferBytes() const {
    std::size_t sum = 0;
    for (const auto& buffer : model_.buffers) sum += buffer.data.size();
    return sum;
  }

  /// Why the compressed bytes of a view are not there (unpackMeshoptViews).
  std::optional<Error> notUnpacked(const tinygltf::BufferView& view, int index) const {
    for (const std::string_view name : kMeshoptExtensions) {
      const auto found = view.extensions.find(std::string(name));
      if (found == view.extensions.end() || !found->second.Has(kMeshoptProblem)) continue;
      return fail(ErrorCode::Unsupported,
                  fmt::format("buffer view {} is compressed by {} and cannot be unpacked: {}",
                              index, name, found->second.Get(kMeshoptProblem).Get<std::string>()),
                  where_, gltfRemedyFor(name));
    }
    return std::nullopt;
  }

  Result<Elements> locate(int viewIndex, std::size_t offset, int componentType, std::size_t width,
                          std::size_t count) const {
    const std::size_t elementBytes = componentBytes(componentType) * width;
    if (elementBytes == 0) {
      return invalid(fmt::format("component type {}, which glTF 2.0 does not have", componentType),
                     where_);
    }
    if (viewIndex < 0 || static_cast<std::size_t>(viewIndex) >= model_.bufferViews.size()) {
      return invalid(fmt::format("refers to buffer view {}, but there are {}", viewIndex,
                                 model_.bufferViews.size()),
                     where_);
    }
    const auto& view = model_.bufferViews[static_cast<std::size_t>(viewIndex)];
    if (view.buffer < 0 || static_cast<std::size_t>(view.buffer) >= model_.buffers.size()) {
      return invalid(fmt::format("buffer view {} refers to buffer {}, but there are {}", viewIndex,
                                 view.buffer, model_.buffers.size()),
                     where_);
    }
    const auto& data = model_.buffers[static_cast<std::size_t>(view.buffer)].data;
    if (data.empty()) {
      if (auto packed = notUnpacked(view, viewIndex)) return *packed;
      return invalid(fmt::format("buffer view {} refers to buffer {}, which has no data", viewIndex,
                                 view.buffer),
                     where_);
    }
    if (view.byteOffset > data.size() || view.byteLength > data.size() - view.byteOffset) {
      return invalid(fmt::format("buffer view {} is {} bytes from byte {}, but its buffer has {}",
                                 viewIndex, view.byteLength, view.byteOffset, data.size()),
                     where_);
    }
    const std::size_t stride = view.byteStride == 0 ? elementBytes : view.byteStride;
    // Divisions, because products of numbers from a file may overflow.
    const bool fits =
        count == 0 || (offset <= view.byteLength && elementBytes <= view.byteLength - offset &&
                       count - 1 <= (view.byteLength - offset - elementBytes) / stride);
    if (!fits) {
      return invalid(fmt::format("{} elements of {} bytes from byte {}, {} bytes apart, but buffer "
                                 "view {} has {} bytes",
                                 count, elementBytes, offset, stride, viewIndex, view.byteLength),
                     where_);
    }
    return Elements{data.data() + view.byteOffset + offset, stride, componentType, false};
  }

  static void copy(Elements elements, const tinygltf::Accessor& accessor, std::size_t width,
                   std::vector<double>& numbers) {
    elements.normalized = accessor.normalized;
    for (std::size_t i = 0; i < accessor.count; ++i) {
      for (std::size_t j = 0; j < width; ++j) numbers.push_back(elements.number(i, j));
    }
  }

  Result<void> putSparse(const tinygltf::Accessor& accessor, std::size_t width,
                         std::vector<double>& numbers) const {
    const auto& sparse = accessor.sparse;
    const auto nonNegative = [](int value) { return static_cast<std::size_t>(std::max(value, 0)); };
    const std::size_t count = nonNegative(sparse.count);
    const auto indices = locate(sparse.indices.bufferView, nonNegative(sparse.indices.byteOffset),
                                sparse.indices.componentType, 1, count);
    if (!indices) return indices.error();
    auto values = locate(sparse.values.bufferView, nonNegative(sparse.values.byteOffset),
                         accessor.componentType, width, count);
    if (!values) return values.error();
    values->normalized = accessor.normalized;
    for (std::size_t i = 0; i < count; ++i) {
      const double index = indices->number(i, 0);
      if (!(index >= 0 && index < static_cast<double>(accessor.count)) ||
          index != std::floor(index)) {
        return invalid(
            fmt::format("sparse element {} stands for element {} of {}", i, index, accessor.count),
            where_);
      }
      const auto at = static_cast<std::size_t>(index) * width;
      for (std::size_t j = 0; j < width; ++j) numbers[at + j] = values->number(i, j);
    }
    return {};
  }

  const tinygltf::Model& model_;
  Place where_;
};

}  // namespace

Result<std::vector<double>> readGltfAccessor(const InputFile& file, const tinygltf::Model& model,
                                             int accessor, int components) {
  const Place where = gltfElement(file, "accessors", accessor);
  if (accessor < 0 || static_cast<std::size_t>(accessor) >= model.accessors.size()) {
    return invalid(fmt::format("does not exist; there are {}", model.accessors.size()), where);
  }
  return AccessorReader(model, where)
      .read(model.accessors[static_cast<std::size_t>(accessor)], components);
}

}  // namespace t4d::formats
