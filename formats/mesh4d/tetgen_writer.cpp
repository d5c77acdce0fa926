#include "formats/mesh4d/tetgen_writer.h"

#include "formats/mesh4d/text_output.h"
#include "platform/replaceable.h"

namespace t4d::formats {

Result<void> writeTetGen(const std::filesystem::path& path, const FlatBodies& mesh) {
  std::filesystem::path nodePath = path;
  std::filesystem::path elementPath = path;
  nodePath.replace_extension(".node");
  elementPath.replace_extension(".ele");
  // One of the two has the name that was given; the other is its companion.
  const std::string companion = (path == nodePath ? elementPath : nodePath).filename().string();
  if (auto good = platform::checkReplaceable(path.parent_path(), {&companion, 1}); !good)
    return good;
  auto nodes = TextOutput::create(nodePath);
  if (!nodes) return nodes.error();
  auto elements = TextOutput::create(elementPath);
  if (!elements) return elements.error();
  nodes->add("# written by t4d: the attribute is time\n{} 3 1 0\n", mesh.vertexCount());
  std::uint64_t number = 0;
  auto done = mesh.forVertices([&](std::span<const model::Point4> vertices) {
    for (const model::Point4& v : vertices) {
      nodes->add("{} {} {} {} {}\n", ++number, v[0], v[1], v[2], v[3]);
    }
    return nodes->flush();
  });
  if (!done) return done;
  elements->add("# written by t4d: the attribute is the body\n{} 4 1\n", mesh.cellCount());
  number = 0;
  done = mesh.forCells([&](std::size_t body, std::span<const model::Cell> cells) {
    for (const auto& [a, b, c, d] : cells) {
      elements->add("{} {} {} {} {} {}\n", ++number, std::uint64_t{a} + 1, std::uint64_t{b} + 1,
                    std::uint64_t{c} + 1, std::uint64_t{d} + 1, body + 1);
    }
    return elements->flush();
  });
  if (!done) return done;
  if (done = elements->commit(); !done) return done;
  return nodes->commit();
}

}  // namespace t4d::formats
