#include "formats/mesh4d/gmsh_binary_writer.h"

#include <limits>

#include <fmt/format.h>

#include "formats/mesh4d/binary_output.h"
#include "formats/mesh4d/gmsh_entities.h"

namespace t4d::formats {
namespace {

Result<void> writeGmshNodes(BinaryOutput& file, const FlatBodies& mesh) {
  const auto bodies = mesh.bodies();
  file.addText("$Nodes\n");
  for (const std::uint64_t number :
       {std::uint64_t{bodies.size()}, mesh.vertexCount(), std::uint64_t{1}, mesh.vertexCount()}) {
    file.add(number);
  }
  // A block has all its tags before its coordinates.
  std::int32_t body = 0;
  std::uint64_t end = 0;
  std::uint64_t number = 0;
  auto done = mesh.forVertices([&](std::span<const model::Point4> vertices) -> Result<void> {
    for (const model::Point4& v : vertices) {
      while (number == end) {
        const std::uint64_t count = bodies[static_cast<std::size_t>(body)].vertices;
        file.add(std::int32_t{3});
        file.add(++body);
        file.add(std::int32_t{0});
        file.add(count);
        end += count;
        for (std::uint64_t tag = number + 1; tag <= end; ++tag) {
          file.add(tag);
          if (tag % FlatBodies::kMostAtOnce != 0) continue;
          if (auto flushed = file.flush(); !flushed) return flushed;
        }
      }
      ++number;
      for (int axis = 0; axis < 3; ++axis) file.add(v[axis]);
    }
    return file.flush();
  });
  file.addText("\n$EndNodes\n");
  return done;
}

Result<void> writeGmshElements(BinaryOutput& file, const FlatBodies& mesh) {
  const auto bodies = mesh.bodies();
  file.addText("$Elements\n");
  for (const std::uint64_t number :
       {std::uint64_t{bodies.size()}, mesh.cellCount(), std::uint64_t{1}, mesh.cellCount()}) {
    file.add(number);
  }
  std::size_t begun = 0;
  std::uint64_t number = 0;
  auto done = mesh.forCells([&](std::size_t ofBody, std::span<const model::Cell> cells) {
    for (; begun <= ofBody; ++begun) {
      file.add(std::int32_t{3});
      file.add(static_cast<std::int32_t>(begun + 1));
      file.add(std::int32_t{4});
      file.add(bodies[begun].tetrahedra);
    }
    for (const model::Cell& cell : cells) {
      file.add(++number);
      for (const std::uint32_t corner : cell) file.add(std::uint64_t{corner} + 1);
    }
    return file.flush();
  });
  file.addText("\n$EndElements\n");
  return done;
}

}  // namespace

Result<void> writeGmshBinary(const std::filesystem::path& path, const FlatBodies& mesh) {
  if (mesh.vertexCount() > std::numeric_limits<std::int32_t>::max()) {
    return invalid("binary Gmsh files have fewer than 2^31 vertices with data", path.string());
  }
  const auto bounds = gmshBounds(mesh);
  if (!bounds) return bounds.error();
  auto file = BinaryOutput::create(path);
  if (!file) return file.error();
  const auto bodies = mesh.bodies();
  file->addText("$MeshFormat\n4.1 1 8\n");
  file->add(std::int32_t{1});
  file->addText(fmt::format("\n$EndMeshFormat\n$PhysicalNames\n{}\n", bodies.size()));
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    file->addText(fmt::format("3 {} \"{}\"\n", i + 1, gmshName(bodies[i].name)));
  }
  file->addText("$EndPhysicalNames\n$Entities\n");
  for (int dimension = 0; dimension < 3; ++dimension) file->add(std::uint64_t{0});
  file->add(std::uint64_t{bodies.size()});
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    file->add(static_cast<std::int32_t>(i + 1));
    for (const model::Point3& corner : {(*bounds)[i].min, (*bounds)[i].max}) {
      for (const double coordinate : corner) file->add(coordinate);
    }
    file->add(std::uint64_t{1});
    file->add(static_cast<std::int32_t>(i + 1));
    file->add(std::uint64_t{0});
  }
  file->addText("\n$EndEntities\n");
  if (auto done = writeGmshNodes(*file, mesh); !done) return done;
  if (auto done = writeGmshElements(*file, mesh); !done) return done;
  file->addText(fmt::format("$NodeData\n1\n\"time\"\n1\n0\n3\n0\n1\n{}\n", mesh.vertexCount()));
  std::int32_t tag = 0;
  auto done = mesh.forVertices([&](std::span<const model::Point4> vertices) {
    for (const model::Point4& v : vertices) {
      file->add(++tag);
      file->add(v[3]);
    }
    return file->flush();
  });
  if (!done) return done;
  file->addText("\n$EndNodeData\n");
  return file->commit();
}

}  // namespace t4d::formats
