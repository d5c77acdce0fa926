#pragma once

#include <string>
#include <vector>

#include "t4d/model/error.h"

namespace t4d::tools {

struct Finished {
  int exitCode = 0;
  std::string output;  ///< what it wrote to standard output
};

/// Runs this program again, as a process of its own, with other arguments: what it measures of
/// itself is then of this work alone. It shares standard error.
Result<Finished> runSelf(const std::vector<std::string>& arguments);

}  // namespace t4d::tools
