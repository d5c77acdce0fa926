#include "voxel4d/frame_file.h"

#include <algorithm>
#include <utility>

namespace t4d::voxel4d {

Result<std::unique_ptr<FrameFile>> FrameFile::create() {
  auto file = platform::ScratchFile::create();
  if (!file) return file.error();
  return std::unique_ptr<FrameFile>(new FrameFile(std::move(*file)));
}

void FrameFile::read(std::uint64_t offset, std::span<std::byte> into) const {
  if (file_.read(offset, into)) return;
  std::ranges::fill(into, std::byte{0});
  whole_ = false;
}

Result<void> FrameFile::checkRead() const {
  if (whole_) return {};
  return fail(ErrorCode::Failed, "a temporary file cannot be read back (TMPDIR says where it is)");
}

}  // namespace t4d::voxel4d
