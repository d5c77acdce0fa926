#include <algorithm>

#include <fmt/format.h>

#include "voxel4d/volumes/header_text.h"
#include "voxel4d/volumes/headers.h"
#include "voxel4d/volumes/npy_array.h"

namespace t4d::voxel4d {
namespace {

/// What stands after 'KEY': in the dictionary, up to the end of its value.
std::string valueOf(const std::string& dictionary, const std::string& key) {
  auto at = dictionary.find('\'' + key + '\'');
  if (at == std::string::npos) return {};
  at = dictionary.find(':', at);
  if (at == std::string::npos) return {};
  const auto begin = dictionary.find_first_not_of(' ', at + 1);
  if (begin == std::string::npos) return {};
  const char first = dictionary[begin];
  const auto end = first == '('    ? dictionary.find(')', begin)
                   : first == '\'' ? dictionary.find('\'', begin + 1)
                                   : dictionary.find_first_of(",}", begin);
  return end == std::string::npos ? std::string() : dictionary.substr(begin, end - begin);
}

std::optional<SampleType> typeOf(std::string_view descr) {
  if (descr == "b1") return SampleType::Bool;
  if (descr.size() != 2) return std::nullopt;
  const std::string bits = std::to_string(8 * (descr[1] - '0'));
  if (descr[0] == 'f') return sampleTypeNamed("float" + bits);
  if (descr[0] == 'i') return sampleTypeNamed("int" + bits);
  if (descr[0] == 'u') return sampleTypeNamed("uint" + bits);
  return std::nullopt;
}

}  // namespace

Result<NpyArray> readNpyArray(const std::function<Result<std::size_t>(std::span<std::byte>)>& read,
                              const Place& where) {
  const auto fill = [&](std::span<char> into) -> Result<void> {
    const auto got = read(std::as_writable_bytes(into));
    if (!got) return got.error();
    if (*got < into.size()) return invalid("is cut off within the header of a .npy file", where);
    return {};
  };
  std::array<char, 10> front{};
  if (auto done = fill(front); !done) return done.error();
  constexpr std::string_view kMagic = "\x93NUMPY";
  if (!std::string_view(front.data(), front.size()).starts_with(kMagic)) {
    return invalid("is not a .npy file: it does not begin with \\x93NUMPY", where);
  }
  const unsigned major = static_cast<unsigned char>(front[6]);
  if (major < 1 || major > 3) {
    return invalid(fmt::format("is of version {}.{}; versions 1 to 3 can be read", major,
                               static_cast<unsigned char>(front[7])),
                   where);
  }
  std::array<char, 4> size = {front[8], front[9], 0, 0};
  if (major > 1) {
    if (auto done = fill(std::span(size).last(2)); !done) return done.error();
  }
  std::uint64_t length = 0;
  for (std::size_t i = 0; i < size.size(); ++i) {
    length |= std::uint64_t{static_cast<unsigned char>(size[i])} << (8 * i);
  }
  constexpr std::uint64_t kLongest = 1U << 16U;
  if (length > kLongest) {
    return invalid(
        fmt::format("announces a header of {} bytes; at most {} are read", length, kLongest),
        where);
  }
  std::string dictionary(length, '\0');
  if (auto done = fill(dictionary); !done) return done.error();

  std::string descr = valueOf(dictionary, "descr");
  const std::string fortran = valueOf(dictionary, "fortran_order");
  const std::string shape = valueOf(dictionary, "shape");
  if (descr.size() < 3 || shape.empty() || (fortran != "True" && fortran != "False")) {
    return invalid(fmt::format("its header lacks 'descr', 'fortran_order' or 'shape': '{}'",
                               shown(dictionary)),
                   where);
  }
  descr.erase(0, 1);  // the quote
  const char order = descr.front();
  const auto type = typeOf(std::string_view(descr).substr(1));
  if (!type || (order != '<' && order != '>' && order != '|')) {
    return invalid(fmt::format("has samples of type '{}'; bools, integers, and floats of 32 and 64 "
                               "bits can be used",
                               shown(descr)),
                   where);
  }
  NpyArray array;
  array.type = *type;
  array.order = order == '>' ? std::endian::big : std::endian::little;
  array.fortran = fortran == "True";
  std::string text = shape.substr(1);
  std::ranges::replace(text, ',', ' ');
  for (const std::string& word : wordsOf(text)) {
    const auto count = numberIn<std::uint64_t>(word);
    if (!count) return invalid(fmt::format("has the shape '{}'", shown(shape)), where);
    array.shape.push_back(*count);
  }
  return array;
}

Result<Volume> readNpyHeader(const std::filesystem::path& path, std::string_view axes) {
  Volume volume;
  volume.where = path.string();
  auto opened = openHeader(path);
  if (!opened) return opened.error();
  std::ifstream& file = *opened;
  const auto array = readNpyArray(
      [&](std::span<std::byte> into) -> Result<std::size_t> {
        file.read(reinterpret_cast<char*>(into.data()), static_cast<std::streamsize>(into.size()));
        return static_cast<std::size_t>(file.gcount());
      },
      path);
  if (!array) return array.error();
  volume.type = array->type;
  volume.order = array->order;
  volume.sizes = array->shape;
  if (volume.sizes.size() != 3 && volume.sizes.size() != 4) {
    return invalid(fmt::format("is an array of {} axes; expected four, or three for a frame in "
                               "each file",
                               volume.sizes.size()),
                   volume.where);
  }
  volume.axes = !axes.empty() ? axes : volume.sizes.size() == 4 ? "txyz" : "xyz";
  if (volume.axes.size() == 4 && volume.sizes.size() == 3) std::erase(volume.axes, 't');
  if (volume.axes.size() != volume.sizes.size() || volume.axes.find('c') != std::string::npos) {
    return invalid(fmt::format("has {} axes, not those of '{}'", volume.sizes.size(), axes),
                   volume.where);
  }
  if (axes.empty()) volume.assumedAxes = volume.axes;
  volume.unsized = "xyz";
  if (!array->fortran) {
    std::ranges::reverse(volume.sizes);
    std::ranges::reverse(volume.axes);
  }
  volume.data = {{path, static_cast<std::uint64_t>(file.tellg())}};
  return volume;
}

}  // namespace t4d::voxel4d
