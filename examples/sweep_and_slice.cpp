#include <formats/motion/motion_reader.h>
#include <formats/triangle/triangle_mesh_reader.h>
#include <formats/triangle/triangle_mesh_writer.h>
#include <mesh4d/sweep.h>
#include <slice/slice.h>

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
