#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "python/bindings/gil.h"
#include "t4d/frames.h"
#include "voxel4d/sample_box.h"

namespace t4d::python {

/// Frames from a Python iterator of arrays (nx, ny, nz) of numbers or bool, all of one shape. Two
/// are in memory at a time.
class FrameIterator : public voxel4d::FrameSource {
 public:
  /// Arrays that `stay` what they are until the work ends are not copied. Needs the GIL, in the
  /// thread that begins the work.
  FrameIterator(py::iterator frames, std::vector<double> times, const voxel4d::Lattice& lattice,
                const voxel4d::ArrayInside& inside, bool stay);
  ~FrameIterator() override;

  const voxel4d::Lattice& lattice() const override { return lattice_; }
  std::size_t frameCount() const override { return times_.size(); }
  Result<voxel4d::Frame> frame(std::size_t index) override;

  /// The exception of the iterator, if it raised one.
  std::optional<py::error_already_set> raised;

 private:
  Result<voxel4d::Frame> frameOf(const py::object& given, std::size_t index);

  Work work_;
  py::iterator frames_;
  std::vector<double> times_;
  voxel4d::Lattice lattice_;
  voxel4d::ArrayInside inside_;
  bool stay_;
  std::vector<py::ssize_t> shape_;
};

}  // namespace t4d::python
