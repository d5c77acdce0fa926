#include <t4d/motion.h>
#include <t4d/slice.h>
#include <t4d/surface.h>
#include <t4d/sweep.h>

int main() {
  using namespace t4d;
  const auto solid = formats::readTriangleMesh("bolt.obj");
  const auto motion = formats::readMotion("screw-in.json");
  if (!solid || !motion) return 4;
  // Slabs go to any sink: a model::Mesh keeps them, a formats::T4dWriter writes them.
  slice::Slicer slicer(slice::Hyperplane::atTime(2.5));
  if (!mesh4d::sweep(solid->mesh, *motion, {}, slicer)) return 1;
  const formats::NamedMesh slice{"bolt", slicer.finish().mesh};
  return formats::writeTriangleMeshes("bolt-at-2.5.stl", {&slice, 1}) ? 0 : 1;
}
