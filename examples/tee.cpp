// Sweeps the paper's cube into a file and checks the mesh in the same pass.
#include <cstdio>

#include <t4d/check.h>
#include <t4d/file.h>
#include <t4d/mesh.h>
#include <t4d/motion.h>
#include <t4d/surface.h>
#include <t4d/sweep.h>

int main() {
  using namespace t4d;
  const auto solid = formats::readTriangleMesh("paper-cube.obj");
  const auto motion = formats::readMotion("paper-translation.json");
  if (!solid || !motion) return 4;
  auto writer = formats::T4dWriter::create("paper-cube.t4d", {.bodies = {{"cube"}}});
  if (!writer) return 1;
  measure::MeshChecker checker;
  model::Tee both({&writer->body(0), &checker});
  if (!mesh4d::sweep(solid->mesh, *motion, {}, both)) return 1;
  if (!writer->finish()) return 1;  // gives the file its final name
  const measure::MeshReport report = checker.finish();
  std::printf("%s, %llu vertices, %llu tetrahedra, hypervolume %g\n",
              report.valid() ? "valid" : "invalid",
              static_cast<unsigned long long>(report.vertices),
              static_cast<unsigned long long>(report.tetrahedra), report.hypervolume);
}
