#include "formats/t4d/manifest.h"

#include <algorithm>
#include <array>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "formats/file_extension.h"
#include "formats/t4d/layout.h"
#include "formats/t4d/member_reader.h"
#include "formats/t4d/metadata.h"
#include "formats/t4d/names.h"
#include "formats/t4d/url.h"
#include "formats/text/json_check.h"
#include "formats/text/json_object.h"
#include "platform/regular_file.h"

namespace t4d::formats {
namespace {

using ManifestJson = nlohmann::ordered_json;

constexpr std::uint64_t kMostManifestBytes = std::uint64_t{256} << 20;
constexpr std::size_t kSha256Digits = 64;

Result<BodyOfPart> takeBody(const ManifestJson& json, const std::string& of, std::uint64_t bytes) {
  MemberReader from(json, of);
  BodyOfPart body;
  BodySummary& summary = body.summary;
  summary.slabs = from.count("slabs");
  summary.vertices = from.count("vertices");
  summary.tetrahedra = from.count("cells");
  summary.time = {from.number("begin"), from.number("end")};
  const auto min = from.point("min");
  const auto max = from.point("max");
  body.shared = from.count("shared");
  if (auto sound = from.result(); !sound) return sound.error();
  if (min && max) summary.bounds = {*min, *max};
  if (min.has_value() != max.has_value() || min.has_value() != (summary.vertices > 0) ||
      (min && summary.bounds.empty())) {
    return invalid(fmt::format("{} has bounds that are none, or none where it has vertices", of));
  }
  if (summary.slabs == 0 || summary.slabs > bytes / t4d_layout::kChunkHeaderBytes) {
    return invalid(fmt::format("{} has {} slabs in a file of {} bytes", of, summary.slabs, bytes));
  }
  if (summary.time.begin > summary.time.end) {
    return invalid(
        fmt::format("{} lasts from time {} to {}", of, summary.time.begin, summary.time.end));
  }
  if (body.shared > summary.vertices) {
    return invalid(fmt::format("{} shares {} of its {} vertices with the part before", of,
                               body.shared, summary.vertices));
  }
  return body;
}

/// The folder of a path or URL, with the slash at its end.
std::string folderOf(const std::string& pathOrUrl) {
  return pathOrUrl.substr(0, pathOrUrl.rfind('/') + 1);
}

/// A URL without what follows its path.
std::string pathOfUrl(const std::string& url) { return url.substr(0, url.find_first_of("?#")); }

/// Fails for a link that leads out of the folder of the manifest.
Result<void> checkNoLinkOut(const std::filesystem::path& place,
                            const std::filesystem::path& manifest) {
  std::error_code ignored;
  if (!std::filesystem::exists(place, ignored) ||
      platform::isWithinFolder(place, manifest.parent_path())) {
    return {};
  }
  return invalid(fmt::format("is a link to a file outside of the folder of {}, which is not read; "
                             "copy the file there",
                             manifest.string()),
                 place.string());
}

Result<std::filesystem::path> placeOf(const std::string& path, const std::string& manifest) {
  const std::string scheme = schemeOf(path);
  if (scheme == "http" || scheme == "https") return std::filesystem::path(path);
  const std::filesystem::path relative(path);
  const bool leaves = std::ranges::find(relative, std::filesystem::path("..")) != relative.end();
  if (!scheme.empty() || path.empty() || relative.is_absolute() || leaves ||
      path.find('\0') != path.npos) {
    return invalid(
        fmt::format("names '{}': a part is a path in its folder or below, without '..', "
                    "or an http:// or https:// URL",
                    shownName(path)));
  }
  if (!schemeOf(manifest).empty()) {
    return std::filesystem::path(folderOf(pathOfUrl(manifest)) + path);
  }
  std::filesystem::path place = folderOf(manifest) + path;
  if (auto good = checkNoLinkOut(place, manifest); !good) return good.error();
  return place;
}

Result<ManifestPart> takePart(const ManifestJson& json, std::size_t number,
                              const std::string& manifest, std::size_t bodyCount) {
  const std::string of = fmt::format("part {}", number);
  MemberReader from(json, of);
  ManifestPart part;
  part.path = from.text("path");
  part.bytes = from.count("bytes");
  part.sha256 = from.hex("sha256", kSha256Digits);
  part.footer = from.hex("footer", 2 * t4d_layout::kFooterBytes);
  const std::uint64_t slabs = from.count("slabs");
  const model::TimeSpan time = {from.number("begin"), from.number("end")};
  const ManifestJson& bodies = from.array("bodies");
  const ManifestJson& chunks = from.object("chunks");
  if (auto sound = from.result(); !sound) return sound.error();
  for (const auto& [type, sums] : chunks.items()) {
    MemberReader row(sums, fmt::format("the chunks {} of {}", type, of));
    part.chunks.push_back({type, row.count("count"), row.count("bytes")});
    if (auto sound = row.result(); !sound) return sound.error();
  }
  if (bodies.size() != bodyCount) {
    return invalid(fmt::format("{} has {} bodies, 'head' has {}", of, bodies.size(), bodyCount));
  }
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    auto body = takeBody(bodies[i], fmt::format("body {} of {}", i + 1, of), part.bytes);
    if (!body) return body.error();
    part.bodies.push_back(std::move(*body));
  }
  if (slabs != part.slabs() || time.begin != part.time().begin || time.end != part.time().end) {
    return invalid(fmt::format(
        "{} has {} slabs from time {} to {}; its bodies have {} from {} to "
        "{}",
        of, slabs, time.begin, time.end, part.slabs(), part.time().begin, part.time().end));
  }
  auto place = placeOf(part.path, manifest);
  if (!place) return place.error();
  part.place = std::move(*place);
  return part;
}

/// Whether `next` can follow `before` in a body.
Result<void> checkFollows(const Manifest& manifest, std::size_t number, std::size_t body) {
  const ManifestPart& before = manifest.parts[number - 1];
  const ManifestPart& next = manifest.parts[number];
  const double end = before.bodies[body].summary.time.end;
  const double begin = next.bodies[body].summary.time.begin;
  const bool joined = next.bodies[body].shared > 0;
  if (joined ? begin == end : begin >= end) return {};
  return invalid(fmt::format(
      "part {}, {}, begins the body '{}' at time {}, and part {}, {}, ends it at {}: {}",
      number + 1, next.path, manifest.metadata.bodies[body].name, begin, number, before.path, end,
      begin < end ? "they overlap" : "a part between them is missing"));
}

Result<std::string> readText(ByteSource& file) {
  if (file.size() > kMostManifestBytes) {
    return invalid(
        fmt::format("has {} bytes; a manifest has at most {}", file.size(), kMostManifestBytes));
  }
  std::string text(file.size(), '\0');
  if (auto done = file.read(0, std::as_writable_bytes(std::span(text))); !done) {
    return done.error();
  }
  return text;
}

Result<ManifestJson> parseManifestJson(const std::string& text, const std::string& name) {
  if (std::string_view(text).starts_with(
          std::string_view(reinterpret_cast<const char*>(t4d_layout::kSignature.data()),
                           t4d_layout::kSignature.size()))) {
    return invalid("is a .t4d file, not a manifest of parts; name it .t4d");
  }
  if (auto sound = checkJson(text, name, {.deepestNesting = t4d_layout::kMaxJsonDepth + 2});
      !sound) {
    return sound.error();
  }
  ManifestJson json;
  try {
    json = ManifestJson::parse(text);
  } catch (const ManifestJson::exception& error) {
    return invalid("is not JSON: " + jsonMessage(error));
  }
  return json;
}

Result<Manifest> parseManifest(const std::string& text, const std::string& name,
                               const std::string& pathOrUrl) {
  const auto json = parseManifestJson(text, name);
  if (!json) return json.error();
  MemberReader from(*json, "the manifest");
  const std::uint64_t version = from.count("t4dm");
  const ManifestJson& head = from.object("head");
  const ManifestJson& parts = from.array("parts");
  if (auto sound = from.result(); !sound) return sound.error();
  if (version != 1) {
    return fail(ErrorCode::Unsupported,
                fmt::format("is a manifest of version {}; this program reads 1", version));
  }
  if (parts.empty()) return invalid("names no part");
  Manifest manifest;
  manifest.head = head.dump(1, ' ', false, ManifestJson::error_handler_t::replace);
  auto metadata = parseHead(manifest.head);
  if (!metadata) return invalid("'head': " + metadata.error().message);
  manifest.metadata = std::move(*metadata);
  const std::size_t bodyCount = manifest.metadata.bodies.size();
  for (const ManifestJson& each : parts) {
    auto part = takePart(each, manifest.parts.size() + 1, pathOrUrl, bodyCount);
    if (!part) return part.error();
    manifest.parts.push_back(std::move(*part));
    const std::size_t number = manifest.parts.size() - 1;
    for (std::size_t body = 0; number > 0 && body < bodyCount; ++body) {
      if (auto follows = checkFollows(manifest, number, body); !follows) {
        return follows.error();
      }
    }
  }
  return manifest;
}

ManifestJson pointJson(const model::Bounds3& bounds, const model::Point3& point) {
  if (bounds.empty()) return nullptr;
  return {point.x(), point.y(), point.z()};
}

ManifestJson partJson(const ManifestPart& part) {
  ManifestJson bodies = ManifestJson::array();
  for (const BodyOfPart& body : part.bodies) {
    const BodySummary& summary = body.summary;
    bodies.push_back({{"begin", summary.time.begin},
                      {"end", summary.time.end},
                      {"slabs", summary.slabs},
                      {"vertices", summary.vertices},
                      {"cells", summary.tetrahedra},
                      {"shared", body.shared},
                      {"min", pointJson(summary.bounds, summary.bounds.min)},
                      {"max", pointJson(summary.bounds, summary.bounds.max)}});
  }
  ManifestJson chunks = ManifestJson::object();
  for (const T4dChunks& each : part.chunks) {
    chunks[each.type] = {{"count", each.count}, {"bytes", each.bytes}};
  }
  return {{"path", part.path},     {"begin", part.time().begin}, {"end", part.time().end},
          {"slabs", part.slabs()}, {"bytes", part.bytes},        {"sha256", part.sha256},
          {"footer", part.footer}, {"chunks", chunks},           {"bodies", bodies}};
}

Error inManifest(Error error, const std::string& name) {
  if (error.where.empty()) error.where = name;
  return error;
}

}  // namespace

model::TimeSpan ManifestPart::time() const {
  model::TimeSpan time = bodies.front().summary.time;
  for (const BodyOfPart& body : bodies) {
    time.begin = std::min(time.begin, body.summary.time.begin);
    time.end = std::max(time.end, body.summary.time.end);
  }
  return time;
}

std::uint64_t ManifestPart::slabs() const {
  std::uint64_t slabs = 0;
  for (const BodyOfPart& body : bodies) slabs += body.summary.slabs;
  return slabs;
}

BodySummary Manifest::summary(std::size_t body) const {
  BodySummary sum = parts.front().bodies[body].summary;
  for (std::size_t i = 1; i < parts.size(); ++i) {
    const auto& [next, shared] = parts[i].bodies[body];
    sum.slabs += next.slabs;
    sum.vertices += next.vertices - shared;
    sum.tetrahedra += next.tetrahedra;
    sum.time.end = next.time.end;
    sum.bounds.add(next.bounds);
  }
  return sum;
}

std::uint64_t Manifest::bytes() const {
  std::uint64_t bytes = 0;
  for (const ManifestPart& part : parts) bytes += part.bytes;
  return bytes;
}

bool isManifest(const std::filesystem::path& pathOrUrl) {
  const std::string text = pathOrUrl.string();
  return lowerCaseExtension(schemeOf(text).empty() ? text : pathOfUrl(text)) == ".t4dm";
}

Result<Manifest> readManifest(const std::filesystem::path& pathOrUrl) {
  const std::string name = shownName(pathOrUrl.string());
  auto file = openByteSource(pathOrUrl);
  if (!file) return file.error();
  const auto text = readText(**file);
  if (!text) return inManifest(text.error(), name);
  auto manifest = parseManifest(*text, name, pathOrUrl.string());
  if (!manifest) return inManifest(manifest.error(), name);
  return manifest;
}

std::string manifestText(const Manifest& manifest) {
  ManifestJson parts = ManifestJson::array();
  for (const ManifestPart& part : manifest.parts) parts.push_back(partJson(part));
  const ManifestJson json = {
      {"t4dm", 1}, {"head", ManifestJson::parse(manifest.head)}, {"parts", parts}};
  return json.dump(1) + "\n";
}

Result<std::string> pathInManifest(const std::filesystem::path& place,
                                   const std::filesystem::path& manifest) {
  if (!schemeOf(place.string()).empty()) return place.string();
  const auto whole = [](const std::filesystem::path& path) {
    return std::filesystem::absolute(path).lexically_normal();
  };
  const std::filesystem::path path = whole(place).lexically_relative(whole(manifest).parent_path());
  if (path.empty() || *path.begin() == "..") {
    return fail(
        ErrorCode::Options,
        fmt::format("is not in the folder of {} or below; write the manifest there, so that "
                    "they can be moved together",
                    manifest.string()),
        place.string());
  }
  if (auto good = checkNoLinkOut(place, manifest); !good) return good.error();
  std::string name = path.generic_string();
  if (!isUtf8(name)) {
    return fail(ErrorCode::Options,
                "has a name that is not UTF-8, which a manifest cannot hold; rename the file",
                place.string());
  }
  return name;
}

Error inPart(Error error, const ManifestPart& part, const std::string& manifest) {
  if (error.where.empty()) error.where = shownName(part.place.string());
  error.message = fmt::format("{} (a part of {})", error.message, manifest);
  return error;
}

Result<std::unique_ptr<ByteSource>> openPart(const ManifestPart& part,
                                             const std::string& manifest) {
  const auto other = [&](const std::string& message) {
    return fail(ErrorCode::InvalidInput,
                fmt::format("is not the part that {} describes: {}; restore it, or make the "
                            "manifest anew",
                            manifest, message),
                shownName(part.place.string()));
  };
  auto file = openByteSource(part.place);
  if (!file) return inPart(file.error(), part, manifest);
  if ((*file)->size() != part.bytes) {
    return other(fmt::format("it has {} bytes, not {}", (*file)->size(), part.bytes));
  }
  const auto footer = footerText(**file);
  if (!footer) return inPart(footer.error(), part, manifest);
  if (*footer != part.footer) return other("its footer, which has its checksums, is another");
  return file;
}

Result<void> checkPartsAreThere(const Manifest& manifest, const std::string& name) {
  for (const ManifestPart& part : manifest.parts) {
    if (!schemeOf(part.place.string()).empty()) continue;
    std::error_code error;
    const std::uint64_t size = std::filesystem::file_size(part.place, error);
    if (!error && size == part.bytes) continue;
    if (auto opened = openPart(part, name); !opened) return opened.error();
  }
  return {};
}

Result<std::string> footerText(ByteSource& file) {
  std::array<std::byte, t4d_layout::kFooterBytes> footer{};
  const auto none = [&] {
    return invalid(
        "has no index at its end: a part of a file in parts needs one; "
        "write the file again, not through a pipe",
        file.name());
  };
  if (file.size() < t4d_layout::kFileHeaderBytes + footer.size()) return none();
  if (auto done = file.read(file.size() - footer.size(), footer); !done) return done.error();
  const auto end = std::as_bytes(std::span(t4d_layout::kEndSignature));
  if (!std::equal(end.begin(), end.end(), footer.end() - static_cast<std::ptrdiff_t>(end.size()))) {
    return none();
  }
  std::string text;
  for (const std::byte byte : footer) text += fmt::format("{:02x}", static_cast<unsigned>(byte));
  return text;
}

}  // namespace t4d::formats
