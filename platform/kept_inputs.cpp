#include "platform/kept_inputs.h"

#include <mutex>
#include <set>
#include <utility>

#include <sys/stat.h>

namespace t4d::platform {

namespace {

struct Noted {
  std::mutex mutex;
  std::size_t runs = 0;
  std::set<std::pair<dev_t, ino_t>> files;
};

Noted& noted() {
  static Noted all;
  return all;
}

}  // namespace

KeptInputs::KeptInputs() {
  const std::lock_guard lock(noted().mutex);
  ++noted().runs;
}

KeptInputs::~KeptInputs() {
  const std::lock_guard lock(noted().mutex);
  if (--noted().runs == 0) noted().files.clear();
}

void noteInput(const struct stat& file) {
  const std::lock_guard lock(noted().mutex);
  if (noted().runs > 0) noted().files.emplace(file.st_dev, file.st_ino);
}

void noteInput(const std::filesystem::path& path) {
  struct stat file {};
  if (::stat(path.c_str(), &file) == 0) noteInput(file);
}

bool isInput(const struct stat& file) {
  const std::lock_guard lock(noted().mutex);
  return noted().files.contains({file.st_dev, file.st_ino});
}

}  // namespace t4d::platform
