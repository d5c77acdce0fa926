#include "t4d/formats/usd_animation.h"
#include "t4d/formats/usd_reader.h"
#include "tools/fuzz/loaded_mesh.h"

/// USD, text or a package of it: a triangle mesh, and its animation, whose keys go forward in time.
namespace t4d::fuzz {
namespace {

/// So large that few keys are made.
constexpr double kTolerance = 1e30;

void checkAnimation(const formats::InputFile& file) {
  const auto scene = formats::readUsdAnimation(file, {"", "", kTolerance});
  if (!scene) {
    must(!scene.error().message.empty() && scene.error().where.starts_with(file.path.string()),
         "a refusal says what and where");
    return;
  }
  must(!scene->bodies.empty(), "a scene has bodies");
  for (const auto& body : scene->bodies) {
    must(!body.name.empty() && !body.runs.empty(), "a body has a name and a run");
    std::vector<model::Point3> positions(body.mesh.vertices.size());
    for (const auto& run : body.runs) {
      must(run->count() >= 2, "a run lasts");
      for (std::uint64_t key = 1; key < run->count(); ++key) {
        must(run->time(key) > run->time(key - 1), "keys go forward");
      }
      must(run->positions(run->count() - 1, positions).has_value(), "samples were checked");
    }
  }
}

int test(std::span<const std::uint8_t> bytes) {
  if (bytes.empty()) return -1;
  const formats::InputFile file = {"/nowhere/scene.usda", std::string(bytes.begin(), bytes.end())};
  checkLoaded(formats::readUsd(file), file.path.string());
  checkAnimation(file);
  return 0;
}

}  // namespace
}  // namespace t4d::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return t4d::fuzz::test({data, size});
}
