#include "tools/t4d/viewer_page.h"

#include <algorithm>
#include <fstream>
#include <functional>
#include <iterator>
#include <optional>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "formats/output_file.h"
#include "formats/output_folder.h"
#include "formats/t4d/url.h"
#include "formats/text/base64.h"
#include "platform/kept_inputs.h"
#include "platform/replaceable.h"
#include "t4d/file.h"

namespace t4d::tools {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

constexpr std::string_view kFilesPlace = "<!-- files -->";
constexpr const char* kIndex = "index.html";

/// A relative address: anything but letters, digits and "-._~" as %xx.
std::string addressOf(std::string_view name) {
  std::string address;
  for (const char letter : name) {
    const auto byte = static_cast<unsigned char>(letter);
    const bool isPlain = (byte >= '0' && byte <= '9') || (byte >= 'A' && byte <= 'Z') ||
                         (byte >= 'a' && byte <= 'z') ||
                         std::string_view("-._~").find(letter) != std::string_view::npos;
    address += isPlain ? std::string(1, letter) : fmt::format("%{:02X}", byte);
  }
  return address;
}

/// An element of the page that holds JSON.
std::string holderOf(std::string_view id, std::string json) {
  // "</script>" in a text must not end the element.
  for (std::size_t at = 0; (at = json.find('<', at)) != std::string::npos;) {
    json.replace(at, 1, "\\u003c");
  }
  return fmt::format("<script type=\"application/json\" id=\"{}\">{}</script>", id, json);
}

Result<std::string> pageWith(std::string_view viewer, const ordered_json& files,
                             std::string_view tracks) {
  const std::size_t place = viewer.find(kFilesPlace);
  if (place == viewer.npos) {
    return fail(ErrorCode::Options, "the text of the viewer has no place for the files");
  }
  std::string holders =
      holderOf("t4d-files", files.dump(-1, ' ', true, ordered_json::error_handler_t::replace));
  if (!tracks.empty()) holders += holderOf("t4d-tracks", std::string(tracks));
  std::string page(viewer);
  page.replace(place, kFilesPlace.size(), holders);
  return page;
}

ordered_json addressed(const ShownFile& file) {
  ordered_json entry = {{"name", file.name},
                        {"url", file.url.empty() ? addressOf(file.name) : file.url}};
  if (file.isCopy) entry["isCopy"] = true;
  return entry;
}

/// Reads a file piece by piece.
Result<void> eachPiece(const fs::path& path,
                       const std::function<Result<void>(std::span<const char>)>& use) {
  platform::noteInput(path);
  std::ifstream in(path, std::ios::binary);
  std::vector<char> piece(std::size_t{1} << 20);
  while (in) {
    in.read(piece.data(), static_cast<std::streamsize>(piece.size()));
    if (auto used = use({piece.data(), static_cast<std::size_t>(in.gcount())}); !used) {
      return used.error();
    }
  }
  if (!in.eof()) return fail(ErrorCode::Failed, "cannot be read", path.string());
  return {};
}

/// The copies beside a page of this program, of any version: its licence says so at the beginning.
/// Nothing if this is another page, or none.
std::optional<std::vector<std::string>> copiesOfSite(const fs::path& path) {
  constexpr std::size_t kLicenceWithin = 256;
  constexpr std::string_view kList = R"(<script type="application/json" id="t4d-files">)";
  std::error_code ignored;
  if (fs::symlink_status(path, ignored).type() != fs::file_type::regular) return std::nullopt;
  std::ifstream in(path, std::ios::binary);
  const std::string page(std::istreambuf_iterator<char>(in), {});
  if (page.find("This page is part of t4d,") > kLicenceWithin) return std::nullopt;
  std::vector<std::string> names;
  // The list comes before the program of the page, which may have the same words.
  const std::size_t begin = page.find(kList);
  if (begin == page.npos) return names;
  const std::size_t end = page.find('<', begin + kList.size());
  const auto list = ordered_json::parse(
      page.substr(begin + kList.size(), end - begin - kList.size()), nullptr, false);
  if (!list.is_array()) return names;
  for (const auto& file : list) {
    if (!file.is_object() || file.value("isCopy", ordered_json()) != true) continue;
    const ordered_json name = file.value("name", ordered_json());
    if (name.is_string()) names.push_back(name.get<std::string>());
  }
  return names;
}

/// Whether it is the file of this name in the folder, and need not be copied.
bool isBeside(const ShownFile& file, const fs::path& folder) {
  std::error_code ignored;
  return fs::equivalent(file.path, folder / file.name, ignored);
}

}  // namespace

std::vector<ShownFile> shownFiles(std::span<const std::string> inputs) {
  std::vector<ShownFile> files;
  for (const std::string& input : inputs) {
    const bool isUrl = !formats::schemeOf(input).empty();
    ShownFile file{.name = fs::path(isUrl ? formats::shownName(input) : input).filename().string(),
                   .url = isUrl ? input : ""};
    if (!isUrl) file.path = input;
    // The page itself is beside them, too.
    const auto isTaken = [&] {
      return file.name == kIndex ||
             std::ranges::find(files, file.name, &ShownFile::name) != files.end();
    };
    for (int i = 2; isTaken(); ++i) {
      file.name = fmt::format("{}-{}", i, fs::path(input).filename().string());
    }
    files.push_back(std::move(file));
  }
  return files;
}

Result<std::string> viewerPage(std::string_view viewer, std::span<const ShownFile> files,
                               std::string_view tracks) {
  ordered_json list = ordered_json::array();
  for (const ShownFile& file : files) list.push_back(addressed(file));
  return pageWith(viewer, list, tracks);
}

Result<std::string> pageWithFiles(std::string_view viewer, std::span<const ShownFile> files,
                                  std::string_view tracks) {
  ordered_json list = ordered_json::array();
  for (const ShownFile& file : files) {
    if (!file.url.empty()) {
      list.push_back(addressed(file));
      continue;
    }
    std::vector<std::uint8_t> bytes;
    auto read = eachPiece(file.path, [&](std::span<const char> piece) -> Result<void> {
      bytes.insert(bytes.end(), piece.begin(), piece.end());
      return {};
    });
    if (!read) return read.error();
    list.push_back({{"name", file.name}, {"base64", formats::base64(bytes)}});
  }
  return pageWith(viewer, list, tracks);
}

Result<void> checkSite(const fs::path& folder, std::span<const ShownFile> files) {
  std::vector<std::string> names = {kIndex};
  for (const ShownFile& file : files) {
    if (file.url.empty() && !isBeside(file, folder)) names.push_back(file.name);
  }
  const auto old = copiesOfSite(folder / kIndex);
  return platform::checkReplaceable(folder, names, [&](const fs::path& path) {
    if (!old) return false;
    if (path.filename() == kIndex) return true;
    return std::ranges::find(*old, path.filename().string()) != old->end() && formats::isT4d(path);
  });
}

Result<std::uint64_t> writeSite(std::string_view viewer, const fs::path& folder,
                                std::span<const ShownFile> files, std::string_view tracks) {
  if (auto good = checkSite(folder, files); !good) return good.error();
  const auto old = copiesOfSite(folder / kIndex).value_or(std::vector<std::string>());
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) {
    return fail(ErrorCode::Failed, fmt::format("cannot make the folder: {}", error.message()),
                folder.string());
  }
  std::uint64_t total = 0;
  std::vector<ShownFile> listed(files.begin(), files.end());
  for (ShownFile& file : listed) {
    if (!file.url.empty()) continue;
    file.isCopy = !isBeside(file, folder) || std::ranges::find(old, file.name) != old.end();
    if (isBeside(file, folder)) continue;
    auto copy = formats::OutputFile::create(folder / file.name);
    if (!copy) return copy.error();
    auto copied = eachPiece(file.path, [&](std::span<const char> piece) {
      return copy->write(piece.data(), piece.size());
    });
    if (!copied) return copied.error();
    if (auto done = copy->commit(); !done) return done.error();
    total += copy->size();
  }
  const auto page = viewerPage(viewer, listed, tracks);
  if (!page) return page.error();
  if (auto put = formats::writeInFolder(folder, kIndex, *page); !put) return put.error();
  return total + page->size();
}

}  // namespace t4d::tools
