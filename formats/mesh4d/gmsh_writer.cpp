#include "formats/mesh4d/gmsh_writer.h"

#include "formats/mesh4d/gmsh_entities.h"
#include "formats/mesh4d/text_output.h"

namespace t4d::formats {
Result<void> writeGmsh(const std::filesystem::path& path, const FlatBodies& mesh) {
  const auto bounds = gmshBounds(mesh);
  if (!bounds) return bounds.error();
  auto text = TextOutput::create(path);
  if (!text) return text.error();
  const auto bodies = mesh.bodies();
  text->add("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$PhysicalNames\n{}\n", bodies.size());
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    text->add("3 {} \"{}\"\n", i + 1, gmshName(bodies[i].name));
  }
  text->add("$EndPhysicalNames\n$Entities\n0 0 0 {}\n", bodies.size());
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const auto& [min, max] = (*bounds)[i];
    text->add("{} {} {} {} {} {} {} 1 {} 0\n", i + 1, min[0], min[1], min[2], max[0], max[1],
              max[2], i + 1);
  }
  text->add("$EndEntities\n$Nodes\n{} {} {} {}\n", bodies.size(), mesh.vertexCount(), 1,
            mesh.vertexCount());
  // A block has all its tags before its coordinates.
  std::size_t body = 0;
  std::uint64_t end = 0;
  std::uint64_t number = 0;
  auto done = mesh.forVertices([&](std::span<const model::Point4> vertices) -> Result<void> {
    for (const model::Point4& v : vertices) {
      for (; number == end; ++body) {
        text->add("3 {} 0 {}\n", body + 1, bodies[body].vertices);
        end += bodies[body].vertices;
        for (std::uint64_t tag = number + 1; tag <= end; ++tag) {
          text->add("{}\n", tag);
          if (tag % FlatBodies::kMostAtOnce != 0) continue;
          if (auto flushed = text->flush(); !flushed) return flushed;
        }
      }
      ++number;
      text->add("{} {} {}\n", v[0], v[1], v[2]);
    }
    return text->flush();
  });
  if (!done) return done;
  text->add("$EndNodes\n$Elements\n{} {} 1 {}\n", bodies.size(), mesh.cellCount(),
            mesh.cellCount());
  std::size_t begun = 0;
  number = 0;
  done = mesh.forCells([&](std::size_t ofBody, std::span<const model::Cell> cells) {
    for (; begun <= ofBody; ++begun) {
      text->add("3 {} 4 {}\n", begun + 1, bodies[begun].tetrahedra);
    }
    for (const auto& [a, b, c, d] : cells) {
      text->add("{} {} {} {} {}\n", ++number, std::uint64_t{a} + 1, std::uint64_t{b} + 1,
                std::uint64_t{c} + 1, std::uint64_t{d} + 1);
    }
    return text->flush();
  });
  if (!done) return done;
  text->add("$EndElements\n$NodeData\n1\n\"time\"\n1\n0\n3\n0\n1\n{}\n", mesh.vertexCount());
  number = 0;
  done = mesh.forVertices([&](std::span<const model::Point4> vertices) {
    for (const model::Point4& v : vertices) text->add("{} {}\n", ++number, v[3]);
    return text->flush();
  });
  if (!done) return done;
  text->add("$EndNodeData\n");
  return text->commit();
}

}  // namespace t4d::formats
