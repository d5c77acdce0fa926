#include "formats/gltf/gltf_buffers.h"

#include <algorithm>
#include <string>

#include <fmt/format.h>

#include "formats/gltf/gltf_model.h"
#include "formats/text/base64.h"
#include "model/number.h"

namespace t4d::formats {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// The URI with each `%XX` replaced by the byte that it stands for.
std::string percentDecoded(std::string_view uri) {
  std::string text;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    const bool may = uri[i] == '%' && uri.size() - i > 2;
    const auto byte = model::numberIn<std::uint8_t>(uri.substr(i + 1, may ? 2 : 0), 16);
    if (byte) {
      text += static_cast<char>(*byte);
      i += 2;
    } else {
      text += uri[i];
    }
  }
  return text;
}

/// `https://...`, `file:...` and the like (RFC 3986).
bool hasScheme(std::string_view uri) {
  const auto end =
      uri.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789+-.");
  return end != uri.npos && end > 0 && uri[end] == ':';
}

/// Whether a file, which need not exist, is in a folder or below it. Links must not lead out of it
/// either.
bool isBelow(const fs::path& file, const fs::path& folder) {
  std::error_code problem;
  const fs::path around = fs::canonical(folder, problem);
  if (problem) return false;
  const fs::path inside = fs::weakly_canonical(file, problem);
  return !problem && std::ranges::mismatch(around, inside).in1 == around.end();
}

class BufferLoader {
 public:
  BufferLoader(const InputFile& file, std::optional<std::string_view> binaryChunk)
      : file_(file), binaryChunk_(binaryChunk) {}

  Result<GltfBuffers> load(const json& document) {
    const auto found = document.find("buffers");
    if (found == document.end()) return std::move(loaded_);
    if (!found->is_array()) return invalid("'buffers' is not an array", file_.path.string());
    for (const json& buffer : *found) {
      auto bytes = load(buffer, static_cast<int>(loaded_.buffers.size()));
      if (!bytes) return bytes.error();
      loaded_.buffers.emplace_back();
      loaded_.buffers.back().data.assign(bytes->begin(), bytes->end());
    }
    return std::move(loaded_);
  }

 private:
  Result<std::string> load(const json& buffer, int index) {
    const Place where = gltfElement(file_, "buffers", index);
    if (!buffer.is_object() || !buffer.contains("byteLength") ||
        !buffer["byteLength"].is_number_unsigned()) {
      return invalid("has no 'byteLength'", where);
    }
    const auto size = buffer["byteLength"].get<std::uint64_t>();
    const auto uri = buffer.find("uri");
    std::string bytes;
    std::string source = "the binary chunk";
    if (uri == buffer.end()) {
      if (index != 0 || !binaryChunk_) return bytes;
      bytes = *binaryChunk_;
    } else {
      if (!uri->is_string()) return invalid("its 'uri' is not text", where);
      const auto& text = uri->get_ref<const std::string&>();
      const bool isData = text.starts_with("data:");
      auto read = isData ? decoded(text, where) : readFile(text, where);
      if (!read) return read;
      bytes = std::move(*read);
      source = isData ? "its 'uri'" : fmt::format("'{}'", text);
    }
    if (bytes.size() < size) {
      return invalid(fmt::format("declares {} bytes; {} has {}", size, source, bytes.size()),
                     where);
    }
    bytes.resize(size);
    return bytes;
  }

  static Result<std::string> decoded(std::string_view uri, const Place& where) {
    const auto comma = uri.find(',');
    if (comma != uri.npos && uri.substr(0, comma).ends_with(";base64")) {
      if (auto bytes = fromBase64(uri.substr(comma + 1))) return std::move(*bytes);
    }
    return invalid("its data URI is not Base64", where);
  }

  Result<std::string> readFile(const std::string& uri, const Place& where) {
    const std::string name = percentDecoded(uri);
    const fs::path folder =
        file_.path.parent_path().empty() ? fs::path(".") : file_.path.parent_path();
    const fs::path path = file_.path.parent_path() / name;
    if (hasScheme(uri) || fs::path(name).is_absolute() || name.find('\0') != name.npos ||
        !isBelow(folder / name, folder)) {
      return invalid(fmt::format("is at '{}', expected the name of a file beside the glTF or in a "
                                 "folder below",
                                 uri),
                     where);
    }
    auto read = readInputFile(path);
    if (!read) {
      return fail(read.error().code,
                  fmt::format("needs the file '{}', which cannot be read: {}", path.string(),
                              read.error().message),
                  where);
    }
    loaded_.files.push_back(path);
    return std::move(read->bytes);
  }

  const InputFile& file_;
  std::optional<std::string_view> binaryChunk_;
  GltfBuffers loaded_;
};

}  // namespace

Result<GltfBuffers> loadGltfBuffers(const InputFile& file, const json& document,
                                    std::optional<std::string_view> binaryChunk) {
  return BufferLoader(file, binaryChunk).load(document);
}

}  // namespace t4d::formats
