#include <fmt/format.h>

#include "t4d/voxel4d/volumes/dicom_codec.h"

namespace t4d::voxel4d {

Result<std::string> unpackDicomImage(const DicomPacked& image) {
  return fail(
      ErrorCode::Unsupported,
      fmt::format("is compressed (transfer syntax {}), and this build has no GDCM to unpack "
                  "it with; store it without compression",
                  image.syntax));
}

}  // namespace t4d::voxel4d
