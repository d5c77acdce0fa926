// Anybody's 4D tetrahedra to a .t4d file: here the five of a pentachoron, in any orientation.
#include <cstdio>
#include <vector>

#include <t4d/edit.h>
#include <t4d/file.h>

int main() {
  using namespace t4d;
  const std::vector<model::Point4> points = {
      {0, 0, 0, 0}, {1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}};
  const std::vector<model::Cell> cells = {
      {0, 1, 2, 3}, {0, 1, 2, 4}, {0, 1, 3, 4}, {0, 2, 3, 4}, {1, 2, 3, 4}};
  const auto mesh = fromTetrahedra(points, cells);
  if (!mesh) return 4;
  auto writer = formats::T4dWriter::create("pentachoron.t4d", {.bodies = {{.name = "mine"}}});
  if (!writer || !model::pump(*mesh, writer->body(0))) return 1;
  const auto bytes = writer->finish();
  std::printf("%s\n", bytes ? "pentachoron.t4d" : bytes.error().text().c_str());
}
