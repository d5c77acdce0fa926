// Writes the numbers of the table of 4D marching cubes as C++ to the file that it is given.
#include <cstdio>
#include <fstream>

#include "voxel4d/pattern_patches.h"

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fputs("Usage: make_pattern_table FILE.inc\n", stderr);
    return 2;
  }
  const t4d::voxel4d::PatternPatches patches = t4d::voxel4d::computePatternPatches();
  std::ofstream file(argv[1]);
  file << "constexpr std::uint32_t kFirst[] = {";
  for (const std::uint32_t first : patches.first) file << first << ",\n";
  file << "};\nconstexpr PatternTable::Tetrahedron kTetrahedra[] = {";
  for (const auto& [a, b, c, d] : patches.tetrahedra) {
    file << '{' << +a << ',' << +b << ',' << +c << ',' << +d << "},\n";
  }
  file << "};\n";
  return file.flush() ? 0 : 1;
}
