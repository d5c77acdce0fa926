#include <algorithm>
#include <vector>

#include <sha2.h>

#include "formats/t4d/manifest.h"
#include "model/progress.h"

namespace t4d::formats {

Result<std::string> sha256Of(ByteSource& file, const model::Progress& progress) {
  constexpr std::uint64_t kStep = std::uint64_t{1} << 20;
  SHA2_CTX context;
  SHA256Init(&context);
  std::vector<std::byte> bytes;
  for (std::uint64_t at = 0; at < file.size(); at += bytes.size()) {
    bytes.resize(std::min(kStep, file.size() - at));
    if (auto done = file.read(at, bytes); !done) return done.error();
    SHA256Update(&context, reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
    if (auto on = model::report(progress, at, file.size()); !on) return on.error();
  }
  char text[SHA256_DIGEST_STRING_LENGTH];
  return std::string(SHA256End(&context, text));
}

}  // namespace t4d::formats
