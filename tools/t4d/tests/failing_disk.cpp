/// Simulates a disk that fails midway, for crash_test. When preloaded (LD_PRELOAD), it lets the
/// first calls that change files of a folder succeed and makes all later ones fail.
///
///   T4D_FAIL_FOLDER   the folder, an absolute path without links
///   T4D_FAIL_FROM     number of the first call that fails, counted from 1
///   T4D_FAIL_ERRNO    ENOSPC, EIO, ... as a number; with EROFS files cannot be removed either
#include <array>
#include <atomic>
#include <cerrno>
#include <cstdarg>
#include <cstdlib>
#include <cstring>
#include <string>

#include <dlfcn.h>
#include <fcntl.h>
#include <sys/uio.h>
#include <unistd.h>

namespace {

std::string setting(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? std::string() : value;
}

bool inFolder(const char* path) {
  static const std::string folder = setting("T4D_FAIL_FOLDER");
  return !folder.empty() && std::strncmp(path, folder.c_str(), folder.size()) == 0;
}

bool inFolder(int descriptor) {
  std::array<char, 4096> target{};
  const std::string link = "/proc/self/fd/" + std::to_string(descriptor);
  return ::readlink(link.c_str(), target.data(), target.size() - 1) > 0 && inFolder(target.data());
}

int reason() {
  static const int number = std::atoi(setting("T4D_FAIL_ERRNO").c_str());
  return number;
}

/// Counts a call; true, with errno set, if it must fail.
bool failsNow() {
  static const long from = std::atol(setting("T4D_FAIL_FROM").c_str());
  static std::atomic<long> calls = 0;
  if (++calls < from) return false;
  errno = reason();
  return true;
}

template <class Function>
Function* next(Function*, const char* name) {
  return reinterpret_cast<Function*>(::dlsym(RTLD_NEXT, name));
}

bool changes(int flags) { return (flags & O_ACCMODE) != O_RDONLY; }

}  // namespace

#define NEXT(function) next(&(function), #function)

extern "C" {

int open(const char* path, int flags, ...) {
  std::va_list list;
  va_start(list, flags);
  const mode_t mode = (flags & O_CREAT) != 0 ? va_arg(list, mode_t) : 0;
  va_end(list);
  if (changes(flags) && inFolder(path) && failsNow()) return -1;
  return NEXT(open)(path, flags, mode);
}

ssize_t write(int descriptor, const void* data, size_t size) {
  if (inFolder(descriptor) && failsNow()) return -1;
  return NEXT(write)(descriptor, data, size);
}

ssize_t writev(int descriptor, const iovec* parts, int count) {
  if (inFolder(descriptor) && failsNow()) return -1;
  return NEXT(writev)(descriptor, parts, count);
}

int fsync(int descriptor) {
  if (inFolder(descriptor) && failsNow()) return -1;
  return NEXT(fsync)(descriptor);
}

int rename(const char* from, const char* to) noexcept {
  if (inFolder(to) && failsNow()) return -1;
  return NEXT(rename)(from, to);
}

int unlink(const char* path) noexcept {
  if (reason() == EROFS && inFolder(path) && failsNow()) return -1;
  return NEXT(unlink)(path);
}

}  // extern "C"
