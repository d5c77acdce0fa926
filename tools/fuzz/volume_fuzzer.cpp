#include <array>
#include <string>

#include <fmt/format.h>

#include "platform/temporary_folder.h"
#include "t4d/frames.h"
#include "tools/fuzz/fuzz.h"
#include "voxel4d/frame_formats.h"

/// A volume file: the first byte says of which format.
namespace t4d::fuzz {
namespace {

// A byte of gzip is 1,032 at most, and a block has up to 512 values of 8 bytes for one in the file.
constexpr std::size_t kMemoryPerFileByte = std::size_t{1032} * 8 * 4;
constexpr std::size_t kMemoryAlways = std::size_t{8} << 20;

/// The file under a name of each extension.
class Names {
 public:
  explicit Names(const std::filesystem::path& file) : folder_(platform::TemporaryFolder::create()) {
    must(folder_.has_value(), "there is a folder for temporary files");
    for (const std::string_view extension : voxel4d::volumeExtensions()) {
      std::filesystem::create_symlink(file, pathOf(extension));
    }
  }
  std::filesystem::path pathOf(std::string_view extension) const {
    return folder_->path() / ("f" + std::string(extension));
  }

 private:
  Result<platform::TemporaryFolder> folder_;
};

int test(std::span<const std::uint8_t> bytes) {
  static MemoryFile file;
  static const Names names(file.path());
  if (bytes.empty()) return 0;
  const auto extensions = voxel4d::volumeExtensions();
  const std::string_view extension = extensions[bytes[0] % extensions.size()];
  file.set(bytes.subspan(1));
  const HeapMeter heap;
  voxel4d::VolumeOptions options;
  options.frameTime = 1;
  const int choice = bytes[0] / 16 % 3;
  if (choice == 1) options.iso = 0.5;
  if (choice == 2) options.label = 1;
  if (bytes[0] / 48 % 2 == 1) options.region = voxel4d::Region{{{{0, 2}, {}, {1, {}}}}, {}};
  auto opened = voxel4d::openVolumeFrames(std::array{names.pathOf(extension)}, options);
  if (!opened) {
    must(!opened.error().message.empty(), "a refusal says what");
    return 0;
  }
  must(opened->frames->frameCount() >= 2, "there are two frames or more");
  constexpr std::size_t kMostFrames = 4;
  for (std::size_t i = 0; i < std::min(kMostFrames, opened->frames->frameCount()); ++i) {
    const auto frame = opened->frames->frame(i);
    if (!frame) {
      must(!frame.error().message.empty(), "a refusal says what");
      return 0;
    }
    const auto checked = voxel4d::checkFrame(*frame);
    must(checked.has_value(), checked ? "" : checked.error().message.c_str());
  }
  must(heap.peak() <= kMemoryPerFileByte * bytes.size() + kMemoryAlways,
       fmt::format("reading {} bytes takes {} of memory", bytes.size(), heap.peak()));
  return 0;
}

}  // namespace
}  // namespace t4d::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return t4d::fuzz::test({data, size});
}
