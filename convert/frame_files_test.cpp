#include "convert/frame_files.h"

#include <fstream>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "fixtures/solids.h"
#include "platform/test_folder.h"
#include "t4d/surface.h"
#include "t4d/sweep.h"

namespace t4d::convert {
namespace {

namespace fs = std::filesystem;

TEST(FrameNames, AreThoseOfAFolderOrAPattern) {
  const auto folder = frameNames("out/", ".ply");
  ASSERT_TRUE(folder);
  EXPECT_EQ(folder->folder / folder->fileName(42, 100), "out/frame_0042.ply");
  EXPECT_EQ(folder->fileName(42, 100'000), "frame_00042.ply");
  EXPECT_EQ(folder->manifest, "manifest.json");
  const auto pattern = frameNames("out/bolt_%03d.VTP", "");
  ASSERT_TRUE(pattern);
  EXPECT_EQ(pattern->folder / pattern->fileName(7, 8), "out/bolt_007.VTP");
  EXPECT_EQ(pattern->fileName(7, 1001), "bolt_0007.VTP");
  EXPECT_EQ(pattern->manifest, "bolt.manifest.json");
  EXPECT_EQ(pattern->collection, "bolt.pvd");
  EXPECT_EQ(frameNames("%d.obj", ".obj")->fileName(7, 100), "07.obj");
  EXPECT_EQ(frameNames("%d.obj", "")->manifest, "manifest.json");
  EXPECT_FALSE(frameNames("a%d.obj", ".ply"));
  EXPECT_FALSE(frameNames("a%d.txt", ""));
  EXPECT_FALSE(frameNames("a%d", ""));
  EXPECT_FALSE(frameNames("out", ".vdb"));
  for (const char* pattern : {"a%s.ply", "a%5d.ply", "a%.ply", "a.ply"}) {
    EXPECT_TRUE(
        frameNames(pattern, "")
            .error()
            .message.starts_with(fmt::format(
                "'{}' is neither a folder for files of a given format nor a pattern", pattern)));
  }
  EXPECT_FALSE(frameNames("a%s.ply", ".ply"));
  EXPECT_EQ(frameNames("100 %", ".ply")->folder, "100 %");
}

class FrameFiles : public testing::Test {
 protected:
  FrameFiles() {
    mesh4d::SweepOptions options;
    options.caps = mesh4d::CapMethod::Cone;
    model::Screw turn;
    turn.angleDegrees = 90;
    const model::ScrewRun run{1, turn, 1};
    EXPECT_TRUE(
        mesh4d::sweep(fixtures::cube(2), *model::chainScrews(0, {&run, 1}), options, mesh_));
  }

  Result<FrameFilesReport> write(const std::string& extension, slice::SliceDetail detail,
                                 const model::Progress& progress = {}) {
    const model::Body body{"cube", &mesh_};
    FrameFilesOptions options;
    options.detail = detail;
    return writeFrameFiles({&body, 1}, times_, *frameNames(folder_.string(), extension), options,
                           progress);
  }

  nlohmann::json manifest() const {
    std::ifstream file(folder_ / "manifest.json");
    return nlohmann::json::parse(file, nullptr, false);
  }

  platform::TestFolder place_;
  fs::path folder_ = place_ / "frames";
  std::vector<double> times_ = {0, 0.3, 0.55, 1};
  model::Mesh mesh_;
};

TEST_F(FrameFiles, AreTheSolidsThatTheManifestSays) {
  for (const slice::SliceDetail detail : {slice::SliceDetail::Exact, slice::SliceDetail::Light}) {
    for (const char* extension : {".stl", ".obj", ".ply", ".glb"}) {
      const auto report = write(extension, detail);
      ASSERT_TRUE(report) << report.error().text();
      EXPECT_EQ(report->light, detail == slice::SliceDetail::Light);
      const auto list = manifest();
      ASSERT_EQ(list["frames"].size(), times_.size());
      std::uint64_t bytes = 0;
      for (std::size_t i = 0; i < times_.size(); ++i) {
        const auto& frame = list["frames"][i];
        EXPECT_EQ(frame["time"], times_[i]);
        const auto solid = formats::readTriangleMesh(folder_ / std::string(frame["file"]));
        ASSERT_TRUE(solid) << solid.error().text();
        EXPECT_EQ(solid->mesh.triangles.size(), frame["triangles"]);
        EXPECT_NEAR(signedVolume(solid->mesh), frame["volume"], 1e-5);
        EXPECT_NEAR(signedVolume(slice::sliceAtTime(mesh_, times_[i])->mesh), frame["volume"],
                    1e-12);
        if (detail == slice::SliceDetail::Light) {
          EXPECT_EQ(frame["triangles"], 12);
        }
        bytes += frame["bytes"].get<std::uint64_t>();
      }
      EXPECT_EQ(bytes, report->bytes);
      EXPECT_FALSE(fs::exists(folder_ / "frames.pvd"));
      fs::remove_all(folder_);
    }
  }
}

TEST_F(FrameFiles, OfVtkHaveACollection) {
  ASSERT_TRUE(write(".vtp", slice::SliceDetail::Light));
  const std::string text = platform::contents(folder_ / "frames.pvd");
  EXPECT_NE(text.find("timestep=\"0.55\" part=\"0\" file=\"frame_0002.vtp\""), std::string::npos);
}

TEST_F(FrameFiles, OtherFramesInTheFolderAreRefused) {
  ASSERT_TRUE(write(".obj", slice::SliceDetail::Exact));
  ASSERT_TRUE(write(".obj", slice::SliceDetail::Light));  // over the same
  times_.pop_back();
  const auto fewer = write(".obj", slice::SliceDetail::Light);
  ASSERT_FALSE(fewer);
  EXPECT_NE(fewer.error().message.find("frame_0003.obj, which would pass for a frame"),
            std::string::npos);
  EXPECT_EQ(manifest()["frames"].size(), 4U);
}

TEST_F(FrameFiles, ASeriesThatIsRefusedLeavesTheOldOne) {
  ASSERT_TRUE(write(".obj", slice::SliceDetail::Exact));
  const auto old = manifest();
  fs::remove(folder_ / "frame_0002.obj");
  fs::create_directory(folder_ / "frame_0002.obj");
  EXPECT_FALSE(write(".obj", slice::SliceDetail::Light));
  EXPECT_EQ(manifest(), old);
}

TEST_F(FrameFiles, ASeriesThatFailsHasNoManifest) {
  ASSERT_TRUE(write(".obj", slice::SliceDetail::Exact));
  const fs::path third = folder_ / "frame_0002.obj";
  const auto block = [&](double) {
    if (fs::is_regular_file(third)) fs::remove(third);
    fs::create_directory(third);
    return true;
  };
  EXPECT_FALSE(write(".obj", slice::SliceDetail::Light, block));
  EXPECT_FALSE(fs::exists(folder_ / "manifest.json"));
  fs::remove_all(folder_);
  times_ = {0, 2};
  EXPECT_FALSE(write(".obj", slice::SliceDetail::Light));
  EXPECT_FALSE(fs::exists(folder_));
}

}  // namespace
}  // namespace t4d::convert
