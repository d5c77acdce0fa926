#include "platform/unique_folder.h"

#include <atomic>
#include <cerrno>

#include <fmt/format.h>

#include "platform/windows/system_file.h"

namespace t4d::platform {

std::optional<std::filesystem::path> makeUniqueFolder(const std::filesystem::path& parent,
                                                      const std::string& prefix) {
  constexpr int kAttempts = 1000;
  static std::atomic<std::uint64_t> made = 0;
  for (int i = 0; i < kAttempts; ++i) {
    // Only another process may have the name, from a time when its number was this one's.
    const auto folder = parent / fmt::format("{}{:x}-{:x}", prefix, GetCurrentProcessId(), made++);
    if (CreateDirectoryW(folder.c_str(), nullptr) != 0) return folder;
    setErrno();
    if (errno != EEXIST) break;
  }
  return std::nullopt;
}

}  // namespace t4d::platform
