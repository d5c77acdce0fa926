#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace t4d::formats {

/// A VTK cell with flat faces, by the numbers of its corners. The corners of a face are
/// counter-clockwise seen from outside, if the cell is not inside out.
struct VtkSolidShape {
  std::size_t corners;
  std::vector<std::vector<std::uint32_t>> faces;
};

/// The shape of a tetrahedron, voxel, hexahedron, wedge or pyramid; null for other types.
const VtkSolidShape* vtkSolidShape(std::uint32_t type);

inline constexpr std::uint8_t kVtkTriangle = 5;
inline constexpr std::uint8_t kVtkStrip = 6;
inline constexpr std::uint8_t kVtkPolygon = 7;
inline constexpr std::uint8_t kVtkPixel = 8;
inline constexpr std::uint8_t kVtkQuad = 9;
inline constexpr std::uint8_t kVtkTetrahedron = 10;

}  // namespace t4d::formats
