#pragma once

#include "python/bindings/errors.h"

namespace t4d::python {

/// Motion, and ways to make one.
void defineMotions(py::module_& module);

}  // namespace t4d::python
