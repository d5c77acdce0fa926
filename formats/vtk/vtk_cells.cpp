#include "formats/vtk/vtk_cells.h"

#include <map>

namespace t4d::formats {

const VtkSolidShape* vtkSolidShape(std::uint32_t type) {
  static const std::map<std::uint32_t, VtkSolidShape> shapes = {
      {kVtkTetrahedron, {4, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}}},
      {11,
       {8, {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}}},
      {12,
       {8, {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}}}},
      {13, {6, {{0, 1, 2}, {3, 5, 4}, {0, 3, 4, 1}, {1, 4, 5, 2}, {2, 5, 3, 0}}}},
      {14, {5, {{0, 3, 2, 1}, {0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}}}},
  };
  const auto found = shapes.find(type);
  return found == shapes.end() ? nullptr : &found->second;
}

}  // namespace t4d::formats
