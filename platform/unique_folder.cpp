#include "platform/unique_folder.h"

#include <cstdlib>

#include <unistd.h>

namespace t4d::platform {

std::optional<std::filesystem::path> makeUniqueFolder(const std::filesystem::path& parent,
                                                      const std::string& prefix) {
  std::string name = (parent / (prefix + "XXXXXX")).string();
  if (mkdtemp(name.data()) == nullptr) return std::nullopt;
  return name;
}

}  // namespace t4d::platform
