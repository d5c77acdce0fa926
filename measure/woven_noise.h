#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

#include "t4d/weave.h"
#include "voxel4d/sampled_frames.h"

/// Woven meshes with as much happening in them as possible, for tests.
namespace t4d::measure {

inline model::Mesh woven(const voxel4d::FieldFunction& field, const model::Bounds3& box,
                         double begin, double end, int frames, double voxel = 1, bool mask = false,
                         const voxel4d::WeaveOptions& options = {}) {
  std::vector<double> times;
  for (int i = 0; i <= frames; ++i) times.push_back(begin + (end - begin) * i / frames);
  voxel4d::SampleOptions sampling;
  sampling.mask = mask;
  sampling.band = 1e9;
  const auto source =
      voxel4d::sampledFrames(field, {voxel, model::Point3::Zero()}, box, times, sampling);
  model::Mesh mesh;
  const auto made = voxel4d::weave(*source, options, mesh);
  EXPECT_TRUE(made) << made.error().text();
  return mesh;
}

/// A number from -1 to 1 that looks random.
inline double noise(std::uint64_t seed, const model::Point3& point, double time) {
  std::uint64_t hash = seed * 0x9E3779B97F4A7C15U + 1;
  for (const double x : {point.x(), point.y(), point.z(), time}) {
    hash ^= static_cast<std::uint64_t>(static_cast<std::int64_t>(std::llround(x)) + 1000);
    hash *= 0xBF58476D1CE4E5B9U;
    hash ^= hash >> 29U;
  }
  return static_cast<double>(hash >> 11U) / static_cast<double>(1ULL << 52U) - 1;
}

inline voxel4d::FieldFunction noiseField(std::uint64_t seed, double shift) {
  return [=](const model::Point3& point, double time) {
    const double value = noise(seed, point, time) + shift;
    return value == 0 ? 0.01 : value;
  };
}

inline model::Bounds3 boxOf(double size) {
  model::Bounds3 box;
  box.add(model::Point3::Zero());
  box.add(model::Point3::Constant(size));
  return box;
}

}  // namespace t4d::measure
