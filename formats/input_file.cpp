#include "formats/input_file.h"

#include <cerrno>
#include <fstream>

#include <fmt/format.h>

#include "platform/regular_file.h"

namespace t4d::formats {

Place InputFile::atLine(std::uint64_t line) const { return {path.string(), line}; }

Place InputFile::atByte(std::uint64_t offset) const { return placeOfByte(path, offset); }

Result<InputFile> readInputFile(const std::filesystem::path& path) {
  const auto ioError = [&](std::string message) {
    return fail(ErrorCode::Io, std::move(message), path.string());
  };
  const auto size = platform::sizeOfRegularFile(path);
  if (!size) return size.error();
  if (*size == 0) return invalid("is empty", path.string());

  std::ifstream in(path, std::ios::binary);
  if (!in) return ioError(fmt::format("cannot open: {}", std::strerror(errno)));
  InputFile file{path, {}};
  try {
    file.bytes.resize(*size);
  } catch (const std::exception&) {
    return ioError(fmt::format("its {} bytes do not fit in memory", *size));
  }
  errno = 0;
  if (!in.read(file.bytes.data(), static_cast<std::streamsize>(*size))) {
    return ioError(fmt::format("cannot read: {}",
                               errno == 0 ? "the file has become shorter" : std::strerror(errno)));
  }
  return file;
}

}  // namespace t4d::formats
