#pragma once

#include "formats/input_file.h"
#include "t4d/surface.h"

/// Reads VTK's XML files as text or binary, inline or appended, compressed with zlib, LZ4 or LZMA
/// or not, in either byte order, of one piece or several. Point data and cell data become
/// attributes of the same names and types; `Normals` are skipped. Cells that `vtkGhostType` marks
/// as duplicates or as hidden are left out. Points, lines and other data are losses.
namespace t4d::formats {

/// Reads polygonal data (.vtp): polygons and triangle strips.
Result<LoadedMesh> readVtp(const InputFile& file, Keep keep = Keep::Shape);

/// Reads an unstructured grid (.vtu): its triangles, quads, pixels, polygons and strips; or, of one
/// with tetrahedra, voxels, hexahedra, wedges or pyramids, the faces that only one of these has,
/// outward whichever way round the cell is. Points with equal coordinates are one. Fails for curved
/// cells and polyhedra.
Result<LoadedMesh> readVtuSurface(const InputFile& file, Keep keep = Keep::Shape);

}  // namespace t4d::formats
