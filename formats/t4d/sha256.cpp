#include "platform/sha256.h"

#include <algorithm>
#include <vector>

#include "formats/t4d/manifest.h"
#include "model/progress.h"

namespace t4d::formats {

Result<std::string> sha256Of(ByteSource& file, const model::Progress& progress) {
  constexpr std::uint64_t kStep = std::uint64_t{1} << 20;
  platform::Sha256 digest;
  std::vector<std::byte> bytes;
  for (std::uint64_t at = 0; at < file.size(); at += bytes.size()) {
    bytes.resize(std::min(kStep, file.size() - at));
    if (auto done = file.read(at, bytes); !done) return done.error();
    digest.add(bytes);
    if (auto on = model::report(progress, at, file.size()); !on) return on.error();
  }
  return digest.finish();
}

}  // namespace t4d::formats
