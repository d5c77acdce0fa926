#include "formats/gltf/draco_unpack.h"

namespace t4d::formats {

bool hasDraco() { return false; }

Result<std::vector<unsigned char>> dracoUnpacked(const DracoMesh& /*mesh*/) {
  return fail(ErrorCode::Unsupported, "this build has no Draco");
}

}  // namespace t4d::formats
