#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "t4d/model/error.h"
#include "t4d/system/web_files.h"

namespace t4d::voxel4d {

/// Bytes of a file; `begin` is counted from its end if `fromEnd`.
struct ZarrPart {
  std::uint64_t begin = 0;
  std::uint64_t bytes = 0;
  bool fromEnd = false;
};

/// The files of a Zarr group or array, in a folder or on a web server, by keys such as "0/c/1/2".
/// Safe to use from many threads.
class ZarrStore {
 public:
  /// `input` is a folder or a URL; the latter is refused without `web`.
  static Result<std::shared_ptr<const ZarrStore>> open(const std::filesystem::path& input,
                                                       const system::WebFiles& web);

  bool remote() const { return web_ != nullptr; }
  /// What messages call a file: its path, or its URL without credentials.
  std::string nameOf(const std::string& key) const;
  /// Where files are, if they are in a folder.
  const std::filesystem::path& folder() const { return folder_; }

  /// Reads a file; nothing if it does not exist. Fails if it is not a regular file, is outside the
  /// folder once links are followed, or has more bytes than `most`.
  Result<std::optional<std::string>> read(const std::string& key, std::uint64_t most) const;
  /// Reads a part of a file, which must contain all of it; nothing if the file does not exist.
  Result<std::optional<std::string>> read(const std::string& key, const ZarrPart& part) const;

 private:
  ZarrStore() = default;
  Result<bool> hasFile(const std::string& key) const;
  Result<std::optional<std::string>> fetch(const std::string& key, const std::string& range,
                                           std::uint64_t most, const ZarrPart* part) const;
  std::string urlOf(const std::string& key) const;

  std::filesystem::path folder_;
  system::WebFiles web_;
  std::string url_;    // without a slash at its end
  std::string query_;  // with its question mark
  std::string shown_;
  // Files that a server sent as a whole although a part of them was requested.
  mutable std::mutex mutex_;
  mutable std::map<std::string, std::shared_ptr<const std::string>> whole_;
  mutable std::uint64_t wholeBytes_ = 0;
};

/// Whether it is the URL of a file on a web server.
bool isWebUrl(const std::filesystem::path& path);

}  // namespace t4d::voxel4d
