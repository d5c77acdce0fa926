#include <cstring>

#include "formats/mesh4d/mesh4d_formats.h"
#include "formats/mesh4d/tetgen_reader.h"
#include "t4d/check.h"
#include "t4d/edit.h"
#include "t4d/file.h"
#include "tools/fuzz/fuzz.h"

/// A 4D mesh in a format of other programs: the first byte selects the format, by its place in the
/// table; the file follows, of TetGen both files with a 0 between them. What is read is mended and
/// cut into slabs.
namespace t4d::fuzz {
namespace {

using formats::LoadedMesh4d;
using formats::Mesh4d;

/// Whether a format is compressed: it may unpack to something large.
bool unpacks(std::string_view id) { return id == "vtu" || id == "g4b" || id == "g4tf"; }

Result<LoadedMesh4d> read(const formats::Mesh4dFormat& format, std::string_view bytes) {
  if (format.id != "tetgen") return format.read({"mesh", std::string(bytes)});
  const auto middle = bytes.find('\0');
  const auto second = middle == bytes.npos ? std::string_view() : bytes.substr(middle + 1);
  return formats::readTetGen({"mesh", std::string(bytes.substr(0, middle))},
                             {"mesh", std::string(second)});
}

void checkSlabs(Mesh4d mesh, const edit::SlabCuts& cuts, bool closed) {
  const std::size_t cells = mesh.cells.size();
  const auto cut = edit::cutIntoSlabs(std::move(mesh), cuts);
  must(cut.has_value() || cuts.slabs, "a mesh that was read can be cut where nothing is split");
  if (!cut) return;
  must(cuts.slabs || cut->splitTetrahedra == 0, "no tetrahedron is split unless asked for");
  const auto report = measure::checkMesh(cut->mesh);
  must(report.has_value(), "slabs can be checked");
  must(cut->splitTetrahedra > 0 || report->tetrahedra == cells, "no tetrahedron is lost");
  must(!closed || (report->closed && report->oriented), "slabs of a closed mesh are closed");
}

int test(std::span<const std::uint8_t> input) {
  const auto formats = formats::mesh4dFormats();
  if (input.size() < 2 || input[0] >= formats.size()) return -1;
  const formats::Mesh4dFormat& format = formats[input[0]];
  const std::string_view bytes(reinterpret_cast<const char*>(input.data()) + 1, input.size() - 1);
  const HeapMeter heap;
  auto loaded = read(format, bytes);
  must(unpacks(format.id) || heap.peak() <= 512 * input.size() + 65536,
       "reading takes " + std::to_string(heap.peak()) + " bytes");
  if (!loaded) {
    must(!loaded.error().message.empty() && loaded.error().where.file.starts_with("mesh"),
         "a refusal says what and where");
    return 0;
  }
  must(!loaded->bodies.empty(), "a mesh has bodies");
  for (Mesh4d& body : loaded->bodies) {
    must(!body.cells.empty(), "a body has cells");
    for (const model::Point4& vertex : body.vertices)
      must(vertex.allFinite(), "vertices are finite");
    must(
        model::checkCells(body.cells, static_cast<std::uint32_t>(body.vertices.size())).has_value(),
        "cells have four different corners");
    const auto mended = edit::mendMesh4d(body, {.allowOpen = true});
    if (!mended) continue;  // merging vertices may leave nothing
    const bool closed = mended->closed && mended->oriented;
    checkSlabs(body, {}, closed);
    checkSlabs(body, {.slabs = 3}, closed);
  }
  return 0;
}

}  // namespace
}  // namespace t4d::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return t4d::fuzz::test({data, size});
}
