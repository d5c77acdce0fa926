#include <filesystem>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "fixtures/solids.h"
#include "platform/process.h"
#include "platform/temporary_folder.h"
#include "t4d/surface.h"
#include "tools/bench/arm_and_obstacles.h"
#include "tools/bench/collided_meshes.h"
#include "tools/bench/simplified_mesh.h"
#include "tools/bench/swept_mesh.h"
#include "tools/bench/tracked_meshes.h"
#include "tools/bench/whole_commands.h"
#include "tools/bench/woven_voxels.h"

namespace {

using namespace t4d;

struct Options {
  std::string mesh;
  std::string folder = std::filesystem::temp_directory_path().string();
  int repetitions = 7;
  std::string backend = "mesh4d";
  bool large = false;
  bool files = false;
  std::string against;
  std::string only;
  bool json = false;
};

/// The paper's screw (section 5.2): a turn about x with +20 along x during t = 0 to 100, at an
/// R_Vmin of 0.9976.
constexpr double kPaperMinVolumeRatio = 0.9976;
Result<model::Motion> paperScrew() {
  model::ScrewRun run;
  run.duration = 100;
  run.screw.axisDirection = Eigen::Vector3d::UnitX();
  run.screw.angleDegrees = 360;
  run.screw.translation = {20, 0, 0};
  return model::chainScrews(0, {&run, 1});
}

Result<platform::TemporaryFolder> temporaryFolder(const Options& options) {
  std::filesystem::create_directories(options.folder);
  return platform::TemporaryFolder::createIn(options.folder);
}

Result<bench::Report> measureFiles(const Options& options) {
  bench::Report report;
  report.repetitions = options.repetitions;
  report.input = "whole commands";
  const auto folder = temporaryFolder(options);
  if (!folder) return folder.error();
  const auto program = platform::executablePath().parent_path() / "t4d";
  auto measured =
      bench::measureWholeCommands({options.repetitions, options.large, options.mesh, program,
                                   folder->path(), options.against, options.only},
                                  report);
  if (!measured) return measured.error();
  return report;
}

Result<bench::Report> measure(const Options& options) {
  if (options.files || !options.against.empty()) return measureFiles(options);
  bench::Report report;
  report.repetitions = options.repetitions;
  if (options.backend == "voxel4d") {
    report.input = "voxels";
    if (auto measured =
            bench::measureWovenVoxels(options.repetitions, options.large, options.folder, report);
        !measured) {
      return measured.error();
    }
    return report;
  }
#if T4D_WITH_MESHOPTIMIZER
  if (options.backend == "simplify") {
    report.input = "a woven ball";
    const auto folder = temporaryFolder(options);
    if (!folder) return folder.error();
    if (auto measured = bench::measureSimplifiedMesh(folder->path(), report); !measured) {
      return measured.error();
    }
    return report;
  }
#endif
#if T4D_WITH_FCL
  if (options.backend == "arm") {
    report.input = "an arm of six links and twenty obstacles";
    if (auto measured = bench::measureArmAndObstacles(report); !measured) {
      return measured.error();
    }
    return report;
  }
#endif
  model::TriangleMesh solid;
  if (options.mesh.empty()) {
    report.input = "icosphere";
    solid = fixtures::icosphere(1, 5);
  } else {
    auto loaded = formats::readTriangleMesh(options.mesh);
    if (!loaded) return loaded.error();
    report.input = std::filesystem::path(options.mesh).filename().string();
    solid = std::move(loaded->mesh);
  }
  const auto motion = paperScrew();
  if (!motion) return motion.error();
#if T4D_WITH_CGAL
  if (options.backend == "collide") {
    auto measured = bench::measureCollidedMeshes(solid, *motion, kPaperMinVolumeRatio, report);
    if (!measured) return measured.error();
    return report;
  }
#endif
  if (options.backend == "track") {
    auto measured = bench::measureTrackedMeshes(solid, *motion, kPaperMinVolumeRatio, report);
    if (!measured) return measured.error();
    return report;
  }
  const auto folder = temporaryFolder(options);
  if (!folder) return folder.error();
  auto measured =
      bench::measureSweptMesh(solid, *motion, kPaperMinVolumeRatio, folder->path(), report);
  if (!measured) return measured.error();
  return report;
}

}  // namespace

int main(int argc, char** argv) try {
  CLI::App app(
      "t4d-bench: times t4d against simpler operations on as many bytes.\n"
      "Both sides of a ratio are timed in one run. The motion is the paper's screw.");
  Options options;
  app.add_option(
         "--backend", options.backend,
         "What to measure: mesh4d (sweeping, files, slicing), voxel4d (weaving), track (of a "
         "swept solid and of a woven splash), collide "
         "(against frames; where there is CGAL), arm (colliding pairs, against FCL; where "
         "this is) or simplify (against meshoptimizer, where this is)")
      ->check(CLI::IsMember(std::vector<std::string> {
        "mesh4d", "voxel4d", "track",
#if T4D_WITH_CGAL
            "collide",
#endif
#if T4D_WITH_FCL
            "arm",
#endif
#if T4D_WITH_MESHOPTIMIZER
            "simplify",
#endif
      }))
      ->capture_default_str();
  app.add_flag(
      "--files", options.files,
      "Time whole commands on files instead: frames that others write, and every verb that "
      "walks through a mesh, on one thread and on two");
  app.add_option("--against", options.against,
                 "Another t4d: compare whole commands of this build with it, in pairs of runs")
      ->check(CLI::ExistingFile);
  app.add_option("--only", options.only,
                 "With --files or --against: only commands whose names contain this");
  app.add_flag("--large", options.large,
               "voxel4d: also a shell of 48 million cells a slab, which takes minutes; with "
               "--files: also 1.7 GB of samples");
  app.add_option("--mesh", options.mesh,
                 "The solid: .stl, .obj, .ply, .off, .gltf or .glb (default: a sphere of 20,480 "
                 "triangles; with --files: a bolt)");
  app.add_option("--repetitions", options.repetitions, "Number of runs; medians are printed")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  app.add_option("--folder", options.folder, "Folder for temporary files")->capture_default_str();
  app.add_flag("--json", options.json, "Print JSON");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  const auto report = measure(options);
  if (!report) {
    fmt::print(stderr, "t4d-bench: {}\n", report.error().text());
    return report.error().code == ErrorCode::Failed ? 1 : 4;
  }
  fmt::print("{}", options.json ? jsonOf(*report) : textOf(*report));
  return 0;
} catch (const std::exception& error) {
  fmt::print(stderr, "t4d-bench: {}\n", error.what());
  return 1;
}
