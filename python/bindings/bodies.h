#pragma once

#include <array>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "python/bindings/watch.h"
#include "t4d/file.h"
#include "t4d/slice.h"

namespace t4d::python {

/// A 4D mesh whose slabs can be had in any order: in a file or in memory.
struct Body {
  std::shared_ptr<const model::Source> source;
  formats::BodyInfo info;
  std::string lengthUnit;
  std::string timeUnit;
  std::string up = "y";
  std::string backend = {};
  std::string detailsJson = "{}";
  std::string version = {};  ///< of the file; "" in memory
  std::vector<std::string> features = {};
  std::shared_ptr<const formats::T4dReader> file = nullptr;  ///< null in memory

  /// Keeps what it has found of the connectivity, so that the next slice is faster.
  const slice::TimeSlicer& slicer(slice::WithMotion withMotion) const;
  const slice::LightSlicer& lightSlicer(slice::WithMotion withMotion) const;

 private:
  // There are two slicers of each kind: without and with motion.
  mutable std::mutex mutex_;
  mutable std::array<std::unique_ptr<slice::TimeSlicer>, 2> slicers_;
  mutable std::array<std::unique_ptr<slice::LightSlicer>, 2> lightSlicers_;
};

/// Body and Slab, reading and writing of files.
void defineBodies(py::module_& module);

}  // namespace t4d::python
