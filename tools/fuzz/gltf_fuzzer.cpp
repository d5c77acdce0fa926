#include "formats/gltf/gltf_animation.h"
#include "formats/gltf/gltf_reader.h"
#include "tools/fuzz/loaded_mesh.h"

/// glTF, text or binary: a triangle mesh, and its animation, whose keys go forward in time.
namespace t4d::fuzz {
namespace {

int test(std::span<const std::uint8_t> bytes) {
  if (bytes.empty()) return -1;
  // The folder does not exist, so no buffers are read from disk.
  const formats::InputFile file = {"/nowhere/mesh.gltf", std::string(bytes.begin(), bytes.end())};
  checkLoaded(formats::readGltf(file, formats::Keep::Attributes), file.path.string());
  checkAnimation(formats::readGltfAnimation(file, {"", "", kFewKeys}), file.path.string());
  return 0;
}

}  // namespace
}  // namespace t4d::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return t4d::fuzz::test({data, size});
}
