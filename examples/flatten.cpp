// Reads all slabs of a file into two matrices: vertices (n x 4) and cells (m x 4).
#include <cstdio>

#include <t4d/file.h>
#include <t4d/mesh.h>

int main() {
  using namespace t4d;
  const auto reader = formats::T4dReader::open("paper-cube.t4d");
  if (!reader) return 4;
  const auto mesh = model::flatten(reader->body(0));
  if (!mesh) {
    std::fprintf(stderr, "%s\n", mesh.error().text().c_str());
    return 1;
  }
  // The hypervolume is the sum of det[a, b, c, d] / 24 over all cells.
  double sum = 0;
  for (const auto& cell : mesh->cells.rowwise()) {
    Eigen::Matrix4d corners;
    for (int i = 0; i < 4; ++i) corners.col(i) = mesh->vertices.row(cell[i]);
    sum += corners.determinant();
  }
  std::printf("%td vertices, %td cells, hypervolume %.9g\n", mesh->vertices.rows(),
              mesh->cells.rows(), sum / 24);
}
