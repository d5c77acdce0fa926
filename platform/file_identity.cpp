#include <sys/stat.h>

#include "platform/kept_inputs.h"

namespace t4d::platform {

std::optional<FileIdentity> identityOf(const std::filesystem::path& path) {
  struct stat file {};
  if (::stat(path.c_str(), &file) != 0) return std::nullopt;
  return FileIdentity{file.st_dev, file.st_ino};
}

}  // namespace t4d::platform
