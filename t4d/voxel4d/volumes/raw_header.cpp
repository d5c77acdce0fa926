#include <fmt/format.h>

#include "t4d/voxel4d/volumes/header_text.h"
#include "t4d/voxel4d/volumes/headers.h"

namespace t4d::voxel4d {

Result<Volume> readRawHeader(const std::filesystem::path& path, std::string_view given) {
  Volume volume;
  volume.where = path.string();
  std::string line(given);
  SampleData data{path};
  if (line.empty()) {
    constexpr std::size_t kLongest = 200;
    std::ifstream file(path, std::ios::binary);
    if (!file) return fail(ErrorCode::Io, "cannot be opened", volume.where);
    std::string front(kLongest, '\0');
    file.read(front.data(), kLongest);
    front.resize(static_cast<std::size_t>(file.gcount()));
    const auto end = front.find('\n');
    if (!front.starts_with("raw ") || end == std::string::npos) {
      return invalid(
          "does not begin with a line that says what it holds, as 'raw float32 64 64 64 10 "
          "little': type, samples along x, y and z, frames, and order of bytes",
          volume.where);
    }
    line = front.substr(0, end);
    data.offset = end + 1;
  }
  std::vector<std::string> words = wordsOf(line);
  if (!words.empty() && words.front() == "raw") words.erase(words.begin());
  const auto wrong = [&](const std::string& message) {
    return invalid(
        fmt::format("'{}' {}; expected is 'raw TYPE NX NY NZ [NT] [little|big]', as 'raw "
                    "float32 64 64 64 10 little'",
                    shown(line), message),
        volume.where);
  };
  if (words.empty()) return wrong("has no type");
  const auto type = sampleTypeNamed(words.front());
  if (!type) return wrong(fmt::format("has the type '{}'", shown(words.front())));
  volume.type = *type;
  if (words.back() == "little" || words.back() == "big") {
    volume.order = words.back() == "big" ? std::endian::big : std::endian::little;
    words.pop_back();
  }
  for (std::size_t i = 1; i < words.size(); ++i) {
    const auto size = numberIn<std::uint64_t>(words[i]);
    if (!size) return wrong(fmt::format("has the size '{}'", shown(words[i])));
    volume.sizes.push_back(*size);
  }
  if (volume.sizes.size() != 3 && volume.sizes.size() != 4) {
    return wrong(fmt::format("has {} sizes", volume.sizes.size()));
  }
  volume.axes = std::string("xyzt").substr(0, volume.sizes.size());
  volume.data = {data};
  return volume;
}

}  // namespace t4d::voxel4d
