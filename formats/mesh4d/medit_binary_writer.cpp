#include "formats/mesh4d/medit_binary_writer.h"

#include <limits>

#include "formats/mesh4d/binary_output.h"

namespace t4d::formats {
namespace {

/// Writes with counts, references and corners of type `Integer`.
template <class Integer>
Result<void> writeMeditElements(BinaryOutput& file, const FlatBodies& mesh) {
  constexpr std::uint64_t kKeywordBytes = 4 + 8;
  std::uint64_t at = 2 * 4;
  const auto keyword = [&](std::int32_t number, std::uint64_t bytes) {
    at += kKeywordBytes + bytes;
    file.add(number);
    file.add(at);
  };
  file.add(std::int32_t{1});
  file.add(std::int32_t{sizeof(Integer) == 8 ? 4 : 3});
  keyword(3, 4);
  file.add(std::int32_t{4});

  keyword(4, sizeof(Integer) + mesh.vertexCount() * (4 * 8 + sizeof(Integer)));
  file.add(static_cast<Integer>(mesh.vertexCount()));
  std::size_t body = 0;
  std::uint64_t end = mesh.bodies().empty() ? 0 : mesh.bodies()[0].vertices;
  std::uint64_t number = 0;
  auto done = mesh.forVertices([&](std::span<const model::Point4> vertices) {
    for (const model::Point4& v : vertices) {
      while (number == end) end += mesh.bodies()[++body].vertices;
      ++number;
      for (const double coordinate : v) file.add(coordinate);
      file.add(static_cast<Integer>(body + 1));
    }
    return file.flush();
  });
  if (!done) return done;

  keyword(8, sizeof(Integer) * (1 + 5 * mesh.cellCount()));
  file.add(static_cast<Integer>(mesh.cellCount()));
  done = mesh.forCells([&](std::size_t ofBody, std::span<const model::Cell> cells) {
    for (const model::Cell& cell : cells) {
      for (const std::uint32_t corner : cell) file.add(static_cast<Integer>(corner + Integer{1}));
      file.add(static_cast<Integer>(ofBody + 1));
    }
    return file.flush();
  });
  if (!done) return done;
  file.add(std::int32_t{54});
  file.add(std::int64_t{0});
  return {};
}

}  // namespace

Result<void> writeMeditBinary(const std::filesystem::path& path, const FlatBodies& mesh) {
  constexpr std::uint64_t kMost = std::numeric_limits<std::int32_t>::max();
  auto file = BinaryOutput::create(path);
  if (!file) return file.error();
  auto done = mesh.vertexCount() < kMost && mesh.cellCount() < kMost
                  ? writeMeditElements<std::int32_t>(*file, mesh)
                  : writeMeditElements<std::int64_t>(*file, mesh);
  if (!done) return done;
  return file->commit();
}

}  // namespace t4d::formats
