#include "python/bindings/bodies.h"
#include "python/bindings/gil.h"
#include "python/bindings/motions.h"
#include "python/bindings/producers.h"
#include "python/bindings/triangles.h"
#include "t4d/file.h"

// What the Python files of the package are built on. Users import t4d.
PYBIND11_MODULE(_t4d, module) {
  module.attr("version") = T4D_VERSION;
  module.def("end", &t4d::python::end);
  t4d::formats::readUrls();
  t4d::python::defineTriangles(module);
  t4d::python::defineMotions(module);
  t4d::python::defineBodies(module);
  t4d::python::defineProducers(module);
}
