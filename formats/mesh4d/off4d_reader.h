#pragma once

#include <optional>
#include <string_view>

#include "formats/input_file.h"
#include "t4d/file.h"

/// OFF files of 4D meshes. Three programs have made three formats of it, with headers that do not
/// tell them apart:
/// * Stella and Miratope, `4OFF` and four counts `V F E C`: faces list vertices, cells list faces.
///   Cells are polyhedra, and become tetrahedra (polyhedra.h). Four triangles are one tetrahedron,
///   whose corner i is opposite its face i: so our own files keep their orientation. Other cells
///   have none.
/// * IJK, `4OFF` and three counts `V T 0`: each line `4 a b c d` is a tetrahedron.
/// * Geomview: polygons only. In `4OFF` with three counts the fourth number divides the others; in
///   `nOFF`, with a line for the dimension, it does not.
namespace t4d::formats {

/// Whether text is a 4D OFF file: by the header, and the number of counts after it.
bool isStellaOff(std::string_view begin);
bool isIjkOff(std::string_view begin);
bool isGeomviewOff(std::string_view begin);

/// The number of dimensions in a header such as `5OFF`, the form of Stella and Miratope for
/// polytopes in more or fewer of them; nothing for other text and for `4OFF`.
std::optional<unsigned> otherOffRank(std::string_view begin);

Result<LoadedMesh4d> readStellaOff(const InputFile& file);
Result<LoadedMesh4d> readIjkOff(const InputFile& file);

/// Refuses the file: it has no tetrahedra.
Result<LoadedMesh4d> readGeomviewOff(const InputFile& file);

}  // namespace t4d::formats
