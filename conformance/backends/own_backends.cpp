#include "conformance/backends/own_backends.h"

namespace t4d::conformance {

std::vector<std::unique_ptr<Backend>> ownBackends() {
  constexpr std::unique_ptr<Backend> (*kTable[])() = {
      meshBackend,
      voxelBackend,
      millBackend,
  };
  std::vector<std::unique_ptr<Backend>> backends;
  for (const auto make : kTable) backends.push_back(make());
  return backends;
}

}  // namespace t4d::conformance
