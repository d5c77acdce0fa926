#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <span>

#include "voxel4d/frame.h"

namespace t4d::voxel4d {

/// One frame as an array in memory: the value at lattice point (x, y, z) of nx x ny x nz points is
/// values[(x * ny + y) * nz + z].
template <class T>
struct ArrayFrame {
  double time = 0;
  std::span<const T> values = {};
};

struct ArrayOptions {
  std::array<std::size_t, 3> size = {0, 0, 0};  ///< nx, ny, nz, the same for all frames
  Lattice lattice = {};                         ///< its origin is the position of point (0, 0, 0)
  /// Values above this are inside. Without it, values below zero are.
  std::optional<double> iso = {};
};

/// Frames for `weave` from arrays of float or double values, or of bools that are true inside.
/// Everything beyond the arrays is outside. An array is read when its frame is requested, so the
/// arrays must outlive the source.
///
/// Fails for a size of zero or of more than 2^31 - 1 points along an axis, an array of another
/// length, a value that is not finite, a voxel size that is not positive, `iso` with bools, and
/// values that differ from `iso` by too little for T.
template <class T>
Result<std::unique_ptr<FrameSource>> arrayFrames(std::span<const ArrayFrame<T>> frames,
                                                 const ArrayOptions& options);

extern template Result<std::unique_ptr<FrameSource>> arrayFrames<float>(
    std::span<const ArrayFrame<float>> frames, const ArrayOptions& options);
extern template Result<std::unique_ptr<FrameSource>> arrayFrames<double>(
    std::span<const ArrayFrame<double>> frames, const ArrayOptions& options);
extern template Result<std::unique_ptr<FrameSource>> arrayFrames<bool>(
    std::span<const ArrayFrame<bool>> frames, const ArrayOptions& options);

}  // namespace t4d::voxel4d
