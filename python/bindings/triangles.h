#pragma once

#include "python/bindings/arrays.h"

namespace t4d::python {

/// TriangleMesh, and reading and writing of it.
void defineTriangles(py::module_& module);

}  // namespace t4d::python
