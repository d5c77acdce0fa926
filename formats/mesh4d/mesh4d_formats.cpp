#include "formats/mesh4d/mesh4d_formats.h"

#include <algorithm>
#include <fstream>
#include <new>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "formats/file_extension.h"
#include "formats/listed.h"
#include "formats/mesh4d/fourdo_reader.h"
#include "formats/mesh4d/fourdo_writer.h"
#include "formats/mesh4d/g4mf_reader.h"
#include "formats/mesh4d/g4mf_writer.h"
#include "formats/mesh4d/gmsh_binary_reader.h"
#include "formats/mesh4d/gmsh_binary_writer.h"
#include "formats/mesh4d/gmsh_reader.h"
#include "formats/mesh4d/gmsh_writer.h"
#include "formats/mesh4d/medit_binary_reader.h"
#include "formats/mesh4d/medit_binary_writer.h"
#include "formats/mesh4d/medit_reader.h"
#include "formats/mesh4d/medit_writer.h"
#include "formats/mesh4d/mfem_reader.h"
#include "formats/mesh4d/mfem_writer.h"
#include "formats/mesh4d/off4d_reader.h"
#include "formats/mesh4d/off4d_writer.h"
#include "formats/mesh4d/tetgen_reader.h"
#include "formats/mesh4d/tetgen_writer.h"
#include "formats/mesh4d/vtu_reader.h"
#include "formats/mesh4d/vtu_writer.h"
#include "platform/regular_file.h"
#include "t4d/file.h"

namespace t4d::formats {
namespace {

/// Enough of a file to tell its format.
constexpr std::size_t kBegin = 4096;

/// Its first line is a number: only the extension tells.
bool byExtension(std::string_view /*begin*/) { return false; }

const std::vector<Mesh4dFormat>& table() {
  static const std::vector<Mesh4dFormat> formats = {
      {"off-stella",
       "OFF of Stella and Miratope",
       {".off"},
       "`4OFF` and four counts",
       isStellaOff,
       {.bodies = false, .names = false},
       readStellaOff,
       writeStellaOff},
      {"off-ijk",
       "OFF of IJK",
       {".off"},
       "`4OFF` and three counts",
       isIjkOff,
       {.bodies = false, .names = false},
       readIjkOff,
       writeIjkOff},
      {"off-geomview",
       "OFF of Geomview",
       {".off"},
       "`nOFF`",
       isGeomviewOff,
       {.tetrahedra = false, .bodies = false, .names = false},
       readGeomviewOff,
       writeGeomviewOff},
      {"vtu",
       "VTK unstructured grid, the time as point data",
       {".vtu"},
       "XML with `VTKFile` of an `UnstructuredGrid`",
       isVtu,
       {.attributes = keptInVtu},
       readVtu,
       writeVtu},
      {"4do",
       "4DO",
       {".4do"},
       "`4DO` and a version",
       is4do,
       {.bodies = false, .names = false},
       read4do,
       write4do},
      {"g4tf",
       "G4MF text, draft",
       {".g4tf"},
       "JSON with `dimension`",
       isG4mfText,
       {},
       readG4mf,
       writeG4mfText},
      {"g4b",
       "G4MF binary, draft",
       {".g4b"},
       "`G4MF`",
       isG4mfBinary,
       {},
       readG4mf,
       writeG4mfBinary},
      {"medit",
       "Medit mesh, dimension 4",
       {".mesh"},
       "`MeshVersionFormatted`",
       isMedit,
       {.names = false},
       readMedit,
       writeMedit},
      {"meditb",
       "Medit mesh, binary, dimension 4",
       {".meshb"},
       "a 1 and a version, 1 to 4",
       isMeditBinary,
       {.names = false},
       readMeditBinary,
       writeMeditBinary},
      {"mfem",
       "MFEM mesh v1.0, dimension 4",
       {".mesh"},
       "`MFEM mesh v1.0`",
       isMfem,
       {.names = false},
       readMfem,
       writeMfem},
      {"gmsh",
       "Gmsh MSH 4.1, the time as node data",
       {".msh"},
       "`$MeshFormat`",
       isGmsh,
       {},
       readGmsh,
       writeGmsh},
      {"gmshb",
       "Gmsh MSH 4.1, binary, the time as node data",
       {".msh"},
       "`$MeshFormat` and `4.1 1`",
       isGmshBinary,
       {},
       readGmshBinary,
       writeGmshBinary},
      {"tetgen",
       "TetGen, the time as an attribute",
       {".node", ".ele"},
       "the extension",
       byExtension,
       {.names = false},
       readTetGen,
       writeTetGen},
  };
  return formats;
}

bool hasExtension(const Mesh4dFormat& format, const std::string& extension) {
  return std::ranges::find(format.extensions, extension) != format.extensions.end();
}

/// The format that the content tells, or else the only one that is told by its extension alone.
const Mesh4dFormat* formatOf(const InputFile& file) {
  const std::string_view begin = std::string_view(file.bytes).substr(0, kBegin);
  for (const Mesh4dFormat& format : table()) {
    if (format.recognises(begin)) return &format;
  }
  const std::string extension = lowerCaseExtension(file.path);
  for (const Mesh4dFormat& format : table()) {
    if (format.recognises == byExtension && hasExtension(format, extension)) return &format;
  }
  return nullptr;
}

Error unknownFormat(const InputFile& file) {
  if (const auto rank = otherOffRank(std::string_view(file.bytes).substr(0, kBegin))) {
    return fail(ErrorCode::Unsupported,
                fmt::format("is {0}OFF, a polytope in {0} dimensions; a 4D mesh is 4OFF", *rank),
                file.path.string());
  }
  const std::string extension = lowerCaseExtension(file.path);
  std::vector<std::string> expected;
  for (const Mesh4dFormat& format : table()) {
    if (hasExtension(format, extension)) {
      expected.push_back(fmt::format("{} ({})", format.recognisedBy, format.name));
    }
  }
  if (!expected.empty()) {
    return fail(ErrorCode::InvalidInput,
                fmt::format("is not a 4D mesh: a {} file would begin with {}", extension,
                            fmt::join(expected, ", or ")),
                file.path.string(), Remedy::OtherFormat);
  }
  return fail(
      ErrorCode::Unsupported,
      fmt::format("is not a 4D mesh in a known format: .t4d, {}", writableMesh4dExtensions()),
      file.path.string(), Remedy::OtherFormat);
}

}  // namespace

std::span<const Mesh4dFormat> mesh4dFormats() { return table(); }

const Mesh4dFormat* mesh4dFormat(std::string_view id) {
  const auto found = std::ranges::find(table(), id, &Mesh4dFormat::id);
  return found == table().end() ? nullptr : &*found;
}

const Mesh4dFormat* writtenMesh4dFormat(const std::filesystem::path& path) {
  const std::string extension = lowerCaseExtension(path);
  const auto found = std::ranges::find_if(table(), [&](const Mesh4dFormat& format) {
    return format.write != nullptr && hasExtension(format, extension);
  });
  return found == table().end() ? nullptr : &*found;
}

const Mesh4dFormat* mesh4dFormatOfFile(const std::filesystem::path& path) {
  if (!platform::sizeOfRegularFile(path)) return nullptr;
  std::ifstream in(path, std::ios::binary);
  InputFile file{path, std::string(kBegin, '\0')};
  in.read(file.bytes.data(), kBegin);
  file.bytes.resize(static_cast<std::size_t>(in.gcount()));
  return file.bytes.empty() ? nullptr : formatOf(file);
}

std::string writableMesh4dExtensions() {
  std::vector<std::string_view> extensions;
  for (const Mesh4dFormat& format : table()) {
    if (format.write == nullptr) continue;
    for (const std::string_view extension : format.extensions) {
      if (std::ranges::find(extensions, extension) == extensions.end()) {
        extensions.push_back(extension);
      }
    }
  }
  return listed(extensions);
}

Result<LoadedMesh4d> readMesh4d(const std::filesystem::path& path, const Mesh4dFormat* format,
                                const Mesh4dFormat*& found) {
  const auto file = readInputFile(path);
  if (!file) return file.error();
  found = format != nullptr ? format : formatOf(*file);
  if (found == nullptr) return unknownFormat(*file);
  try {
    return found->read(*file);
  } catch (const std::bad_alloc&) {
    return fail(ErrorCode::Failed, "the mesh does not fit in memory", path.string());
  }
}

std::vector<std::string> mesh4dLosses(const Mesh4dFormat& format, const FlatBodies& mesh) {
  std::vector<std::string> losses;
  const std::size_t bodies = mesh.bodies().size();
  if (!format.keeps.tetrahedra) {
    losses.push_back(
        fmt::format("tetrahedra not kept by {}: only their triangles are written", format.id));
  }
  if (!format.keeps.bodies && bodies > 1) {
    losses.push_back(fmt::format("bodies not kept by {}: {} become one", format.id, bodies));
  } else if (!format.keeps.names && bodies > 1) {
    losses.push_back(fmt::format("names of bodies not kept by {}: they become numbers", format.id));
  }
  return losses;
}

namespace {

Error noFormat(std::string_view id, const std::filesystem::path& path) {
  return fail(ErrorCode::Options,
              fmt::format("there is no format '{}' that does this; docs/formats.md lists them", id),
              path);
}

/// The counts of a body: one pass over its slabs.
Result<CountedBody> counted(const model::Body& body) {
  CountedBody all{body, 0, 0};
  for (std::size_t i = 0; i < body.source->slabCount(); ++i) {
    const auto slab = body.source->slab(i);
    if (!slab) return slab.error();
    const model::Connectivity& connectivity = *(*slab)->connectivity;
    all.vertices += connectivity.vertexCount - (i > 0 ? connectivity.lowerCount : 0);
    all.tetrahedra += connectivity.cells.size();
  }
  return all;
}

}  // namespace

Result<LoadedMesh4d> readMesh4d(const std::filesystem::path& path, std::string_view format) {
  const Mesh4dFormat* const given = format.empty() ? nullptr : mesh4dFormat(format);
  if (!format.empty() && (given == nullptr || given->read == nullptr)) {
    return noFormat(format, path);
  }
  const Mesh4dFormat* found = nullptr;
  return readMesh4d(path, given, found);
}

Result<std::vector<std::string>> writeMesh4d(const std::filesystem::path& path,
                                             std::span<const model::Body> bodies,
                                             std::string_view format) {
  const Mesh4dFormat* const given =
      format.empty() ? writtenMesh4dFormat(path) : mesh4dFormat(format);
  if (given == nullptr || given->write == nullptr) {
    return noFormat(format.empty() ? path.extension().string() : format, path);
  }
  std::vector<CountedBody> all;
  for (const model::Body& body : bodies) {
    auto one = counted(body);
    if (!one) return one.error();
    all.push_back(*one);
  }
  auto mesh = FlatBodies::of(all);
  if (!mesh) return mesh.error();
  if (given->keeps.attributes != nullptr) {
    if (auto found = mesh->findAttributes(given->keeps.attributes); !found) return found.error();
  }
  if (auto written = given->write(path, *mesh); !written) return written.error();
  return mesh4dLosses(*given, *mesh);
}

}  // namespace t4d::formats
