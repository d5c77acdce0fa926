#include "formats/mesh4d/mfem_writer.h"

#include "formats/mesh4d/text_output.h"

namespace t4d::formats {

Result<void> writeMfem(const std::filesystem::path& path, const FlatBodies& mesh) {
  auto text = TextOutput::create(path);
  if (!text) return text.error();
  text->add(
      "MFEM mesh v1.0\n\n# written by t4d: the fourth coordinate is time\n\n"
      "dimension\n4\n\nelements\n0\n\nboundary\n{}\n",
      mesh.cellCount());
  auto done = mesh.forCells([&](std::size_t body, std::span<const model::Cell> cells) {
    for (const auto& [a, b, c, d] : cells) text->add("{} 4 {} {} {} {}\n", body + 1, a, b, c, d);
    return text->flush();
  });
  if (!done) return done;
  text->add("\nvertices\n{}\n4\n", mesh.vertexCount());
  done = mesh.forVertices([&](std::span<const model::Point4> vertices) {
    for (const model::Point4& v : vertices) text->add("{} {} {} {}\n", v[0], v[1], v[2], v[3]);
    return text->flush();
  });
  if (!done) return done;
  return text->commit();
}

}  // namespace t4d::formats
