#include "platform/kept_inputs.h"

#include <mutex>
#include <set>

namespace t4d::platform {

namespace {

struct Noted {
  std::mutex mutex;
  std::size_t runs = 0;
  std::set<FileIdentity> files;
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

void noteInput(const FileIdentity& file) {
  const std::lock_guard lock(noted().mutex);
  if (noted().runs > 0) noted().files.insert(file);
}

void noteInput(const std::filesystem::path& path) {
  if (const auto file = identityOf(path)) noteInput(*file);
}

bool isInput(const FileIdentity& file) {
  const std::lock_guard lock(noted().mutex);
  return noted().files.contains(file);
}

}  // namespace t4d::platform
