#include "formats/mesh4d/fourdo_writer.h"

#include "formats/mesh4d/text_output.h"

namespace t4d::formats {

Result<void> write4do(const std::filesystem::path& path, const FlatBodies& mesh) {
  auto text = TextOutput::create(path);
  if (!text) return text.error();
  text->add("4DO 1\n# written by t4d: w is time\norient X Y Z W\n");
  auto done = mesh.forVertices([&](std::span<const model::Point4> vertices) {
    for (const model::Point4& v : vertices) text->add("v {} {} {} {}\n", v[0], v[1], v[2], v[3]);
    return text->flush();
  });
  if (!done) return done;
  done = mesh.forCells([&](std::size_t, std::span<const model::Cell> cells) {
    for (const auto& [a, b, c, d] : cells) text->add("t {} {} {} {}\n", a, b, c, d);
    return text->flush();
  });
  if (!done) return done;
  return text->commit();
}

}  // namespace t4d::formats
