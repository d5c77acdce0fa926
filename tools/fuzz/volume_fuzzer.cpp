#include <array>
#include <charconv>
#include <map>
#include <string>

#include <fmt/format.h>
#include <unistd.h>

#include "t4d/voxel4d/frame.h"
#include "t4d/voxel4d/volumes/volume_frames.h"
#include "tools/fuzz/fuzz.h"

/// A volume file: the first byte says of which format. For Zarr files follow, each after a line
/// with its name and size.
namespace t4d::fuzz {
namespace {

// A byte of gzip is 1,032 at most, and a block has up to 512 values of 8 bytes for one in the file.
constexpr std::size_t kMemoryPerFileByte = std::size_t{1032} * 8 * 4;
constexpr std::size_t kMemoryAlways = std::size_t{8} << 20;

/// The file under a name of each extension.
class Names {
 public:
  explicit Names(const std::filesystem::path& file) {
    std::string name = (std::filesystem::temp_directory_path() / "fuzz-volume-XXXXXX").string();
    must(mkdtemp(name.data()) != nullptr, "there is a folder for temporary files");
    folder_ = name;
    for (const std::string_view extension : voxel4d::volumeExtensions()) {
      std::filesystem::create_symlink(file, pathOf(extension));
    }
  }
  ~Names() { std::filesystem::remove_all(folder_); }
  std::filesystem::path pathOf(std::string_view extension) const {
    return folder_ / ("f" + std::string(extension));
  }

 private:
  std::filesystem::path folder_;
};

// Of Zarr, whose frames may be empty without any chunk.
constexpr std::size_t kZarrPerFileByte = std::size_t{1} << 18U;
constexpr std::size_t kZarrAlways = std::size_t{1} << 30U;

/// A web server with the files of an input.
system::WebFiles serverOf(std::string_view input) {
  std::map<std::string, std::string> files;
  while (!input.empty()) {
    const std::string_view line = input.substr(0, input.find('\n'));
    input.remove_prefix(std::min(input.size(), line.size() + 1));
    const std::size_t space = std::min(line.find(' '), line.size());
    std::size_t size = 0;
    std::from_chars(line.data() + std::min(space + 1, line.size()), line.data() + line.size(),
                    size);
    size = std::min(size, input.size());
    files[std::string(line.substr(0, space))] = input.substr(0, size);
    input.remove_prefix(size);
  }
  return [files](const std::string& url, const std::string&,
                 std::uint64_t) -> Result<std::optional<system::WebFile>> {
    const auto found = files.find(url.substr(std::string_view("http://fuzz/a.zarr/").size()));
    if (found == files.end()) return std::nullopt;
    return system::WebFile{found->second, true};
  };
}

int test(std::span<const std::uint8_t> bytes) {
  static MemoryFile file;
  static const Names names(file.path());
  if (bytes.empty()) return 0;
  const auto extensions = voxel4d::volumeExtensions();
  const std::string_view extension = extensions[bytes[0] % extensions.size()];
  std::vector<std::filesystem::path> files = {names.pathOf(extension)};
  file.set(bytes.subspan(1));
  const HeapMeter heap;
  voxel4d::VolumeOptions options;
  const bool isZarr = extension == ".zarr";
  if (isZarr) {
    files = {"http://fuzz/a.zarr"};
    options.web = serverOf({reinterpret_cast<const char*>(bytes.data()) + 1, bytes.size() - 1});
  }
  options.frameTime = 1;
  const int choice = bytes[0] / 16 % 3;
  if (choice == 1) options.iso = 0.5;
  if (choice == 2) options.label = 1;
  if (bytes[0] / 48 % 2 == 1) options.region = voxel4d::Region{{{{0, 2}, {}, {1, {}}}}, {}};
  auto opened = voxel4d::openVolumeFrames(files, options);
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
  must(heap.peak() <= (isZarr ? kZarrPerFileByte : kMemoryPerFileByte) * bytes.size() +
                          (isZarr ? kZarrAlways : kMemoryAlways),
       fmt::format("reading {} bytes takes {} of memory", bytes.size(), heap.peak()));
  return 0;
}

}  // namespace
}  // namespace t4d::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return t4d::fuzz::test({data, size});
}
