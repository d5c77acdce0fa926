#pragma once

#include <cmath>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "fixtures/solids.h"
#include "t4d/motion.h"
#include "t4d/sweep.h"
#include "tools/t4d/input.h"

/// Meshes in memory, for tests of verbs.
namespace t4d::tools {

/// The unit cube that moves from one place to another along x, with speed 1.
inline model::Mesh movingCube(double from, double to) {
  model::TriangleMesh cube = fixtures::cube(1);
  for (model::Point3& vertex : cube.vertices) vertex.x() += from;
  const auto motion = formats::parseMotion(
      nlohmann::json{
          {"segments", {{{"duration", std::abs(to - from)}, {"translation", {to - from, 0, 0}}}}}}
          .dump(),
      "motion");
  EXPECT_TRUE(motion);
  model::Mesh mesh;
  EXPECT_TRUE(
      mesh4d::sweep(cube, *motion, {mesh4d::StepsPerSegment{2}, mesh4d::CapMethod::Cone}, mesh));
  return mesh;
}

inline Input inMemory(const std::string& name, const model::Mesh& mesh) {
  Input input{.name = name, .metadata = {}, .bodies = {{name, &mesh}}};
  input.metadata.bodies = {{name}};
  return input;
}

}  // namespace t4d::tools
