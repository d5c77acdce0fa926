#include "formats/triangle/triangle_mesh_formats.h"

#include <set>

#include "formats/test_files.h"

namespace t4d::formats {
namespace {

TEST(TriangleMeshFormats, AreFoundByExtensionWhateverItsCase) {
  std::set<std::string_view> seen;
  for (const TriangleMeshFormat& format : triangleMeshFormats()) {
    EXPECT_TRUE(seen.insert(format.extension).second) << format.extension;
    EXPECT_EQ(triangleMeshFormat("folder.x/a" + std::string(format.extension)), &format);
    EXPECT_TRUE(format.read != nullptr || format.write != nullptr) << format.extension;
    EXPECT_FALSE(format.name.empty());
  }
  EXPECT_EQ(triangleMeshFormat("A.PLY"), triangleMeshFormat("a.ply"));
  EXPECT_EQ(triangleMeshFormat("a.t4d"), nullptr);
  EXPECT_EQ(triangleMeshFormat("ply"), nullptr);
}

TEST(TriangleMeshFormats, AreListedByWhatCanBeDoneWithThem) {
  EXPECT_EQ(readableTriangleMeshExtensions(), ".stl, .obj, .ply, .off, .vtp, .vtu, .gltf or .glb");
  EXPECT_EQ(writableTriangleMeshExtensions(),
            ".stl, .obj, .ply, .off, .vtp, .gltf, .glb, .usda or .usdz");
}

TEST(TriangleMeshFormats, ReadBackTheSolidThatTheyWrite) {
  NamedMesh cube{"cube", {}};
  for (int i = 0; i < 8; ++i) cube.mesh.vertices.push_back(cubeCorner(i));
  for (const auto& s : kCubeSquares) {
    for (const auto& [b, c] : {std::pair{1, 2}, std::pair{2, 3}}) {
      cube.mesh.triangles.push_back(
          {std::uint32_t(s[0]), std::uint32_t(s[b]), std::uint32_t(s[c])});
    }
  }
  for (const TriangleMeshFormat& format : triangleMeshFormats()) {
    if (format.read == nullptr || format.write == nullptr) continue;
    const auto path = temporaryPath("cube" + std::string(format.extension));
    const auto lost = writeTriangleMeshes(path, {&cube, 1}, {.placement = {0.5, true}});
    ASSERT_TRUE(lost) << lost.error().text();
    EXPECT_TRUE(lost->empty());
    const auto loaded = readTriangleMesh(path);
    ASSERT_TRUE(loaded) << loaded.error().text();
    EXPECT_TRUE(model::isClosed(loaded->mesh));
    EXPECT_DOUBLE_EQ(model::signedVolume(loaded->mesh), format.placed ? 0.125 : 1);
    EXPECT_TRUE(loaded->notices.empty());
    EXPECT_TRUE(loaded->losses.empty()) << loaded->losses.front();
  }
}

}  // namespace
}  // namespace t4d::formats
