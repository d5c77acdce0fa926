#include "tools/bench/simplified_mesh.h"

#include <cmath>
#include <fstream>
#include <numeric>

#include <fmt/format.h>
#include <meshoptimizer.h>
#include <nlohmann/json.hpp>

#include "fixtures/solids.h"
#include "model/parallel.h"
#include "platform/child_process.h"
#include "t4d/edit.h"
#include "t4d/weave.h"
#include "voxel4d/sampled_frames.h"

namespace t4d::bench {
namespace {

constexpr double kRatio = 0.1;

/// A ball of radius 20 voxels that moves by half a voxel a frame.
Result<model::Mesh> wovenBall() {
  const auto field = [](const model::Point3& p, double t) {
    return (p - model::Point3(0.3 + 0.5 * t, 0.1, 0.2)).norm() - 20;
  };
  model::Bounds3 box;
  box.add({-25, -25, -25});
  box.add({33, 25, 25});
  std::vector<double> times(16);
  std::iota(times.begin(), times.end(), 0.0);
  voxel4d::SampleOptions options;
  options.slope = 1;
  const auto frames = voxel4d::sampledFrames(field, {}, box, times, options);
  model::Mesh mesh;
  if (auto woven = voxel4d::weave(*frames, {}, mesh); !woven) return woven.error();
  return mesh;
}

struct Collapses {
  double seconds = 0;
  double count = 0;

  double perMillion() const { return 1e6 * seconds / count; }
};

Result<Collapses> simplified(const model::Mesh& mesh, const edit::SimplifyOptions& options,
                             std::size_t threads) {
  const model::ThreadLimit control(threads);
  Result<edit::SimplifyReport> report;
  Collapses made;
  made.seconds = medianSeconds(1, [&] {
    model::Mesh result;
    report = edit::simplify(mesh, options, result);
  });
  if (!report) return report.error();
  made.count = static_cast<double>(report->verticesBefore - report->vertices);
  return made;
}

/// The sphere with at least so many triangles.
model::TriangleMesh sphereOf(std::uint64_t triangles) {
  int level = 0;
  while (20 * std::pow(4, level) < static_cast<double>(triangles)) ++level;
  return fixtures::icosphere(1, level);
}

Collapses ofMeshoptimizer(const model::TriangleMesh& sphere) {
  std::vector<float> positions;
  for (const model::Point3& at : sphere.vertices) {
    for (const double x : at) positions.push_back(static_cast<float>(x));
  }
  std::vector<unsigned> indices;
  for (const model::Triangle& one : sphere.triangles) {
    indices.insert(indices.end(), one.begin(), one.end());
  }
  std::vector<unsigned> left(indices.size());
  const auto goal = static_cast<std::size_t>(kRatio * static_cast<double>(indices.size()));
  Collapses made;
  made.seconds = medianSeconds(3, [&] {
    const std::size_t count =
        meshopt_simplify(left.data(), indices.data(), indices.size(), positions.data(),
                         sphere.vertices.size(), 3 * sizeof(float), goal, 1.0F);
    made.count = static_cast<double>(indices.size() - count) / 6;  // two triangles each
  });
  return made;
}

template <class T>
void writeArray(const std::filesystem::path& path, const std::vector<T>& array) {
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(array.data()),
             static_cast<std::streamsize>(array.size() * sizeof(T)));
}

/// The result of fast-simplification; nothing where it is not installed.
std::optional<Collapses> ofFastSimplification(const model::TriangleMesh& sphere,
                                              const std::filesystem::path& folder) {
  const auto points = folder / "points.bin";
  const auto triangles = folder / "triangles.bin";
  writeArray(points, sphere.vertices);
  writeArray(triangles, sphere.triangles);
  const auto run =
      platform::runProgram({T4D_BENCH_PYTHON, T4D_BENCH_PEERS, "decimate", points.string(),
                            triangles.string(), fmt::to_string(kRatio)});
  if (!run || run->end != platform::ProgramRun::End::Exited || run->code != 0) return std::nullopt;
  const auto said = nlohmann::json::parse(run->output, nullptr, false);
  if (said.is_discarded()) return std::nullopt;
  const auto left = said["result"].get<double>();
  return Collapses{said["seconds"], (static_cast<double>(sphere.triangles.size()) - left) / 2};
}

}  // namespace

Result<void> measureSimplifiedMesh(const std::filesystem::path& folder, Report& report) {
  const auto mesh = wovenBall();
  if (!mesh) return mesh.error();
  std::uint64_t cells = 0;
  for (const model::Slab& slab : mesh->slabs()) cells += slab.connectivity->cells.size();
  const edit::SimplifyOptions toTenth{.ratio = kRatio};
  const auto alone = simplified(*mesh, toTenth, 1);
  if (!alone) return alone.error();
  const auto both = simplified(*mesh, toTenth, 2);
  if (!both) return both.error();
  const auto proved = simplified(*mesh, {.maxError = 0.3}, 2);
  if (!proved) return proved.error();
  const model::TriangleMesh sphere = sphereOf(cells);
  const std::string what = "a million collapses of simplify";
  report.rows.push_back({what + ", 1 thread", alone->perMillion(), "meshoptimizer's, of a surface",
                         ofMeshoptimizer(sphere).perMillion()});
  if (const auto peer = ofFastSimplification(sphere, folder)) {
    report.rows.push_back({what + ", 1 thread", alone->perMillion(),
                           "fast-simplification's, of a surface", peer->perMillion()});
  }
  report.rows.push_back(
      {"simplify to a tenth, 1 thread", alone->seconds, "2 threads", both->seconds});
  report.rows.push_back({"simplify with a proved error of 0.3 voxels, 2 threads", proved->seconds,
                         "to a tenth, 2 threads", both->seconds});
  report.figures.push_back({"cells of the ball", static_cast<double>(cells) / 1e6, "million"});
  report.figures.push_back(
      {"triangles of the sphere", static_cast<double>(sphere.triangles.size()) / 1e6, "million"});
  report.figures.push_back(
      {"cells a second, 1 thread", static_cast<double>(cells) / alone->seconds / 1e6, "million"});
  return {};
}

}  // namespace t4d::bench
