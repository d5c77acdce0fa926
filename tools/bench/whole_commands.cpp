#include "tools/bench/whole_commands.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <optional>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "platform/child_process.h"
#include "t4d/surface.h"

namespace t4d::bench {
namespace {

using Words = std::vector<std::string>;

struct Run {
  double seconds = 0;
  std::uint64_t peakBytes = 0;
};

/// Writes samples of a field, x fastest, as the file formats below want them.
template <class Sample>
void putSamples(std::ofstream& file, int size, int frames,
                const std::function<Sample(int x, int y, int z, int t)>& field) {
  std::vector<Sample> plane(static_cast<std::size_t>(size) * size);
  for (int t = 0; t < frames; ++t) {
    for (int z = 0; z < size; ++z) {
      for (int y = 0; y < size; ++y) {
        for (int x = 0; x < size; ++x) {
          plane[static_cast<std::size_t>(y) * size + x] = field(x, y, z, t);
        }
      }
      file.write(reinterpret_cast<const char*>(plane.data()),
                 static_cast<std::streamsize>(plane.size() * sizeof(Sample)));
    }
  }
}

template <class Sample>
void writeNrrd(const std::filesystem::path& path, const char* type, int size, int frames,
               const std::function<Sample(int, int, int, int)>& field) {
  std::ofstream file(path, std::ios::binary);
  file << fmt::format(
      "NRRD0004\ntype: {}\ndimension: 4\nsizes: {} {} {} {}\nendian: little\nencoding: raw\n\n",
      type, size, size, size, frames);
  putSamples<Sample>(file, size, frames, field);
}

void writeNpy(const std::filesystem::path& path, int size, int frames,
              const std::function<float(int, int, int, int)>& field) {
  std::ofstream file(path, std::ios::binary);
  std::string header =
      fmt::format("{{'descr': '<f4', 'fortran_order': False, 'shape': ({}, {}, {}, {}), }}", frames,
                  size, size, size);
  constexpr std::size_t kPreamble = 10;
  header.resize((kPreamble + header.size() + 1 + 63) / 64 * 64 - kPreamble - 1, ' ');
  header += '\n';
  file << std::string_view("\x93NUMPY\x01\x00", 8) << static_cast<char>(header.size() % 256)
       << static_cast<char>(header.size() / 256) << header;
  putSamples<float>(file, size, frames, field);
}

/// The signed distance from a ball that moves along z.
std::function<float(int, int, int, int)> movingBall(double radius, double middle, double first,
                                                    double step) {
  return [=](int x, int y, int z, int t) {
    return static_cast<float>(std::hypot(x - middle, y - middle, z - (first + step * t)) - radius);
  };
}

class Commands {
 public:
  Commands(const WholeCommandsOptions& options, Report& report)
      : options_(options), report_(report) {}

  Result<void> all() {
    const auto fixtures = options_.program.parent_path() / "t4d-fixtures";
    if (auto made = ended({fixtures.string(), options_.folder.string()}); !made) {
      return made.error();
    }
    if (auto done = frames(); !done) return done;
    if (auto done = levelSets(); !done) return done;
    if (auto done = swept(); !done) return done;
    return walks();
  }

 private:
  std::string at(const std::string& name) const { return (options_.folder / name).string(); }

  Result<platform::ProgramRun> ended(const Words& words) const {
    auto run = platform::runProgram(words);
    if (!run) return run;
    if (run->end == platform::ProgramRun::End::Exited && (run->code == 0 || run->code == 3)) {
      return run;
    }
    return fail(ErrorCode::Failed, fmt::format("'{}' ended with {}: {}", fmt::join(words, " "),
                                               run->code, run->message));
  }

  /// Runs a command of a build of t4d.
  Result<platform::ProgramRun> run(const std::filesystem::path& program, Words words,
                                   std::size_t threads) const {
    words.insert(words.begin(), program.string());
    words.insert(words.end(), {"--quiet", "--threads", std::to_string(threads)});
    return ended(words);
  }

  Result<Run> timed(const Words& words, std::size_t threads) const {
    std::vector<double> seconds;
    Run median;
    for (int i = 0; i < options_.repetitions; ++i) {
      const auto run = this->run(options_.program, words, threads);
      if (!run) return run.error();
      seconds.push_back(run->seconds);
      median.peakBytes = std::max(median.peakBytes, run->peakBytes);
    }
    median.seconds = medianOf(std::move(seconds));
    return median;
  }

  /// What a peer says; nothing where its Python or a package is missing.
  std::optional<nlohmann::json> peer(const Words& arguments) const {
    Words words = {"/usr/bin/python3", T4D_BENCH_PEERS};
    words.insert(words.end(), arguments.begin(), arguments.end());
    std::vector<double> seconds;
    nlohmann::json said;
    for (int i = 0; i < options_.repetitions; ++i) {
      const auto run = ended(words);
      if (!run) return std::nullopt;
      said = nlohmann::json::parse(run->output, nullptr, false);
      if (said.is_discarded()) return std::nullopt;
      seconds.push_back(said["seconds"]);
    }
    said["seconds"] = medianOf(std::move(seconds));
    return said;
  }

  /// A command of both builds in turn.
  Result<void> pairs(const std::string& name, const Words& words) {
    std::vector<double> seconds;
    std::vector<double> againstSeconds;
    for (int i = 0; i < options_.repetitions; ++i) {
      const auto theirs = run(options_.against, words, 1);
      if (!theirs) return theirs.error();
      const auto ours = run(options_.program, words, 1);
      if (!ours) return ours.error();
      againstSeconds.push_back(theirs->processorSeconds);
      seconds.push_back(ours->processorSeconds);
    }
    report_.rows.push_back(rowOfPairs(name, seconds, "the other build", againstSeconds));
    return {};
  }

  /// A command whose output is the input of others.
  Result<void> input(const std::string& name, const Words& words, const std::string& peerName = {},
                     const Words& peerArguments = {}) {
    if (isWanted(name)) return row(name, words, peerName, peerArguments);
    const auto made = run(options_.program, words, 2);
    return made ? Result<void>() : made.error();
  }

  bool isWanted(const std::string& name) const {
    return name.find(options_.only) != std::string::npos;
  }

  /// A command on one thread and on all, or in pairs; against a peer on one.
  Result<void> row(const std::string& name, const Words& words, const std::string& peerName = {},
                   const Words& peerArguments = {}) {
    if (!isWanted(name)) return {};
    fmt::print(stderr, "t4d-bench: {}\n", name);
    if (!options_.against.empty()) return pairs(name, words);
    const auto one = timed(words, 1);
    if (!one) return one.error();
    const auto two = timed(words, 2);
    if (!two) return two.error();
    report_.rows.push_back({name + ", 1 thread", one->seconds, "2 threads", two->seconds});
    report_.figures.push_back(
        {name + ": peak memory", static_cast<double>(one->peakBytes) / 1e6, "MB"});
    if (peerName.empty()) return {};
    if (const auto said = peer(peerArguments)) {
      report_.rows.push_back({name + ", 1 thread", one->seconds, peerName, (*said)["seconds"]});
    }
    return {};
  }

  /// Dense frames, as microscopes, scanners and simulations write them.
  Result<void> frames() {
    writeNrrd<std::uint8_t>(at("cube.nrrd"), "uint8", 128, 66, [](int x, int y, int z, int t) {
      return std::max({std::abs(x - 54), std::abs(y - 54), std::abs(z - 22 - t)}) <= 10 ? 1 : 0;
    });
    writeNrrd<float>(at("ball.nrrd"), "float", 64, 34, movingBall(20, 31.3, 22, 0.5));
    if (auto done = row("weave the paper's cube, 128^3 x 66 uint8 (NRRD)",
                        {"weave", at("cube.nrrd"), "--label", "1", "-o", at("cube.t4d")},
                        "vtkFlyingEdges3D a frame", {"surfaces", at("cube.nrrd")});
        !done) {
      return done;
    }
    if (auto done = input("weave a dense ball, 64^3 x 34 float (NRRD)",
                          {"weave", at("ball.nrrd"), "-o", at("ball.t4d")},
                          "vtkFlyingEdges3D a frame", {"surfaces", at("ball.nrrd")});
        !done) {
      return done;
    }
    if (!options_.large) return {};
    writeNpy(at("frames.npy"), 192, 60, movingBall(50, 95.3, 70, 0.8));
    return row("weave a ball, 192^3 x 60 float (1.7 GB of .npy)",
               {"weave", at("frames.npy"), "-o", at("frames.t4d")}, "numpy: frame > 0",
               {"pass", at("frames.npy")});
  }

  Result<void> levelSets() {
    const std::string name = "weave 30 level sets (.vdb)";
    if (!isWanted(name)) return {};
    const std::string mesh = options_.mesh.empty() ? at("bolt.obj") : options_.mesh;
    const auto solid = formats::readTriangleMesh(mesh);
    if (!solid) return solid.error();
    model::Bounds3 bounds;
    for (const model::Point3& vertex : solid->mesh.vertices) bounds.add(vertex);
    const double size = (bounds.max - bounds.min).maxCoeff();
    std::ofstream(at("move.json")) << fmt::format(
        R"({{"segments": [{{"duration": 29, "axis_direction": [1, 0, 0], "angle_degrees": 0,)"
        R"( "translation": [{}, 0, 0]}}]}})",
        0.1 * size);
    constexpr double kVoxels = 250;  // along the longest side
    if (auto made = ended({options_.program.string(), "voxelize", mesh, "--motion", at("move.json"),
                           "--voxel-size", fmt::format("{}", size / kVoxels), "--frames", "30",
                           "--quiet", "-o", at("level-sets")});
        !made) {
      return made.error();
    }
    return row(name, {"weave", at("level-sets"), "-o", at("sets.t4d")});
  }

  Result<void> swept() {
    return input("sweep a bolt", {"sweep", at("bolt.obj"), "--motion", at("screw-in.json"), "--up",
                                  "z", "-o", at("bolt.t4d")});
  }

  /// Verbs that walk through the slabs.
  Result<void> walks() {
    for (const auto& [mesh, file] :
         {std::pair("a swept bolt", at("bolt.t4d")), std::pair("a woven ball", at("ball.t4d"))}) {
      const auto named = [mesh = std::string(mesh)](const char* verb) {
        return fmt::format("{}: {}", mesh, verb);
      };
      const std::vector<std::pair<std::string, Words>> commands = {
          {named("validate"), {"validate", file}},
          {named("quality"), {"quality", file}},
          {named("slice by x"), {"slice", file, "--x", "0.1", "-o", at("x.ply")}},
          {named("slice by a hyperplane"),
           {"slice", file, "--hyperplane", "1,0.3,0.2,0.5,2", "-o", at("h.ply")}},
          {named("flipbook"), {"flipbook", file, "--frames", "60", "-o", at("flip.glb")}},
          {named("frames"), {"frames", file, "--frames", "60", "-o", at("frames/f_%04d.ply")}},
          {named("measure"), {"measure", file, "--frames", "100"}},
          {named("track"), {"track", file, "-o", at("tracks.csv")}},
          {named("rasterize"),
           {"rasterize", file, "--voxel-size", "1", "--frames", "10", "-o", at("grids")}},
          {named("compare"), {"compare", file, file, "--slices", "3"}},
          {named("compress"), {"compress", file, "-o", at("small.t4d")}},
          {named("convert"), {"convert", file, at("mesh.vtu")}},
          {named("envelope"), {"envelope", file, "-o", at("envelope.ply")}},
      };
      for (const auto& [name, words] : commands) {
        if (auto done = row(name, words); !done) return done;
      }
    }
    // The last mesh that was converted.
    return row("a woven ball: slice at a time",
               {"slice", at("ball.t4d"), "--time", "8.3", "-o", at("t.ply")},
               "vtkContour3DLinearGrid, in memory", {"contour", at("mesh.vtu"), "8.3"});
  }

  const WholeCommandsOptions& options_;
  Report& report_;
};

}  // namespace

Result<void> measureWholeCommands(const WholeCommandsOptions& options, Report& report) {
  return Commands(options, report).all();
}

}  // namespace t4d::bench
