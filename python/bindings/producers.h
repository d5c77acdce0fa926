#pragma once

#include <functional>
#include <memory>

#include "python/bindings/bodies.h"

namespace t4d::python {

/// The maker of a 4D mesh: each run puts its slabs into a sink, in time order.
struct Producer {
  std::function<Result<void>(model::Sink& sink, const model::Progress& progress)> run;
  /// Frames of an iterator come once; everything else can be run again.
  bool once = false;
  bool used = false;
  /// The exception of Python code in the run, which then fails.
  std::optional<py::error_already_set> raised = {};
};

/// Sweeps and weaves, and what can be done with them: they go to a file or into memory, or slab by
/// slab to Python.
void defineProducers(py::module_& module);

}  // namespace t4d::python
