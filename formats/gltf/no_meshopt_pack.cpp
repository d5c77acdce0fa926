#include "formats/gltf/meshopt_pack.h"
#include "t4d/surface.h"

namespace t4d::formats {

bool hasMeshopt() { return false; }

std::optional<std::vector<unsigned char>> meshoptPacked(std::span<const unsigned char> /*bytes*/,
                                                        std::size_t /*elementBytes*/,
                                                        bool /*isTriangles*/) {
  return std::nullopt;
}

Result<std::vector<unsigned char>> meshoptUnpacked(std::span<const unsigned char> /*packed*/,
                                                   const MeshoptView& /*view*/) {
  return fail(ErrorCode::Unsupported, "this build has no meshoptimizer");
}

}  // namespace t4d::formats
