#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "t4d/model/error.h"

namespace t4d::system {

/// A file on a web server, or a part of it.
struct WebFile {
  std::string bytes;
  bool whole = true;  ///< servers may ignore the range of a request
};

/// Requests a file from a web server, or a range of its bytes, such as "0-99" or, for the last 100
/// bytes, "-100": at most `most` bytes, or more if the server ignores the range. Returns nothing if
/// there is no such file; any other failure is an error that names the URL, without credentials.
/// Safe to call from many threads.
using WebFiles = std::function<Result<std::optional<WebFile>>(
    const std::string& url, const std::string& range, std::uint64_t most)>;

}  // namespace t4d::system
