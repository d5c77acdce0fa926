#include "formats/gltf/gltf_model.h"

#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <string_view>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "formats/gltf/draco_unpack.h"
#include "formats/gltf/gltf_buffers.h"
#include "formats/gltf/gltf_draco.h"
#include "formats/gltf/gltf_meshopt.h"
#include "formats/text/json_check.h"
#include "formats/text/json_object.h"
#include "t4d/surface.h"

namespace t4d::formats {
namespace {

using nlohmann::json;

constexpr std::size_t kGlbHeaderBytes = 20;  // magic, version, length; length and type of the JSON
// tinygltf takes the length of a text as a 32-bit number.
constexpr std::size_t kMostTextBytes = std::numeric_limits<std::int32_t>::max();
constexpr std::size_t kMostBinaryBytes = std::numeric_limits<std::uint32_t>::max();

constexpr std::size_t kChunkHeaderBytes = 8;

/// The parts of a file.
struct Container {
  std::string_view json;
  std::optional<std::string_view> binary;  ///< the chunk after the JSON; nothing if there is none
};

/// The chunk of a .glb after its JSON. Bytes that follow it are ignored, as the specification asks.
Result<std::optional<std::string_view>> binaryChunkOf(const InputFile& file, std::size_t begin,
                                                      std::size_t end) {
  std::optional<std::string_view> chunk;
  if (end - begin < kChunkHeaderBytes) return chunk;
  const std::string_view bytes = file.bytes;
  const auto size = loadNumber<std::uint32_t>(bytes.data() + begin);
  if (bytes.substr(begin + 4, 4) != std::string_view("BIN\0", 4)) return chunk;
  begin += kChunkHeaderBytes;
  if (size > end - begin) {
    return invalid(
        fmt::format("declares {} bytes of binary data; only {} follow", size, end - begin),
        file.atByte(begin - kChunkHeaderBytes));
  }
  chunk = bytes.substr(begin, size);
  return chunk;
}

/// Checks the container.
Result<Container> containerOf(const InputFile& file) {
  const std::string_view bytes = file.bytes;
  if (!bytes.starts_with("glTF")) {
    if (bytes.size() > kMostTextBytes) {
      return fail(ErrorCode::Unsupported, "text glTF of more than 2 GiB is not supported; use .glb",
                  file.path.string());
    }
    return Container{bytes, {}};
  }
  if (bytes.size() < kGlbHeaderBytes) {
    return invalid(fmt::format("the file ends in the header of {} bytes", kGlbHeaderBytes),
                   file.atByte(bytes.size()));
  }
  if (bytes.size() > kMostBinaryBytes) {
    return fail(ErrorCode::Unsupported, "is larger than the 4 GiB that a .glb can have",
                file.path.string());
  }
  const auto number = [&](std::size_t at) { return loadNumber<std::uint32_t>(bytes.data() + at); };
  if (number(4) != 2) {
    return fail(ErrorCode::Unsupported,
                fmt::format("is version {} of binary glTF, expected 2", number(4)), file.atByte(4));
  }
  if (number(8) > bytes.size()) {
    return invalid(
        fmt::format("declares a length of {} bytes; the file has {}", number(8), bytes.size()),
        file.atByte(8));
  }
  if (number(12) > bytes.size() - kGlbHeaderBytes) {
    return invalid(fmt::format("declares {} bytes of JSON; only {} follow", number(12),
                               bytes.size() - kGlbHeaderBytes),
                   file.atByte(12));
  }
  if (bytes.substr(16, 4) != "JSON") {
    return invalid("its first chunk is not JSON", file.atByte(16));
  }
  const std::size_t end = kGlbHeaderBytes + number(12);
  const auto binary = binaryChunkOf(file, end, bytes.size());
  if (!binary) return binary.error();
  return Container{bytes.substr(kGlbHeaderBytes, number(12)), *binary};
}

/// Members that tinygltf takes for missing if they are not whole numbers.
constexpr std::array<std::string_view, 3> kWholeNumbers = {"byteLength", "byteOffset",
                                                           "byteStride"};

std::string oneLine(std::string text) {
  while (!text.empty() && text.back() == '\n') text.pop_back();
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

Result<json> parsedJson(const InputFile& file, std::string_view text) {
  try {
    json document = json::parse(text);
    if (document.is_object()) return document;
    return invalid("is not glTF 2.0: its JSON is not an object", file.path.string());
  } catch (const json::parse_error& error) {
    const auto begin = static_cast<std::size_t>(text.data() - file.bytes.data());
    const std::size_t byte = begin + (error.byte > 0 ? error.byte - 1 : 0);
    return invalid(fmt::format("is not glTF 2.0: its JSON has a {}", jsonMessage(error)),
                   file.atByte(byte));
  } catch (const json::exception& error) {
    return invalid(fmt::format("is not glTF 2.0: its JSON has a {}", jsonMessage(error)),
                   file.path.string());
  }
}

std::size_t sizeOfArray(const json& document, const char* member) {
  const auto found = document.find(member);
  return found != document.end() && found->is_array() ? found->size() : 0;
}

/// Gives channels of animations that move no node the number -1, without which tinygltf leaves them
/// out: their extension says what they move.
void numberTargets(json& document) {
  const auto found = document.find("animations");
  if (found == document.end() || !found->is_array()) return;
  for (json& animation : *found) {
    if (!animation.is_object() || !animation.contains("channels")) continue;
    for (json& channel : animation["channels"]) {
      if (!channel.is_object() || !channel.contains("target")) continue;
      json& target = channel["target"];
      if (target.is_object() && !target.contains("node")) target["node"] = -1;
    }
  }
}

/// Extensions that are read, and prefixes of those that do not change positions and triangles.
bool isSupported(std::string_view extension) {
  constexpr std::string_view kStarts[] = {"KHR_materials_",        "KHR_texture_",
                                          "EXT_texture_",          "KHR_lights_",
                                          "KHR_mesh_quantization", "EXT_mesh_gpu_instancing",
                                          "KHR_animation_pointer", "KHR_node_visibility"};
  const auto begins = [&](std::string_view start) { return extension.starts_with(start); };
  return std::ranges::any_of(kStarts, begins) || (hasMeshopt() && isMeshopt(extension)) ||
         (hasDraco() && extension == kDracoExtension);
}

/// Fails for other versions of glTF, and for documents that cannot be read right without an
/// extension that is not supported.
Result<void> checkVersionAndExtensions(const InputFile& file, const json& document) {
  const auto asset = document.find("asset");
  if (asset != document.end() && asset->is_object() && asset->contains("version")) {
    const json& version = (*asset)["version"];
    if (version.is_string() && !version.get_ref<const std::string&>().starts_with("2.")) {
      return fail(ErrorCode::Unsupported,
                  fmt::format("is glTF version '{}', expected 2.0", version.get<std::string>()),
                  file.path.string());
    }
  }
  const auto required = document.find("extensionsRequired");
  if (required == document.end() || !required->is_array()) return {};
  for (const json& extension : *required) {
    if (!extension.is_string()) continue;
    const auto& name = extension.get_ref<const std::string&>();
    if (isSupported(name)) continue;
    return fail(ErrorCode::Unsupported,
                fmt::format("requires the extension {}, which is not supported", name),
                file.path.string(), gltfRemedyFor(name));
  }
  return {};
}

}  // namespace

Result<GltfModel> loadGltfModel(const InputFile& file) {
  const auto container = containerOf(file);
  if (!container) return container.error();
  if (auto good = checkJson(container->json, file.path.string(), {.wholeNumbers = kWholeNumbers});
      !good) {
    return good.error();
  }
  auto document = parsedJson(file, container->json);
  if (!document) return document.error();
  if (auto good = checkVersionAndExtensions(file, *document); !good) return good.error();
  auto buffers = loadGltfBuffers(file, *document, container->binary);
  if (!buffers) return buffers.error();
  unpackMeshoptViews(*document, buffers->buffers);
  if (auto done = unpackDracoPrimitives(file, *document, buffers->buffers); !done) {
    return done.error();
  }
  numberTargets(*document);
  // tinygltf would load both by itself: images, which are not read here, and no buffer that is
  // larger than declared or that an extension defines.
  const std::size_t images = sizeOfArray(*document, "images");
  document->erase("images");
  document->erase("buffers");

  GltfModel loaded;
  tinygltf::Model& model = loaded.model;
  std::string problem;
  std::string warning;
  bool parsed = false;
  try {
    const std::string text = document->dump();
    parsed = tinygltf::TinyGLTF().LoadASCIIFromString(&model, &problem, &warning, text.data(),
                                                      static_cast<unsigned int>(text.size()), "");
  } catch (const std::exception& exception) {
    problem = exception.what();
  }
  if (!parsed) {
    return invalid(fmt::format("is not glTF 2.0: {}", oneLine(problem)), file.path.string());
  }
  model.buffers = std::move(buffers->buffers);
  model.images.resize(images);
  loaded.bufferFiles = std::move(buffers->files);
  return loaded;
}

Remedy gltfRemedyFor(std::string_view extension) {
  const bool known = extension == kDracoExtension || extension == "EXT_meshopt_compression";
  return known ? Remedy::PlainGltf : Remedy::None;
}

Place gltfElement(const InputFile& file, const char* kind, int index, const std::string& member) {
  return placeIn(file.path.string(), fmt::format("{}[{}]{}", kind, index, member));
}

}  // namespace t4d::formats
