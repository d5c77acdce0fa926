#include "formats/gltf/gltf_meshopt.h"

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <string>

#include <fmt/format.h>

#include "formats/gltf/gltf_member.h"
#include "formats/gltf/meshopt_pack.h"

namespace t4d::formats {
namespace {

using nlohmann::json;

std::string wordMember(const json& object, const char* member, const char* otherwise) {
  const auto found = object.find(member);
  return found != object.end() && found->is_string() ? found->get<std::string>()
                                                     : std::string(otherwise);
}

class Unpacker {
 public:
  explicit Unpacker(const std::vector<tinygltf::Buffer>& buffers) : buffers_(buffers) {
    for (const auto& buffer : buffers) budget_ += buffer.data.size();
  }

  Result<std::vector<unsigned char>> unpacked(const json& extension) {
    if (!extension.is_object()) return invalid("its extension is not an object");
    const auto number = wholeMember(extension, "buffer");
    const auto offset = wholeMember(extension, "byteOffset", 0);
    const auto length = wholeMember(extension, "byteLength");
    const auto stride = wholeMember(extension, "byteStride");
    const auto count = wholeMember(extension, "count");
    if (!number || !offset || !length || !stride || !count) {
      return invalid("its extension lacks one of buffer, byteLength, byteStride and count");
    }
    if (*number >= buffers_.size()) {
      return invalid(fmt::format("is in buffer {}, but there are {}", *number, buffers_.size()));
    }
    const auto& data = buffers_[*number].data;
    if (*offset > data.size() || *length > data.size() - *offset) {
      return invalid(fmt::format("is {} bytes from byte {}, but buffer {} has {}", *length, *offset,
                                 *number, data.size()));
    }
    // Views that share their bytes would make any amount of memory of a small file.
    if (*length > budget_) return invalid("buffer views share compressed bytes");
    budget_ -= *length;
    const std::string mode = wordMember(extension, "mode", "");
    const std::string filter = wordMember(extension, "filter", "NONE");
    return meshoptUnpacked({data.data() + *offset, *length}, {*count, *stride, mode, filter});
  }

 private:
  const std::vector<tinygltf::Buffer>& buffers_;
  std::uint64_t budget_ = 0;
};

}  // namespace

void unpackMeshoptViews(json& document, std::vector<tinygltf::Buffer>& buffers) {
  const auto views = document.find("bufferViews");
  if (views == document.end() || !views->is_array()) return;
  Unpacker unpacker(buffers);
  std::vector<tinygltf::Buffer> made;
  for (json& view : *views) {
    if (!view.is_object() || !view.contains("extensions")) continue;
    json& extensions = view["extensions"];
    for (const std::string_view name : kMeshoptExtensions) {
      if (!extensions.is_object() || !extensions.contains(name)) continue;
      auto bytes = unpacker.unpacked(extensions[std::string(name)]);
      if (!bytes) {
        extensions[std::string(name)] = {{kMeshoptProblem, bytes.error().message}};
        continue;
      }
      view["buffer"] = buffers.size() + made.size();
      view["byteOffset"] = 0;
      view["byteLength"] = bytes->size();
      extensions.erase(std::string(name));
      made.emplace_back();
      made.back().data = std::move(*bytes);
    }
  }
  std::ranges::move(made, std::back_inserter(buffers));
}

}  // namespace t4d::formats
