#include "python/bindings/frame_iterator.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <pybind11/numpy.h>

#include "t4d/voxel4d/array_frames.h"

namespace t4d::python {
namespace {

template <class T>
Result<voxel4d::Frame> frameFrom(const py::array& packed, double time,
                                 const voxel4d::ArrayOptions& options) {
  const voxel4d::ArrayFrame<T> frame{
      time, {static_cast<const T*>(packed.data()), static_cast<std::size_t>(packed.size())}};
  const Unlocked unlocked;
  auto source = voxel4d::arrayFrames<T>(std::span(&frame, 1), options);
  if (!source) return t4d::pass(source.error());
  return (*source)->frame(0);
}

}  // namespace

FrameIterator::FrameIterator(Era begun, py::iterator frames, std::vector<double> times,
                             const voxel4d::Lattice& lattice, std::optional<double> iso)
    : begun_(begun),
      frames_(std::move(frames)),
      times_(std::move(times)),
      lattice_(lattice),
      iso_(iso) {}

// NOLINTNEXTLINE(bugprone-exception-escape): to take the lock of Python throws nothing
FrameIterator::~FrameIterator() {
  const Locked locked(begun_);
  frames_ = {};
  raised.reset();
}

Result<voxel4d::Frame> FrameIterator::frame(std::size_t index) {
  const Locked locked(begun_);
  try {
    const auto next =
        py::reinterpret_steal<py::object>(usingPython([&] { return PyIter_Next(frames_.ptr()); }));
    if (next) return frameOf(next, index);
    if (PyErr_Occurred() != nullptr) throw py::error_already_set();
    return invalid(
        fmt::format("{} times for only {} frame{}", times_.size(), index, index == 1 ? "" : "s"));
  } catch (py::error_already_set& error) {
    raised = error;
    return fail(ErrorCode::Failed, "the iterator of frames raised an exception");
  }
}

Result<voxel4d::Frame> FrameIterator::frameOf(const py::object& given, std::size_t index) {
  const std::string where = fmt::format("frame {}", index);
  const auto array = py::array::ensure(given, py::array::c_style);
  if (!array) {
    PyErr_NoMemory();
    throw py::error_already_set();
  }
  const std::vector<py::ssize_t> shape(array.shape(), array.shape() + array.ndim());
  if (shape.size() != 3) {
    return invalid(fmt::format("the array has the shape ({}); expected is (nx, ny, nz)",
                               fmt::join(shape, ", ")),
                   where);
  }
  if (index == 0) shape_ = shape;
  if (shape != shape_) {
    return invalid(fmt::format("the array has the shape ({}), frame 0 ({})", fmt::join(shape, ", "),
                               fmt::join(shape_, ", ")),
                   where);
  }
  voxel4d::ArrayOptions options;
  for (std::size_t i = 0; i < 3; ++i) options.size[i] = static_cast<std::size_t>(shape[i]);
  options.lattice = lattice_;
  options.iso = iso_;
  const py::dtype type = array.dtype();
  auto made = [&]() -> Result<voxel4d::Frame> {
    if (type.equal(py::dtype::of<float>())) return frameFrom<float>(array, times_[index], options);
    if (type.equal(py::dtype::of<double>())) {
      return frameFrom<double>(array, times_[index], options);
    }
    if (type.equal(py::dtype::of<bool>())) return frameFrom<bool>(array, times_[index], options);
    return invalid(
        fmt::format("the array is of {}; expected are floats or bool, or whole numbers with an iso",
                    std::string(py::str(py::object(type)))));
  }();
  if (!made) {
    Error error = made.error();
    error.where = where;
    return t4d::pass(error);
  }
  return made;
}

}  // namespace t4d::python
