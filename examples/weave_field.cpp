// Your own voxels: a field of space and time, negative inside, woven and measured. Two balls merge.
#include <algorithm>
#include <cstdio>

#include <t4d/check.h>
#include <t4d/frames.h>
#include <t4d/weave.h>

int main() {
  using namespace t4d;
  const voxel4d::FieldFunction balls = [](const model::Point3& p, double t) {
    const Eigen::Vector3d apart(1.5 - t, 0, 0);
    return std::min((p - apart).norm(), (p + apart).norm()) - 1;
  };
  const voxel4d::Lattice lattice = {.voxelSize = 0.1, .origin = {-3.05, -1.55, -1.55}};
  auto frames = voxel4d::fieldFrames({0, 0.25, 0.5, 0.75, 1}, {62, 32, 32}, lattice, balls);
  model::Mesh mesh;
  if (!frames || !voxel4d::weave(**frames, {}, mesh)) return 1;
  const auto report = measure::checkMesh(mesh);
  if (report) std::printf("%llu cells\n", static_cast<unsigned long long>(report->tetrahedra));
}
