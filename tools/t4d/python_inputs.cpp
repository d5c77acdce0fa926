#include "tools/t4d/python_inputs.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <set>
#include <string_view>
#include <vector>

#include "formats/file_extension.h"
#include "formats/t4d/url.h"
#include "t4d/frames.h"
#include "tools/t4d/mesh_frames.h"
#include "voxel4d/frame_formats.h"

namespace t4d::tools {
namespace {

namespace fs = std::filesystem;

/// The kind of a file by its extension; "" for any other.
std::string byExtension(const std::string& path) {
  struct Row {
    const char* kind;
    std::vector<std::string_view> extensions;
  };
  static const std::vector<Row> kRows = {
      {"DICOM", {".dcm"}},
      {"TIFF", {".tif", ".tiff"}},
      {"Zarr", {".zarr"}},
      {"HDF5", {".h5", ".hdf5", ".hdf", ".nc", ".nc4"}},
      {"a medical image", {".mha", ".mhd", ".mgz", ".mgh", ".mnc"}},
      {"a volume of VTK", {".vti"}}};
  const std::string extension = formats::lowerCaseExtension(path);
  for (const Row& row : kRows) {
    if (std::ranges::find(row.extensions, extension) != row.extensions.end()) return row.kind;
  }
  return {};
}

/// DICOM has 128 bytes of anything, and then its name.
bool isDicom(const fs::path& file) {
  constexpr std::size_t kBefore = 128;
  std::array<char, kBefore + 4> bytes{};
  std::ifstream in(file, std::ios::binary);
  in.read(bytes.data(), bytes.size());
  return in && std::string_view(bytes.data(), bytes.size()).substr(kBefore) == "DICM";
}

/// The kind of a file. Files that the program reads itself are not opened.
std::string kindOfFile(const fs::path& file) {
  std::string kind = byExtension(file.string());
  const bool isOwn = voxel4d::isVolumeFile(file) || isMeshFrame(file.string()) ||
                     formats::isOneOf(voxel4d::vdbFormats(), file);
  if (!kind.empty() || isOwn) return kind;
  std::error_code ignored;
  return fs::is_regular_file(file, ignored) && isDicom(file) ? "DICOM" : kind;
}

/// What all files of a folder are, or some of them, if it holds DICOM.
std::string kindOfFolder(const fs::path& folder) {
  std::error_code ignored;
  for (const char* const metadata : {"zarr.json", ".zgroup", ".zarray", ".zattrs"}) {
    if (fs::is_regular_file(folder / metadata, ignored)) return "Zarr";
  }
  std::set<std::string> kinds;
  for (const auto& entry : fs::directory_iterator(folder, ignored)) {
    if (entry.path().extension() == ".vdb") return {};
    if (!entry.is_directory(ignored)) kinds.insert(kindOfFile(entry.path()));
  }
  if (kinds.contains("DICOM")) return "DICOM";
  return kinds.size() == 1 ? *kinds.begin() : std::string();
}

bool isInZarr(const fs::path& path) {
  return std::ranges::any_of(
      path, [](const fs::path& part) { return formats::lowerCaseExtension(part) == ".zarr"; });
}

}  // namespace

std::string pythonInput(const std::string& path) {
  if (isInZarr(path) || path.ends_with(".zarr.zip")) return "Zarr";
  if (!formats::schemeOf(path).empty()) return byExtension(path);
  std::error_code ignored;
  return fs::is_directory(path, ignored) ? kindOfFolder(path) : kindOfFile(path);
}

std::optional<PythonInput> firstPythonInput(std::span<const std::string> words) {
  if (std::ranges::find(words, "-") != words.end()) return std::nullopt;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const bool isOutput = i > 0 && (words[i - 1] == "-o" || words[i - 1] == "--output");
    if (isOutput || words[i].starts_with('-')) continue;
    if (std::string kind = pythonInput(words[i]); !kind.empty()) return PythonInput{words[i], kind};
  }
  return std::nullopt;
}

}  // namespace t4d::tools
