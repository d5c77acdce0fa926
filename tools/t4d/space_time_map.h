#pragma once

#include <optional>
#include <string>

#include <Eigen/Core>

#include "t4d/mesh.h"
#include "tools/t4d/transform.h"

namespace t4d::tools {

/// The signed permutation of TransformOptions::axes; nothing for another text.
std::optional<Eigen::Matrix4d> axesMatrix(const std::string& axes);

/// Whether time becomes something else, by exchange or reversal.
bool mixesTime(const TransformOptions& options);

/// The map of the options, without axes that mix space and time.
model::Transform transformOf(const TransformOptions& options);

}  // namespace t4d::tools
