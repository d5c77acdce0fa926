#include "voxel4d/volumes/header_text.h"

#include <cerrno>
#include <cstring>
#include <limits>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "platform/regular_file.h"

namespace t4d::voxel4d {

namespace {

constexpr std::array<std::pair<std::string_view, SampleType>, 11> kTypeNames = {{
    {"bool", SampleType::Bool},
    {"int8", SampleType::Int8},
    {"uint8", SampleType::UInt8},
    {"int16", SampleType::Int16},
    {"uint16", SampleType::UInt16},
    {"int32", SampleType::Int32},
    {"uint32", SampleType::UInt32},
    {"int64", SampleType::Int64},
    {"uint64", SampleType::UInt64},
    {"float32", SampleType::Float32},
    {"float64", SampleType::Float64},
}};

}  // namespace

std::optional<SampleType> sampleTypeNamed(std::string_view name) {
  for (const auto& [known, type] : kTypeNames) {
    if (known == name) return type;
  }
  return std::nullopt;
}

std::string_view nameOf(SampleType type) {
  for (const auto& [name, known] : kTypeNames) {
    if (known == type) return name;
  }
  return "unknown";
}

Result<std::ifstream> openHeader(const std::filesystem::path& path) {
  const auto size = platform::sizeOfRegularFile(path);
  if (!size) return size.error();
  if (*size == 0) return invalid("is empty", path.string());
  std::ifstream file(path, std::ios::binary);
  if (!file) {
    return fail(ErrorCode::Io, std::string("cannot open: ") + std::strerror(errno), path.string());
  }
  return file;
}

Error namesOtherFolder(const std::string& header, std::string_view name) {
  return invalid(fmt::format("names the data file '{}'; it must be in the same folder or below, so "
                             "that a header from elsewhere cannot have other files read",
                             shown(name)),
                 header);
}

Result<void> checkDataFile(const std::string& header, const std::filesystem::path& file) {
  std::error_code ignored;
  const std::filesystem::path folder = std::filesystem::path(header).parent_path();
  if (!std::filesystem::exists(file, ignored) || platform::isWithinFolder(file, folder)) return {};
  return namesOtherFolder(header, file.lexically_relative(folder).string());
}

Result<std::uint64_t> bytesOfSamples(const Volume& volume) {
  constexpr std::uint64_t kMost = std::uint64_t{1} << 62U;
  std::uint64_t bytes = sizeOf(volume.type);
  for (const std::uint64_t size : volume.sizes) {
    if (size == 0 || size > std::numeric_limits<std::int32_t>::max() || bytes > kMost / size) {
      return invalid(fmt::format("announces {} samples; expected 1 to 2147483647 along each "
                                 "axis, and at most 2^62 bytes in all",
                                 fmt::join(volume.sizes, " x ")),
                     volume.where);
    }
    bytes *= size;
  }
  return bytes;
}

}  // namespace t4d::voxel4d
