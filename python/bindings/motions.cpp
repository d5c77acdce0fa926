#include "python/bindings/motions.h"

#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include "t4d/motion.h"

namespace t4d::python {
namespace {

using Rows = py::array_t<double, py::array::c_style | py::array::forcecast>;

/// 4 x 4.
py::array_t<double> matrixOf(const model::Pose& pose) {
  Eigen::Matrix4d values = Eigen::Matrix4d::Identity();
  values.topRows<3>() = pose.matrix();
  constexpr py::ssize_t kWidth = sizeof(double);
  py::array_t<double> matrix({4, 4}, {4 * kWidth, kWidth});
  for (py::ssize_t row = 0; row < 4; ++row) {
    for (py::ssize_t column = 0; column < 4; ++column) {
      matrix.mutable_at(row, column) = values(row, column);
    }
  }
  return matrix;
}

}  // namespace

// This avoids pybind11/eigen.h, whose copies of arrays need pybind11 2.12 where numpy is 2.

void defineMotions(py::module_& module) {
  using model::Motion;
  py::class_<Motion>(module, "Motion")
      .def_property_readonly(
          "time_span",
          [](const Motion& motion) { return py::make_tuple(motion.timeBegin(), motion.timeEnd()); })
      .def_readonly("length_unit", &Motion::lengthUnit)
      .def_readonly("time_unit", &Motion::timeUnit)
      .def_property_readonly(
          "notice", [](const Motion& motion) { return model::noticeOfHalfTurns(motion.halfTurns); })
      .def("at", [](const Motion& motion, double time) { return matrixOf(motion.at(time)); });
  module.def("read_motion",
             [](const std::string& path) { return valueOf(formats::readMotion(path)); });
  module.def("parse_motion",
             [](const std::string& text) { return valueOf(formats::parseMotion(text, "motion")); });
  // Quaternions are rows (x, y, z, w).
  module.def("join_poses",
             [](const std::vector<double>& times, const Rows& positions, const Rows& quaternions) {
               const auto place = positions.unchecked<2>();
               const auto turn = quaternions.unchecked<2>();
               std::vector<model::KeyPose> poses(times.size());
               for (std::size_t i = 0; i < times.size(); ++i) {
                 const auto row = static_cast<py::ssize_t>(i);
                 poses[i].time = times[i];
                 poses[i].position = {place(row, 0), place(row, 1), place(row, 2)};
                 poses[i].quaternion =
                     Eigen::Quaterniond(turn(row, 3), turn(row, 0), turn(row, 1), turn(row, 2));
               }
               return valueOf(model::joinPoses(poses));
             });
}

}  // namespace t4d::python
