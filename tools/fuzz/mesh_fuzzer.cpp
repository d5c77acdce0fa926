#include "formats/triangle/obj_reader.h"
#include "formats/triangle/off_reader.h"
#include "formats/triangle/ply_reader.h"
#include "formats/triangle/stl_reader.h"
#include "formats/vtk/vtk_surface_reader.h"
#include "tools/fuzz/loaded_mesh.h"

/// A triangle mesh as STL, OBJ, PLY, OFF, .vtp ('v') or .vtu ('u'): the first byte selects the
/// format, the file follows.
namespace t4d::fuzz {
namespace {

Result<formats::LoadedMesh> read(char format, const formats::InputFile& file) {
  switch (format) {
    case 's':
      return formats::readStl(file, formats::Keep::Attributes);
    case 'o':
      return formats::readObj(file, formats::Keep::Attributes);
    case 'p':
      return formats::readPly(file, formats::Keep::Attributes);
    case 'v':
      return formats::readVtp(file, formats::Keep::Attributes);
    case 'u':
      return formats::readVtuSurface(file, formats::Keep::Attributes);
    default:
      return formats::readOff(file, formats::Keep::Attributes);
  }
}

int test(std::span<const std::uint8_t> bytes) {
  // The readers are never called with an empty file.
  if (bytes.size() < 2) return -1;
  const char format = static_cast<char>(bytes.front());
  if (std::string("sopfvu").find(format) == std::string::npos) return -1;
  const formats::InputFile file = {"mesh", std::string(bytes.begin() + 1, bytes.end())};
  const HeapMeter heap;
  checkLoaded(read(format, file), "mesh");
  // Compressed arrays may unpack to hundreds of megabytes.
  const bool unpacks = format == 'v' || format == 'u';
  must(unpacks || heap.peak() <= 256 * bytes.size() + 65536,
       "reading takes " + std::to_string(heap.peak()) + " bytes");
  return 0;
}

}  // namespace
}  // namespace t4d::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return t4d::fuzz::test({data, size});
}
