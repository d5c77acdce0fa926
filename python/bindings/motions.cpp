#include "python/bindings/motions.h"

#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include "t4d/formats/motion_reader.h"
#include "t4d/model/motion.h"

namespace t4d::python {

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
      .def("at", [](const Motion& motion, double time) {
        Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
        matrix.topRows<3>() = motion.at(time).matrix();
        return matrix;
      });
  module.def("read_motion",
             [](const std::string& path) { return valueOf(formats::readMotion(path)); });
  module.def("parse_motion",
             [](const std::string& text) { return valueOf(formats::parseMotion(text, "motion")); });
  // Quaternions are rows (x, y, z, w).
  module.def("join_poses", [](const std::vector<double>& times, const Eigen::MatrixX3d& positions,
                              const Eigen::MatrixX4d& quaternions) {
    std::vector<model::KeyPose> poses(times.size());
    for (std::size_t i = 0; i < times.size(); ++i) {
      const auto row = static_cast<Eigen::Index>(i);
      poses[i].time = times[i];
      poses[i].position = positions.row(row);
      poses[i].quaternion = Eigen::Quaterniond(quaternions(row, 3), quaternions(row, 0),
                                               quaternions(row, 1), quaternions(row, 2));
    }
    return valueOf(model::joinPoses(poses));
  });
}

}  // namespace t4d::python
