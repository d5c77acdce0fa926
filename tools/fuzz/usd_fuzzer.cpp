#include "t4d/formats/usd/usd_animation.h"
#include "t4d/formats/usd/usd_reader.h"
#include "tools/fuzz/loaded_mesh.h"

/// USD, text or a package of it: a triangle mesh, and its animation, whose keys go forward in time.
namespace t4d::fuzz {
namespace {

int test(std::span<const std::uint8_t> bytes) {
  if (bytes.empty()) return -1;
  const formats::InputFile file = {"/nowhere/scene.usda", std::string(bytes.begin(), bytes.end())};
  checkLoaded(formats::readUsd(file), file.path.string());
  checkAnimation(formats::readUsdAnimation(file, {"", "", kFewKeys}), file.path.string());
  return 0;
}

}  // namespace
}  // namespace t4d::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return t4d::fuzz::test({data, size});
}
