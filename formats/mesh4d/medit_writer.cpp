#include "formats/mesh4d/medit_writer.h"

#include "formats/mesh4d/text_output.h"

namespace t4d::formats {

Result<void> writeMedit(const std::filesystem::path& path, const FlatBodies& mesh) {
  auto text = TextOutput::create(path);
  if (!text) return text.error();
  text->add(
      "MeshVersionFormatted 2\n# written by t4d: the fourth coordinate is time\nDimension 4\n");
  text->add("Vertices\n{}\n", mesh.vertexCount());
  std::size_t body = 0;
  std::uint64_t end = mesh.bodies().empty() ? 0 : mesh.bodies()[0].vertices;
  std::uint64_t number = 0;
  auto done = mesh.forVertices([&](std::span<const model::Point4> vertices) {
    for (const model::Point4& v : vertices) {
      while (number == end) end += mesh.bodies()[++body].vertices;
      ++number;
      text->add("{} {} {} {} {}\n", v[0], v[1], v[2], v[3], body + 1);
    }
    return text->flush();
  });
  if (!done) return done;
  text->add("Tetrahedra\n{}\n", mesh.cellCount());
  done = mesh.forCells([&](std::size_t ofBody, std::span<const model::Cell> cells) {
    for (const auto& [a, b, c, d] : cells) {
      text->add("{} {} {} {} {}\n", std::uint64_t{a} + 1, std::uint64_t{b} + 1,
                std::uint64_t{c} + 1, std::uint64_t{d} + 1, ofBody + 1);
    }
    return text->flush();
  });
  if (!done) return done;
  text->add("End\n");
  return text->commit();
}

}  // namespace t4d::formats
