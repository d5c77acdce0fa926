// Motions as functions of time: a rigid one, and a mesh that is computed at each time.
#include <cmath>
#include <cstdio>
#include <span>

#include <t4d/check.h>
#include <t4d/sweep.h>

int main() {
  using namespace t4d;
  const model::TriangleMesh solid = {.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                                     .triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}};
  const auto swing = [](double t) {
    return model::Pose{Eigen::AngleAxisd(std::sin(t), Eigen::Vector3d::UnitZ()).matrix(),
                       {t, 0, 0}};
  };
  const model::FunctionKeys breathing({0, 0.5, 1}, [&](double t, std::span<model::Point3> into) {
    for (std::size_t i = 0; i < into.size(); ++i) into[i] = (1 + t) * solid.vertices[i];
  });
  const auto motion = model::sampledMotion(swing, model::evenTimes({0, 1}, 11));
  if (!motion) return 4;
  measure::MeshChecker rigid;
  measure::MeshChecker scaled;
  if (!mesh4d::sweep(solid, *motion, {}, rigid)) return 1;
  if (!mesh4d::sweep(solid, breathing, {}, scaled)) return 1;
  // The volume is (1 + t)^3 / 6, whose integral is 15 / 24.
  const measure::MeshReport swung = rigid.finish();
  std::printf("%s, %.6f and %.6f\n", swung.valid() ? "valid" : "invalid", swung.hypervolume,
              scaled.finish().hypervolume);
}
