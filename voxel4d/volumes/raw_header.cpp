#include <fmt/format.h>

#include "voxel4d/volumes/header_text.h"
#include "voxel4d/volumes/headers.h"

namespace t4d::voxel4d {

namespace {

/// Sets type, order and sizes to what a line says; says what is wrong with it otherwise.
std::optional<std::string> parseLine(const std::string& line, Volume& volume) {
  std::vector<std::string> words = wordsOf(line);
  if (!words.empty() && words.front() == "raw") words.erase(words.begin());
  if (words.empty()) return "has no type";
  const auto type = sampleTypeNamed(words.front());
  if (!type) return fmt::format("has the type '{}'", shown(words.front()));
  volume.type = *type;
  if (words.back() == "little" || words.back() == "big") {
    volume.order = words.back() == "big" ? std::endian::big : std::endian::little;
    words.pop_back();
  }
  for (std::size_t i = 1; i < words.size(); ++i) {
    const auto size = numberIn<std::uint64_t>(words[i]);
    if (!size) return fmt::format("has the size '{}'", shown(words[i]));
    volume.sizes.push_back(*size);
  }
  if (volume.sizes.size() != 3 && volume.sizes.size() != 4) {
    return fmt::format("has {} sizes", volume.sizes.size());
  }
  volume.axes = std::string("xyzt").substr(0, volume.sizes.size());
  volume.unsized = "xyz";
  return std::nullopt;
}

/// The first line of the file if it begins with "raw "; its end is behind the line break.
Result<std::string> ownLine(const std::filesystem::path& path) {
  constexpr std::size_t kLongest = 200;
  auto file = openHeader(path);
  if (!file) return file.error();
  std::string front(kLongest, '\0');
  file->read(front.data(), kLongest);
  front.resize(static_cast<std::size_t>(file->gcount()));
  const auto end = front.find('\n');
  if (!front.starts_with("raw ") || end == std::string::npos) return std::string();
  return front.substr(0, end);
}

}  // namespace

Result<Volume> readRawHeader(const std::filesystem::path& path, std::string_view given) {
  Volume volume;
  volume.where = path.string();
  const auto own = ownLine(path);
  if (!own) return own.error();
  if (own->empty() && given.empty()) {
    return invalid(
        "does not begin with a line that says what it holds, as 'raw float32 64 64 64 10 "
        "little': type, samples along x, y and z, frames, and order of bytes",
        volume.where);
  }
  const std::string line = given.empty() ? *own : std::string(given);
  if (const auto wrong = parseLine(line, volume)) {
    return invalid(
        fmt::format("'{}' {}; expected 'raw TYPE NX NY NZ [NT] [little|big]', as 'raw float32 "
                    "64 64 64 10 little'",
                    shown(line), *wrong),
        volume.where);
  }
  SampleData data{path};
  if (given.empty()) {
    data.offset = own->size() + 1;
  } else if (Volume said; !own->empty() && !parseLine(*own, said)) {
    // A line of the file's own is no samples.
    if (said.type != volume.type || said.order != volume.order || said.sizes != volume.sizes) {
      return invalid(fmt::format("begins with the line '{}', which contradicts '{}'", shown(*own),
                                 shown(line)),
                     volume.where);
    }
    data.offset = own->size() + 1;
  }
  volume.data = {data};
  return volume;
}

}  // namespace t4d::voxel4d
