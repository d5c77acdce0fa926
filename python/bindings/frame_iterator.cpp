#include "python/bindings/frame_iterator.h"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <pybind11/numpy.h>

namespace t4d::python {
namespace {

/// The type of an array in the byte order of this machine; none for other types.
std::optional<voxel4d::SampleType> sampleTypeOf(const py::dtype& type) {
  using voxel4d::SampleType;
  const std::vector<std::pair<py::dtype, SampleType>> types = {
      {py::dtype::of<bool>(), SampleType::Bool},
      {py::dtype::of<std::int8_t>(), SampleType::Int8},
      {py::dtype::of<std::uint8_t>(), SampleType::UInt8},
      {py::dtype::of<std::int16_t>(), SampleType::Int16},
      {py::dtype::of<std::uint16_t>(), SampleType::UInt16},
      {py::dtype::of<std::int32_t>(), SampleType::Int32},
      {py::dtype::of<std::uint32_t>(), SampleType::UInt32},
      {py::dtype::of<std::int64_t>(), SampleType::Int64},
      {py::dtype::of<std::uint64_t>(), SampleType::UInt64},
      {py::dtype::of<float>(), SampleType::Float32},
      {py::dtype::of<double>(), SampleType::Float64},
  };
  for (const auto& [known, sample] : types) {
    if (type.equal(known)) return sample;
  }
  return std::nullopt;
}

}  // namespace

FrameIterator::FrameIterator(py::iterator frames, std::vector<double> times,
                             const voxel4d::Lattice& lattice, const voxel4d::ArrayInside& inside,
                             bool stay)
    : frames_(std::move(frames)),
      times_(std::move(times)),
      lattice_(lattice),
      inside_(inside),
      stay_(stay) {}

// NOLINTNEXTLINE(bugprone-exception-escape): to take the lock of Python throws nothing
FrameIterator::~FrameIterator() {
  if (work_.mustStop()) {
    frames_.release();
    return;
  }
  const Locked locked;
  frames_ = {};
}

Result<voxel4d::Frame> FrameIterator::frame(std::size_t index) {
  if (work_.mustStop()) return fail(ErrorCode::Failed, "interrupted");
  const Locked locked;
  try {
    const auto next =
        py::reinterpret_steal<py::object>(inPython([&] { return PyIter_Next(frames_.ptr()); }));
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
  const Place where = placeIn({}, fmt::format("frame {}", index));
  // What an iterator gives may be one array that it fills again and again. An array that repeats
  // its rows (strides of 0) may be larger than memory.
  auto array = py::reinterpret_borrow<py::array>(given);
  const auto repeats = [&] {
    return std::any_of(array.strides(), array.strides() + array.ndim(),
                       [](py::ssize_t stride) { return stride == 0; });
  };
  if (!stay_ || repeats()) array = py::array(given.attr("copy")());
  const std::vector<py::ssize_t> shape(array.shape(), array.shape() + array.ndim());
  if (shape.size() != 3) {
    return invalid(
        fmt::format("the array has the shape ({}); expected (nx, ny, nz)", fmt::join(shape, ", ")),
        where);
  }
  if (index == 0) shape_ = shape;
  if (shape != shape_) {
    return invalid(fmt::format("the array has the shape ({}), frame 0 ({})", fmt::join(shape, ", "),
                               fmt::join(shape_, ", ")),
                   where);
  }
  auto made = [&]() -> Result<voxel4d::Frame> {
    const auto type = sampleTypeOf(array.dtype());
    const std::string typeName = py::str(py::object(array.dtype()));
    if (!type) return invalid(fmt::format("the array is of {}; expected numbers", typeName));
    const auto rule = voxel4d::arrayRule(*type, typeName, inside_);
    if (!rule) return rule.error();
    voxel4d::SampleBox box{*type, static_cast<const std::byte*>(array.data()), {}, {}};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      box.size[axis] = static_cast<std::size_t>(shape[axis]);
      box.strides[axis] = array.strides(static_cast<py::ssize_t>(axis));
    }
    if (auto checked = voxel4d::checkArraySize(box.size); !checked) {
      return checked.error();
    }
    const std::shared_ptr<const py::array> owner(new py::array(array),
                                                 [work = work_](const py::array* kept) {
                                                   if (work.mustStop()) return;
                                                   const Locked locked;
                                                   delete kept;
                                                 });
    const Released released;
    auto signs = voxel4d::usableSignsOf(box, *rule);
    if (!signs) return signs.error();
    const auto outside = voxel4d::fieldOutside(*rule, signs->farthest);
    if (!outside) return outside.error();
    return voxel4d::frameOf(box, *rule, std::move(*signs), *outside, times_[index], owner);
  }();
  if (!made) {
    Error error = made.error();
    error.where = where;
    return error;
  }
  return made;
}

}  // namespace t4d::python
