#include "formats/mesh4d/mesh4d_formats.h"

#include <set>

#include <fmt/format.h>

#include "formats/mesh4d/test_mesh4d.h"
#include "t4d/file.h"

namespace t4d::formats {
namespace {

std::vector<std::string> namesOf(const std::vector<Mesh4d>& bodies) {
  std::vector<std::string> names;
  for (const Mesh4d& body : bodies) names.push_back(body.name);
  return names;
}

TEST(Mesh4dFormats, HaveIdsAndAreFoundByThem) {
  std::set<std::string_view> seen;
  for (const Mesh4dFormat& format : mesh4dFormats()) {
    EXPECT_TRUE(seen.insert(format.id).second) << format.id;
    EXPECT_EQ(mesh4dFormat(format.id), &format);
    EXPECT_FALSE(format.extensions.empty());
    EXPECT_FALSE(format.recognisedBy.empty());
  }
  EXPECT_EQ(mesh4dFormat("t4d"), nullptr);
  EXPECT_EQ(writtenMesh4dFormat("folder.x/A.OFF")->id, "off-stella");
  EXPECT_EQ(writtenMesh4dFormat("a.stl"), nullptr);
}

// Each pair of formats, one after the other, in the order of the table.
TEST(Mesh4dFormats, EveryPairGivesTheMeshBackButForWhatTheTableSaysIsLost) {
  const std::vector<Mesh4d> bodies = awkwardBodies();
  const WrittenBodies source(bodies);
  const auto flat = FlatBodies::of(source.bodies);
  ASSERT_TRUE(flat);
  int pairs = 0;
  for (const Mesh4dFormat& first : mesh4dFormats()) {
    if (!first.keeps.tetrahedra) continue;
    const auto there = read4d(written4d(first, bodies));
    ASSERT_TRUE(there) << first.id << ": " << there.error().text();
    for (const Mesh4dFormat& second : mesh4dFormats()) {
      if (!second.keeps.tetrahedra) continue;
      SCOPED_TRACE(std::string(first.id) + " to " + std::string(second.id));
      const auto back = read4d(written4d(second, there->bodies));
      ASSERT_TRUE(back) << back.error().text();
      ++pairs;
      EXPECT_EQ(back->losses, std::vector<std::string>{});
      EXPECT_EQ(back->notices, std::vector<std::string>{});
      ASSERT_TRUE(first.keeps.doubles && second.keeps.doubles);
      EXPECT_EQ(cellsOf(back->bodies), cellsOf(bodies));
      if (!first.keeps.bodies || !second.keeps.bodies) {
        EXPECT_EQ(back->bodies.size(), 1U);
        continue;
      }
      ASSERT_EQ(back->bodies.size(), 2U);
      for (int i = 0; i < 2; ++i) EXPECT_EQ(cellsOf(back->bodies[i]), cellsOf(bodies[i]));
      if (first.keeps.names && second.keeps.names) {
        EXPECT_EQ(namesOf(back->bodies), namesOf(bodies));
      }
    }
    const std::size_t expected = first.keeps.bodies && first.keeps.names ? 0 : 1;
    EXPECT_EQ(mesh4dLosses(first, *flat).size(), expected) << first.id;
  }
  EXPECT_GE(pairs, 25);
}

TEST(Mesh4dFormats, RegularPolytopesOfTetrahedraKeepTheirHypervolume) {
  for (const fixtures::Polytope& polytope : {fixtures::cell16(), fixtures::cell600()}) {
    const std::vector<Mesh4d> bodies = {{"", polytope.vertices, fixtures::tetrahedra(polytope)}};
    for (const Mesh4dFormat& format : mesh4dFormats()) {
      if (!format.keeps.tetrahedra) continue;
      const auto loaded = read4d(written4d(format, bodies));
      ASSERT_TRUE(loaded) << format.id << ": " << loaded.error().text();
      EXPECT_EQ(loaded->bodies.size(), 1U);
      EXPECT_NEAR(hypervolumeOf(loaded->bodies), polytope.hypervolume, 1e-12) << format.id;
    }
  }
}

TEST(Mesh4dFormats, AreToldByContentWhateverTheExtension) {
  const std::vector<Mesh4d> bodies = {awkwardBody("a", 0)};
  for (const Mesh4dFormat& format : mesh4dFormats()) {
    if (!format.keeps.tetrahedra || format.id == "tetgen") continue;
    const auto path = temporaryPath("named.otherwise");
    std::filesystem::copy_file(written4d(format, bodies), path,
                               std::filesystem::copy_options::overwrite_existing);
    const Mesh4dFormat* found = nullptr;
    const auto loaded = readMesh4d(path, nullptr, found);
    ASSERT_TRUE(loaded) << loaded.error().text();
    EXPECT_EQ(found, &format);
  }
}

TEST(Mesh4dFormats, RefuseWhatTheyAreNot) {
  EXPECT_EQ(
      error4dOf("a.xyz", "hello"),
      "a.xyz: is not a 4D mesh in a known format: .t4d, .off, .vtu, .4do, .g4tf, .g4b, .mesh, "
      ".meshb, .msh, .node or .ele");
  EXPECT_EQ(error4dOf("a.4do", "hello"),
            "a.4do: is not a 4D mesh: a .4do file would begin with `4DO` and a version (4DO)");
}

TEST(Mesh4dFormats, PartsOfOneSurfaceAreOneBody) {
  // The references are those of two halves of one boundary.
  Mesh4d body = awkwardBody("", 0);
  std::string text = "MeshVersionFormatted 2\nDimension 4\nVertices 8\n";
  for (const model::Point4& v : body.vertices) {
    text += fmt::format("{} {} {} {} 0\n", v[0], v[1], v[2], v[3]);
  }
  text += "Tetrahedra 16\n";
  for (std::size_t i = 0; i < 16; ++i) {
    const auto& [a, b, c, d] = body.cells[i];
    text += fmt::format("{} {} {} {} {}\n", a + 1, b + 1, c + 1, d + 1, i % 2);
  }
  const LoadedMesh4d loaded = read4dBytes("halves.mesh", text + "End\n");
  ASSERT_EQ(loaded.bodies.size(), 1U);
  EXPECT_EQ(cellsOf(loaded.bodies[0]), cellsOf(body));
  EXPECT_EQ(loaded.notices.size(), 1U);
}

}  // namespace
}  // namespace t4d::formats
