// Weaves a ball that moves along x from arrays of distances in memory.
#include <cmath>
#include <cstdio>
#include <vector>

#include <t4d/check.h>
#include <t4d/frames.h>
#include <t4d/mesh.h>
#include <t4d/weave.h>

int main() {
  using namespace t4d;
  constexpr std::size_t n = 48;
  const voxel4d::Lattice lattice = {.voxelSize = 0.1, .origin = {-2, -2.35, -2.35}};
  std::vector<std::vector<float>> arrays;  // 11 frames of n x n x n values, negative inside
  std::vector<voxel4d::ArrayFrame<float>> frames;
  for (int f = 0; f <= 10; ++f) {
    auto& values = arrays.emplace_back();
    for (std::size_t i = 0; i < n * n * n; ++i) {
      const Eigen::Vector3d point =
          Eigen::Array<std::size_t, 3, 1>(i / n / n, i / n % n, i % n).cast<double>();
      const Eigen::Vector3d centre(0.05 * f, 0, 0);
      values.push_back(static_cast<float>((lattice(point) - centre).norm() - 1.5));
    }
    frames.push_back({.time = 0.1 * f, .values = values});
  }
  const auto source = voxel4d::arrayFrames<float>(frames, {{n, n, n}, lattice});
  if (!source) return 4;
  measure::MeshChecker checker;  // a sink; a model::Mesh keeps the slabs, a T4dWriter writes them
  if (!voxel4d::weave(**source, {}, checker)) return 1;
  const measure::MeshReport report = checker.finish();
  const double expected = 4.0 / 3 * M_PI * std::pow(1.5, 3);
  std::printf("%s, hypervolume %.3f of %.3f\n", report.valid() ? "valid" : "invalid",
              report.hypervolume, expected);
}
