#include "t4d/voxel4d/volumes/zarr_store.h"

#include <algorithm>
#include <fstream>

#include <fmt/format.h>

#include "t4d/system/regular_file.h"

namespace t4d::voxel4d {
namespace {

namespace fs = std::filesystem;

Error tooShort(std::uint64_t size, const ZarrPart& part, std::string where) {
  return invalid(fmt::format("has {} bytes, but {} from byte {} of its {} are referred to", size,
                             part.bytes, part.begin, part.fromEnd ? "end" : "beginning"),
                 std::move(where));
}

/// Where a part begins in a file of so many bytes; nothing if it is not in it.
std::optional<std::uint64_t> beginOf(const ZarrPart& part, std::uint64_t size) {
  if (part.begin > size) return std::nullopt;
  const std::uint64_t begin = part.fromEnd ? size - part.begin : part.begin;
  return part.bytes <= size - begin ? std::optional(begin) : std::nullopt;
}

Result<std::string> readBytes(const fs::path& path, std::uint64_t begin, std::uint64_t count) {
  std::string bytes(count, '\0');
  std::ifstream file(path, std::ios::binary);
  file.seekg(static_cast<std::streamoff>(begin));
  file.read(bytes.data(), static_cast<std::streamsize>(count));
  if (!file) return fail(ErrorCode::Io, "cannot be read", path.string());
  return bytes;
}

std::string withoutUser(const std::string& url) {
  const std::size_t host = url.find("://") + 3;
  const std::size_t user = url.substr(host, url.find('/', host) - host).rfind('@');
  return user == std::string::npos ? url : url.substr(0, host) + url.substr(host + user + 1);
}

}  // namespace

bool isWebUrl(const fs::path& path) {
  std::string begin = path.string().substr(0, 8);
  std::ranges::transform(begin, begin.begin(), [](unsigned char c) { return std::tolower(c); });
  return begin.starts_with("http://") || begin.starts_with("https://");
}

Result<std::shared_ptr<const ZarrStore>> ZarrStore::open(const fs::path& input,
                                                         const system::WebFiles& web) {
  std::shared_ptr<ZarrStore> store(new ZarrStore);
  if (!isWebUrl(input)) {
    std::error_code ignored;
    if (!fs::exists(input, ignored)) {
      return fail(ErrorCode::Io, "no such file", input.string());
    }
    if (!fs::is_directory(input, ignored)) {
      return fail(ErrorCode::Unsupported,
                  "is not a folder; only folders of Zarr can be read, on disk and by URL",
                  input.string());
    }
    store->folder_ = input;
    return store;
  }
  std::string url = input.string();
  const std::size_t query = std::min(url.find_first_of("?#"), url.size());
  store->query_ = url.substr(query, url.find('#', query) - query);
  url.resize(query);
  while (url.ends_with('/')) url.pop_back();
  store->url_ = url;
  store->shown_ = withoutUser(url);
  store->web_ = web;
  if (!web)
    return fail(ErrorCode::Unsupported,
                "cannot be read: there is no libcurl to request it with; download it first",
                store->shown_);
  return store;
}

std::string ZarrStore::nameOf(const std::string& key) const {
  if (!remote()) return (key.empty() ? folder_ : folder_ / key).string();
  return key.empty() ? shown_ : shown_ + "/" + key;
}

std::string ZarrStore::urlOf(const std::string& key) const { return url_ + "/" + key + query_; }

Result<bool> ZarrStore::hasFile(const std::string& key) const {
  const fs::path path = folder_ / key;
  std::error_code problem;
  const fs::file_status status = fs::status(path, problem);
  if (status.type() == fs::file_type::not_found) return false;
  if (problem) return fail(ErrorCode::Io, "cannot open: " + problem.message(), path.string());
  if (!fs::is_regular_file(status)) return invalid("is not a regular file", path.string());
  if (system::isWithinFolder(path, folder_)) return true;
  return invalid("is a link to a file outside of the folder, which is not read", path.string());
}

Result<std::optional<std::string>> ZarrStore::read(const std::string& key,
                                                   std::uint64_t most) const {
  if (remote()) return fetch(key, {}, most, nullptr);
  const auto there = hasFile(key);
  if (!there) return there.error();
  if (!*there) return std::nullopt;
  const auto size = system::sizeOfRegularFile(folder_ / key);
  if (!size) return size.error();
  if (*size > most) {
    return invalid(fmt::format("has {} bytes; at most {} are expected", *size, most), nameOf(key));
  }
  auto bytes = readBytes(folder_ / key, 0, *size);
  if (!bytes) return bytes.error();
  return std::move(*bytes);
}

Result<std::optional<std::string>> ZarrStore::read(const std::string& key,
                                                   const ZarrPart& part) const {
  if (remote()) {
    const std::string range = part.fromEnd
                                  ? fmt::format("-{}", part.begin)
                                  : fmt::format("{}-{}", part.begin, part.begin + part.bytes - 1);
    return fetch(key, range, part.bytes, &part);
  }
  const auto there = hasFile(key);
  if (!there) return there.error();
  if (!*there) return std::nullopt;
  const auto size = system::sizeOfRegularFile(folder_ / key);
  if (!size) return size.error();
  const auto begin = beginOf(part, *size);
  if (!begin) return tooShort(*size, part, nameOf(key));
  auto bytes = readBytes(folder_ / key, *begin, part.bytes);
  if (!bytes) return bytes.error();
  return std::move(*bytes);
}

Result<std::optional<std::string>> ZarrStore::fetch(const std::string& key,
                                                    const std::string& range, std::uint64_t most,
                                                    const ZarrPart* part) const {
  const auto cut = [&](const std::string& bytes) -> Result<std::optional<std::string>> {
    const auto begin = beginOf(*part, bytes.size());
    if (!begin) return tooShort(bytes.size(), *part, nameOf(key));
    return bytes.substr(*begin, part->bytes);
  };
  if (part != nullptr) {
    const std::unique_lock lock(mutex_);
    const auto found = whole_.find(key);
    if (found != whole_.end()) return cut(*found->second);
  }
  auto file = web_(urlOf(key), range, most);
  if (!file) return file.error();
  if (!*file) return std::nullopt;
  std::string& bytes = (*file)->bytes;
  if (part == nullptr) return std::move(bytes);
  if ((*file)->whole) {
    auto kept = std::make_shared<const std::string>(std::move(bytes));
    const std::unique_lock lock(mutex_);
    constexpr std::uint64_t kMostKept = std::uint64_t{256} << 20U;
    wholeBytes_ += kept->size();
    if (wholeBytes_ > kMostKept) whole_.clear(), wholeBytes_ = kept->size();
    whole_[key] = kept;
    return cut(*kept);
  }
  if (bytes.size() != part->bytes) return tooShort(bytes.size(), *part, nameOf(key));
  return std::move(bytes);
}

}  // namespace t4d::voxel4d
