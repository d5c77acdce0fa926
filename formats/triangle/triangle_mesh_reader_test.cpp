#include <random>

#include "formats/test_files.h"
#include "formats/triangle/triangle_mesh_formats.h"
#include "t4d/surface.h"
#include "tests/paths.h"

namespace t4d::formats {
namespace {

TEST(TriangleMeshReader, RefusesWhatIsNoFileOfAMesh) {
  EXPECT_EQ(errorOf("a.stl", ""), "a.stl: is empty");
  EXPECT_EQ(errorOf("a.step", "x"), "a.step: .step is not the extension of a triangle mesh: " +
                                        readableTriangleMeshExtensions());
  EXPECT_EQ(errorOf("mesh", "x"), "mesh: (none) is not the extension of a triangle mesh: " +
                                      readableTriangleMeshExtensions());
  const auto missing = readTriangleMesh(temporaryPath("missing.obj"));
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().code, ErrorCode::Io);
  EXPECT_EQ(missing.error().message, "no such file");
  const auto folder = temporaryPath("folder.obj");
  std::filesystem::create_directories(folder);
  EXPECT_EQ(readTriangleMesh(folder).error().message, "is a folder; name a file in it");
  EXPECT_EQ(readTriangleMesh("/dev/zero").error().message, "is not a regular file");
}

TEST(TriangleMeshReader, TakesExtensionsInAnyCase) {
  EXPECT_EQ(readBytes("A.OBJ", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3").mesh.triangles.size(), 1u);
}

struct RealMesh {
  const char* file;
  std::size_t triangles;
  double volume;  // 0: not closed
};

TEST(TriangleMeshReader, ReadsRealMeshesWithTheirVolumes) {
  const std::filesystem::path folder = T4D_SHARED_MESHES;
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no folder " << folder;
  for (const auto& [file, triangles, volume] :
       {RealMesh{"spot_low_resolution.obj", 1654, 0.6797288910},
        RealMesh{"spot.obj", 23062, 0.6879862645},
        RealMesh{"fish_low_resolution.obj", 1886, 1.1146213648},
        RealMesh{"fish.obj", 21568, 1.3528900243}, RealMesh{"wingnut.obj", 6090, 22.0966389286},
        RealMesh{"goathead.obj", 5522, 421.7366604893}, RealMesh{"cube_no_bottom.obj", 40, 0}}) {
    const auto loaded = readTriangleMesh(folder / file);
    ASSERT_TRUE(loaded) << loaded.error().text();
    EXPECT_EQ(loaded->mesh.triangles.size(), triangles) << file;
    EXPECT_EQ(model::isClosed(loaded->mesh), volume > 0) << file;
    EXPECT_TRUE(loaded->notices.empty()) << file;
    if (volume == 0) continue;
    EXPECT_NEAR(model::signedVolume(loaded->mesh), volume, 1e-10 * volume) << file;
  }
}

}  // namespace
}  // namespace t4d::formats
