#include "formats/mesh4d/g4mf_file.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <zstd.h>

#include "formats/text/base64.h"
#include "formats/text/json_check.h"
#include "formats/text/text_scanner.h"

namespace t4d::formats {
namespace {

using nlohmann::json;

constexpr std::size_t kHeader = 16;  // of the file, and of a chunk

/// No frame of zstd unpacks to more than so many times its size: a block of at most 128 KiB takes 4
/// bytes.
constexpr std::uint64_t kMostZstdRatio = 32768;

constexpr std::string_view kDataUri = "data:application/octet-stream;base64,";

__extension__ using Int128 = __int128;
__extension__ using UInt128 = unsigned __int128;

template <class Stored>
double numberOf(Stored stored) {
  return static_cast<double>(stored);
}

/// A floating-point number in the form of IEEE 754: a sign, so many bits of the exponent, and the
/// fraction in the other bits. Rounded to the nearest of binary64.
template <class Bits, int kExponentBits>
double floatingOf(Bits bits) {
  constexpr int kFractionBits = 8 * int{sizeof(Bits)} - 1 - kExponentBits;
  constexpr int kLargest = (1 << kExponentBits) - 1;
  constexpr Bits kHidden = Bits(Bits{1} << kFractionBits);
  const auto fraction = Bits(bits & Bits(kHidden - 1));
  const int exponent = static_cast<int>(bits >> kFractionBits) & kLargest;
  double magnitude = fraction == 0 ? std::numeric_limits<double>::infinity()
                                   : std::numeric_limits<double>::quiet_NaN();
  if (exponent < kLargest) {
    const Bits whole = exponent == 0 ? fraction : Bits(fraction | kHidden);
    magnitude = std::ldexp(static_cast<double>(whole),
                           std::max(exponent, 1) - kLargest / 2 - kFractionBits);
  }
  const bool isNegative = (bits >> (kFractionBits + kExponentBits)) != 0;
  return isNegative ? -magnitude : magnitude;
}

template <class Stored, double (*kNumberOf)(Stored) = numberOf<Stored>>
std::vector<double> converted(std::string_view bytes) {
  std::vector<double> numbers(bytes.size() / sizeof(Stored));
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    numbers[i] = kNumberOf(loadNumber<Stored>(bytes.data() + i * sizeof(Stored)));
  }
  return numbers;
}

struct Primitive {
  std::string_view name;
  std::size_t size;
  std::vector<double> (*convert)(std::string_view bytes);
};

constexpr Primitive kPrimitives[] = {
    {"float64", 8, converted<double>},
    {"float32", 4, converted<float>},
    {"uint8", 1, converted<std::uint8_t>},
    {"int8", 1, converted<std::int8_t>},
    {"uint16", 2, converted<std::uint16_t>},
    {"int16", 2, converted<std::int16_t>},
    {"uint32", 4, converted<std::uint32_t>},
    {"int32", 4, converted<std::int32_t>},
    {"uint64", 8, converted<std::uint64_t>},
    {"int64", 8, converted<std::int64_t>},
    {"uint128", 16, converted<UInt128>},
    {"int128", 16, converted<Int128>},
    {"float8", 1, converted<std::uint8_t, floatingOf<std::uint8_t, 4>>},
    {"float16", 2, converted<std::uint16_t, floatingOf<std::uint16_t, 5>>},
    {"float128", 16, converted<UInt128, floatingOf<UInt128, 15>>},
};

/// A whole number from 0 on, or `otherwise` if there is none; nothing if it is something else.
std::optional<std::uint64_t> wholeNumber(const json& object, const char* member,
                                         std::optional<std::uint64_t> otherwise = {}) {
  const auto found = object.find(member);
  if (found == object.end()) return otherwise;
  if (!found->is_number_unsigned()) return std::nullopt;
  return found->get<std::uint64_t>();
}

}  // namespace

Result<void> G4mfFile::readChunks(const InputFile& file) {
  const std::string_view text = file.bytes;
  if (text.size() < 2 * kHeader) return invalid("the file ends in its header", file.atByte(0));
  if (const auto version = loadNumber<std::uint32_t>(text.data() + 4); version != 0) {
    return fail(ErrorCode::Unsupported,
                fmt::format("is version {} of binary G4MF, expected 0, the draft", version),
                file.atByte(4));
  }
  if (const auto size = loadNumber<std::uint64_t>(text.data() + 8); size != text.size()) {
    return invalid(fmt::format("declares {} bytes; the file has {}", size, text.size()),
                   file.atByte(8));
  }
  for (std::size_t at = kHeader; at < text.size();) {
    if (text.size() - at < kHeader) {
      return invalid("the file ends in the header of a chunk", file.atByte(at));
    }
    const std::string_view type = text.substr(at, 4);
    const std::string_view encoding = text.substr(at + 4, 4);
    const auto size = loadNumber<std::uint64_t>(text.data() + at + 8);
    if (size > text.size() - at - kHeader) {
      return invalid(fmt::format("a chunk declares {} bytes; only {} follow", size,
                                 text.size() - at - kHeader),
                     file.atByte(at + 8));
    }
    const bool plain = encoding == std::string_view("\0\0\0\0", 4);
    const bool isJson = type == "JSON";
    if (!plain && (isJson || encoding != "Zstd")) {
      return fail(ErrorCode::Unsupported,
                  fmt::format("the chunk {} is compressed as {}, expected {}", inQuotes(type),
                              inQuotes(encoding), isJson ? "plain JSON" : "'Zstd' or plain bytes"),
                  file.atByte(at + 4));
    }
    chunks_.push_back({type, text.substr(at + kHeader, size), !plain});
    at += kHeader + size;
    at = std::min((at + 15) / 16 * 16, text.size());
  }
  return {};
}

/// Parses a text file, or the first chunk of type JSON of a binary one, wherever it is.
Result<void> G4mfFile::parseJson(const InputFile& file) {
  std::string_view text = file.bytes;
  if (text.starts_with("G4MF")) {
    if (auto done = readChunks(file); !done) return done;
    const auto found = std::ranges::find(chunks_, "JSON", &Chunk::type);
    if (found == chunks_.end()) {
      return wrong(fmt::format("has no chunk of type JSON among its {}", chunks_.size()));
    }
    text = found->bytes;
  }
  if (auto good = checkJson(text, path_.string()); !good) return good;
  document_ = json::parse(text, nullptr, false);
  if (document_.is_discarded()) return wrong("is not JSON");
  return {};
}

Result<G4mfFile> G4mfFile::open(const InputFile& file) {
  G4mfFile result;
  result.path_ = file.path;
  result.bytes_ = file.bytes.size();
  if (auto parsed = result.parseJson(file); !parsed) return parsed.error();
  const json& document = result.document_;
  if (!document.is_object() || !document.contains("asset") || !document["asset"].is_object()) {
    return result.wrong("has no 'asset'");
  }
  const auto dimension = wholeNumber(document["asset"], "dimension");
  if (!dimension) return result.wrong("has no 'asset.dimension'");
  if (*dimension != 4) {
    return fail(ErrorCode::Unsupported,
                fmt::format("is a model of dimension {}, expected 4", *dimension),
                file.path.string());
  }
  for (const char* member : {"accessors", "bufferViews", "buffers", "meshes", "nodes"}) {
    if (!document.contains(member)) continue;
    const json& array = document[member];
    const bool good = array.is_array() && std::ranges::all_of(array, [](const json& element) {
                        return element.is_object();
                      });
    if (!good) return result.wrong(fmt::format("'{}' is not an array of objects", member));
  }
  if (const auto found = document["asset"].find("extensionsRequired");
      found != document["asset"].end() && !found->empty()) {
    return fail(ErrorCode::Unsupported,
                fmt::format("requires extensions, of which none is supported: {}",
                            found->dump(-1, ' ', false, json::error_handler_t::replace)),
                file.path.string());
  }
  if (document.contains("buffers")) result.buffers_.resize(document["buffers"].size());
  return result;
}

Result<std::optional<std::uint64_t>> G4mfFile::index(const json& object, const char* member,
                                                     const char* array) const {
  const auto found = object.find(member);
  if (found == object.end() || *found == json(-1)) return std::optional<std::uint64_t>();
  const std::size_t size = document_.contains(array) ? document_[array].size() : 0;
  if (!found->is_number_unsigned() || found->get<std::uint64_t>() >= size) {
    return wrong(fmt::format("'{}' is {}, which is not an index into the {} {}", member,
                             inQuotes(found->dump()), size, array));
  }
  return std::optional(found->get<std::uint64_t>());
}

Result<std::string> G4mfFile::externalFile(const std::string& uri) {
  const std::filesystem::path relative(uri);
  const auto outside = [&] {
    return wrong(
        fmt::format("a buffer is in {}, which is not a file in this folder", inQuotes(uri)));
  };
  if (uri.find("://") != uri.npos || relative.is_absolute()) return outside();
  const std::filesystem::path folder =
      path_.parent_path().empty() ? std::filesystem::path(".") : path_.parent_path();
  std::error_code problem;
  const auto inside = std::filesystem::canonical(folder, problem);
  const auto whole = std::filesystem::weakly_canonical(folder / relative, problem);
  // Links must not lead out of the folder either.
  const auto [end, unused] =
      std::mismatch(inside.begin(), inside.end(), whole.begin(), whole.end());
  if (problem || end != inside.end()) return outside();
  auto file = readInputFile(folder / relative);
  if (!file) {
    return wrong(
        fmt::format("the buffer {} cannot be read: {}", inQuotes(uri), file.error().message));
  }
  otherFiles_.push_back(folder / relative);
  return std::move(file->bytes);
}

/// The chunk that a buffer names, or, in older files, the one of data with the same number.
Result<G4mfFile::Chunk> G4mfFile::chunkOf(const json& about, std::uint64_t buffer) const {
  if (about.contains("chunk")) {
    const auto number = wholeNumber(about, "chunk");
    if (number && *number < chunks_.size()) return chunks_[*number];
    return wrong(fmt::format("the 'chunk' of buffer {} is {}, but there are {}", buffer,
                             about["chunk"].dump(), chunks_.size()));
  }
  std::uint64_t number = 0;
  for (const Chunk& chunk : chunks_) {
    if (chunk.type == "BLOB" && number++ == buffer) return chunk;
  }
  return wrong(fmt::format("buffer {} has neither a chunk nor a 'uri'", buffer));
}

Result<std::string> G4mfFile::loadBuffer(const json& about, std::uint64_t index,
                                         std::uint64_t size) {
  std::string_view stored;
  std::string owned;
  bool zstd = false;
  for (const char* member : {"encoding", "compression"}) {  // the second in older files
    const auto encoding = about.find(member);
    if (encoding == about.end()) continue;
    if (*encoding != "Zstd") {
      return fail(ErrorCode::Unsupported,
                  fmt::format("buffer {} is compressed as {}; only 'Zstd' is supported", index,
                              inQuotes(encoding->dump())),
                  path_.string());
    }
    zstd = true;
  }
  if (const auto uri = about.find("uri"); uri != about.end()) {
    if (!uri->is_string()) return wrong(fmt::format("the 'uri' of buffer {} is not text", index));
    const auto& text = uri->get_ref<const std::string&>();
    if (text.starts_with("data:")) {
      auto bytes = text.starts_with(kDataUri)
                       ? fromBase64(std::string_view(text).substr(kDataUri.size()))
                       : std::nullopt;
      if (!bytes) return wrong(fmt::format("the 'uri' of buffer {} is not Base64 data", index));
      owned = std::move(*bytes);
    } else {
      auto bytes = externalFile(text);
      if (!bytes) return bytes.error();
      owned = std::move(*bytes);
    }
    stored = owned;
  } else {
    const auto chunk = chunkOf(about, index);
    if (!chunk) return chunk.error();
    stored = chunk->bytes;
    if (chunk->zstd != zstd) {
      return wrong(fmt::format("buffer {} and its chunk differ in compression", index));
    }
  }
  if (!zstd) {
    if (stored.size() < size) {
      return wrong(fmt::format("buffer {} has {} bytes of {}", index, stored.size(), size));
    }
    return std::string(stored.substr(0, size));
  }
  if (size / kMostZstdRatio > stored.size()) {
    return wrong(fmt::format("buffer {} cannot unpack {} bytes to {}", index, stored.size(), size));
  }
  std::string unpacked(size, '\0');
  const std::size_t got =
      ZSTD_decompress(unpacked.data(), unpacked.size(), stored.data(), stored.size());
  if (ZSTD_isError(got) != 0 || got != size) {
    return wrong(fmt::format("buffer {} is damaged, or does not unpack to {} bytes", index, size));
  }
  return unpacked;
}

Result<const std::string*> G4mfFile::buffer(std::uint64_t index) {
  std::optional<std::string>& buffer = buffers_[index];
  if (!buffer) {
    const json& about = document_["buffers"][index];
    const auto size = wholeNumber(about, "byteLength");
    if (!size) return wrong(fmt::format("buffer {} has no 'byteLength'", index));
    auto loaded = loadBuffer(about, index, *size);
    if (!loaded) return loaded.error();
    buffer = std::move(*loaded);
    bytes_ += buffer->size();
  }
  return &*buffer;
}

Result<std::vector<double>> G4mfFile::accessor(std::uint64_t number, std::uint64_t vectorSize) {
  const json& accessor = document_["accessors"][number];
  const auto which = fmt::format("accessor {}", number);
  const auto viewIndex = index(accessor, "bufferView", "bufferViews");
  if (!viewIndex) return viewIndex.error();
  if (!*viewIndex) return wrong(which + " has no 'bufferView'");
  std::string type = accessor.value("primitiveType", json("")).is_string()
                         ? accessor.value("primitiveType", std::string())
                         : std::string();
  if (type.empty() && accessor.contains("componentType") && accessor["componentType"].is_string()) {
    type = accessor["componentType"].get<std::string>();
  }
  const auto primitive = std::ranges::find(kPrimitives, type, &Primitive::name);
  if (primitive == std::end(kPrimitives)) {
    std::vector<std::string_view> names;
    for (const Primitive& known : kPrimitives) names.push_back(known.name);
    return fail(ErrorCode::Unsupported,
                fmt::format("{} has numbers of type {}; expected one of {}", which, inQuotes(type),
                            fmt::join(names, ", ")),
                path_.string());
  }
  if (const auto size = wholeNumber(accessor, "vectorSize", 1); size != vectorSize) {
    return wrong(fmt::format("{} has a 'vectorSize' of {}, expected {}", which,
                             accessor.value("vectorSize", json(1)).dump(), vectorSize));
  }
  const json& view = document_["bufferViews"][**viewIndex];
  const auto length = wholeNumber(view, "byteLength");
  const auto offset = wholeNumber(view, "byteOffset", 0);
  if (!length || !offset || *length % (vectorSize * primitive->size) != 0) {
    return wrong(fmt::format("the buffer view of {} is not a whole number of vectors", which));
  }
  auto bufferIndex = index(view, "buffer", "buffers");
  if (!bufferIndex) return bufferIndex.error();
  if (!*bufferIndex && buffers_.empty()) return wrong(which + " has no buffer");
  const auto data = buffer(bufferIndex->value_or(0));
  if (!data) return data.error();
  if (*offset > (*data)->size() || *length > (*data)->size() - *offset) {
    return wrong(fmt::format("the buffer view of {} ends beyond its buffer of {} bytes", which,
                             (*data)->size()));
  }
  return primitive->convert(std::string_view(**data).substr(*offset, *length));
}

}  // namespace t4d::formats
