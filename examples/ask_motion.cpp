// Questions to a motion, in memory: is the mesh valid, what does it pass through, does it hit?
#include <cstdio>

#include <t4d/check.h>
#include <t4d/collide.h>
#include <t4d/envelope.h>
#include <t4d/motion.h>
#include <t4d/surface.h>
#include <t4d/sweep.h>

int main() {
  using namespace t4d;
  const auto cube = formats::readTriangleMesh("paper-cube.obj");
  const auto motion = formats::readMotion("paper-translation.json");
  if (!cube || !motion) return 4;
  auto other = cube->mesh;  // rests where the moving one ends
  for (model::Point3& vertex : other.vertices) vertex += motion->at(motion->timeEnd()).translation;
  const model::ScrewRun rest{.duration = motion->timeEnd()};
  const auto resting = model::chainScrews(0, {&rest, 1});

  model::Mesh moving;
  model::Mesh obstacle;
  if (!mesh4d::sweep(cube->mesh, *motion, {}, moving)) return 1;
  if (!mesh4d::sweep(other, *resting, {}, obstacle)) return 1;
  const auto checked = measure::checkMesh(moving);
  const auto silhouette = measure::silhouetteOf(moving);
  if (!checked || !silhouette) return 1;
  const auto envelope = edit::envelopeOf(*silhouette, {.exact = true});
  const auto collision = measure::collide(moving, obstacle);
  if (!envelope || !collision || !collision->contact()) return 1;
  std::printf("%s, passes through a volume of %.0f, hits at %g\n",
              checked->valid() ? "valid" : "invalid", envelope->volume,
              collision->intervals.front().begin);
}
