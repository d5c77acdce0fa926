#include "t4d/formats/gltf/gltf_model.h"

#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <string_view>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "t4d/formats/text/json_check.h"
#include "t4d/system/regular_file.h"

namespace t4d::formats {
namespace {

constexpr std::size_t kGlbHeaderBytes = 20;  // magic, version, length; length and type of the JSON
// tinygltf decodes embedded buffers with 32-bit counters.
constexpr std::size_t kMostTextBytes = std::numeric_limits<std::int32_t>::max();
constexpr std::size_t kMostBinaryBytes = std::numeric_limits<std::uint32_t>::max();

/// The JSON text of the file, after a check of the container.
Result<std::string_view> jsonOf(const InputFile& file) {
  const std::string_view bytes = file.bytes;
  if (!bytes.starts_with("glTF")) {
    if (bytes.size() > kMostTextBytes) {
      return fail(ErrorCode::Unsupported, "text glTF of more than 2 GiB is not supported; use .glb",
                  file.path.string());
    }
    return bytes;
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
  return bytes.substr(kGlbHeaderBytes, number(12));
}

/// Members that tinygltf takes for missing if they are not whole numbers.
constexpr std::array<std::string_view, 3> kWholeNumbers = {"byteLength", "byteOffset",
                                                           "byteStride"};

/// Where buffers are looked for, and those that were read.
struct Buffers {
  std::string folder;
  std::vector<std::filesystem::path> files = {};
};

/// Buffers are looked for in the file's folder only; tinygltf would also search the working
/// directory.
bool isBeside(const std::string& path, void* buffers) {
  const std::string& prefix = static_cast<const Buffers*>(buffers)->folder;
  std::error_code ignored;
  if (!path.starts_with(prefix)) return false;
  // Links must not lead out of the folder either.
  return system::isWithinFolder(path, prefix) && std::filesystem::is_regular_file(path, ignored);
}

std::string samePath(const std::string& path, void*) { return path; }

bool readWhole(std::vector<unsigned char>* out, std::string* problem, const std::string& path,
               void* buffers) {
  const auto file = readInputFile(path);
  if (!file) {
    *problem = file.error().text();
    return false;
  }
  out->assign(file->bytes.begin(), file->bytes.end());
  static_cast<Buffers*>(buffers)->files.emplace_back(path);
  return true;
}

bool ignoreImage(tinygltf::Image*, int, std::string*, std::string*, int, int, const unsigned char*,
                 int, void*) {
  return true;
}

std::string oneLine(std::string text) {
  while (!text.empty() && text.back() == '\n') text.pop_back();
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

/// Where JSON cannot be parsed; nothing if it can.
std::optional<Error> brokenJson(const InputFile& file, std::string_view text) {
  try {
    if (nlohmann::json::parse(text).is_object()) return std::nullopt;
    return invalid("is not glTF 2.0: its JSON is not an object", file.path.string());
  } catch (const nlohmann::json::parse_error& error) {
    // "[json.exception.parse_error.101] parse error at line 3, column 5: ..."
    std::string_view what = error.what();
    what.remove_prefix(std::min(what.size(), what.find("] ") + 2));
    const auto begin = static_cast<std::size_t>(text.data() - file.bytes.data());
    const std::size_t byte = begin + (error.byte > 0 ? error.byte - 1 : 0);
    return invalid(fmt::format("is not glTF 2.0: its JSON has a {}", what), file.atByte(byte));
  } catch (const nlohmann::json::out_of_range& error) {
    // "[json.exception.out_of_range.406] number overflow parsing '1e999'"
    std::string_view what = error.what();
    what.remove_prefix(std::min(what.size(), what.find("] ") + 2));
    return invalid(fmt::format("is not glTF 2.0: its JSON has a {}", what), file.path.string());
  }
}

/// Extensions that are read, and prefixes of those that do not change positions and triangles.
bool isSupported(const std::string& extension) {
  constexpr std::string_view kStarts[] = {"KHR_materials_",        "KHR_texture_",
                                          "EXT_texture_",          "KHR_lights_",
                                          "KHR_mesh_quantization", "EXT_mesh_gpu_instancing"};
  return std::any_of(std::begin(kStarts), std::end(kStarts),
                     [&](std::string_view start) { return extension.starts_with(start); });
}

}  // namespace

Result<GltfModel> loadGltfModel(const InputFile& file) {
  const auto json = jsonOf(file);
  if (!json) return json.error();
  if (auto good = checkJson(*json, file.path.string(), {.wholeNumbers = kWholeNumbers}); !good) {
    return good.error();
  }
  Buffers buffers{file.path.parent_path().string()};
  if (buffers.folder.empty()) buffers.folder = ".";
  tinygltf::TinyGLTF loader;
  loader.SetFsCallbacks({isBeside, samePath, readWhole, nullptr, &buffers});
  loader.SetImageLoader(ignoreImage, nullptr);
  GltfModel loaded;
  tinygltf::Model& model = loaded.model;
  std::string problem;
  std::string warning;
  bool parsed = false;
  try {
    const auto size = static_cast<unsigned int>(file.bytes.size());
    parsed =
        file.bytes.starts_with("glTF")
            ? loader.LoadBinaryFromMemory(&model, &problem, &warning,
                                          reinterpret_cast<const unsigned char*>(file.bytes.data()),
                                          size, buffers.folder)
            : loader.LoadASCIIFromString(&model, &problem, &warning, file.bytes.data(), size,
                                         buffers.folder);
  } catch (const std::exception& exception) {
    problem = exception.what();
  }
  if (!parsed) {
    if (const auto broken = brokenJson(file, *json)) return *broken;
    return invalid(fmt::format("is not glTF 2.0: {}", oneLine(problem)), file.path.string());
  }
  if (!model.asset.version.starts_with("2.")) {
    return fail(ErrorCode::Unsupported,
                fmt::format("is glTF version '{}', expected 2.0", model.asset.version),
                file.path.string());
  }
  for (const std::string& extension : model.extensionsRequired) {
    if (isSupported(extension)) continue;
    return fail(ErrorCode::Unsupported,
                fmt::format("requires the extension {}, which is not supported", extension),
                file.path.string());
  }
  loaded.bufferFiles = std::move(buffers.files);
  return loaded;
}

Place gltfElement(const InputFile& file, const char* kind, int index, const std::string& member) {
  return placeIn(file.path.string(), fmt::format("{}[{}]{}", kind, index, member));
}

}  // namespace t4d::formats
