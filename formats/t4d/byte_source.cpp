#include "formats/t4d/byte_source.h"

#include <fmt/format.h>

#include "formats/t4d/url.h"

namespace t4d::formats {
namespace {

UrlOpener urlOpener = nullptr;

}  // namespace

void setUrlOpener(UrlOpener opener) { urlOpener = opener; }

Result<std::unique_ptr<ByteSource>> openByteSource(const std::filesystem::path& pathOrUrl) {
  const std::string text = pathOrUrl.string();
  if (text == "-") {
    return fail(
        ErrorCode::Io,
        "slabs are read at their offsets, which takes a file: save it first, and give its path",
        "standard input");
  }
  const std::string scheme = schemeOf(text);
  if (scheme.empty()) return openFileSource(pathOrUrl);
  const auto refused = [&](const std::string& message) {
    return fail(ErrorCode::Io, message, shownName(text));
  };
  if (scheme == "file") return refused("give the path instead of a URL");
  if (scheme != "http" && scheme != "https") {
    return refused(fmt::format("{}:// cannot be read; http://, https:// and paths can", scheme));
  }
  if (urlOpener == nullptr) {
    return refused("this build has no libcurl to read it with; download the file first");
  }
  return urlOpener(text);
}

}  // namespace t4d::formats
