#include "tools/t4d/input_identity.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace t4d::tools {

nlohmann::ordered_json identityOf(const Input& input, std::uint64_t times) {
  auto identity = nlohmann::ordered_json::object();
  if (input.reader) identity["bytes"] = input.reader->fileBytes();
  identity["slabs"] = slabCountOf(input.bodies);
  if (input.reader) {
    std::uint64_t cells = 0;
    for (std::size_t i = 0; i < input.reader->bodyCount(); ++i) {
      cells += input.reader->summary(i).tetrahedra;
    }
    identity["tetrahedra"] = cells;
    identity["fingerprint"] = fmt::format("{:08x}", input.reader->fingerprint());
  }
  if (times > 0) identity["times"] = times;
  return identity;
}

}  // namespace t4d::tools
