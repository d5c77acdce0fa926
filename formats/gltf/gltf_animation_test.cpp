#include "formats/gltf/gltf_animation.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include <fmt/format.h>

#include "formats/test_files.h"

namespace t4d::formats {
namespace {

using model::Point3;

/// A glTF text whose only mesh is a tetrahedron, at the node `body`.
class Gltf {
 public:
  std::string nodes = R"({"name":"body","mesh":0})";
  std::string more;

  int accessor(const char* type, const std::vector<double>& numbers, int width) {
    for (const double number : numbers) bytes_ += bytesOf(static_cast<float>(number));
    accessors_ += fmt::format(
        R"({}{{"bufferView":0,"byteOffset":{},"componentType":5126,"count":{},"type":"{}"}})",
        count_ == 0 ? "" : ",", bytes_.size() - 4 * numbers.size(),
        numbers.size() / static_cast<std::size_t>(width), type);
    return count_++;
  }
  void animate(int node, const char* property, const char* interpolation,
               const std::vector<double>& times, const std::vector<double>& values) {
    const std::string path = property;
    const int width = path == "rotation" ? 4 : path == "weights" ? 1 : 3;
    const int input = accessor("SCALAR", times, 1);
    const int output = accessor(width == 4   ? "VEC4"
                                : width == 3 ? "VEC3"
                                             : "SCALAR",
                                values, width);
    const char* comma = channels_ == 0 ? "" : ",";
    samplerText_ += fmt::format(R"({}{{"input":{},"output":{},"interpolation":"{}"}})", comma,
                                input, output, interpolation);
    channelText_ += fmt::format(R"({}{{"sampler":{},"target":{{"node":{},"path":"{}"}}}})", comma,
                                channels_++, node, property);
  }
  /// A channel with KHR_animation_pointer.
  void animatePointer(const char* pointer, const char* interpolation,
                      const std::vector<double>& times, const std::vector<double>& values) {
    animate(-1, "pointer", interpolation, times, values);
    const std::string node = R"("node":-1,)";
    channelText_.erase(channelText_.rfind(node), node.size());
    channelText_.insert(
        channelText_.size() - 2,
        fmt::format(R"(,"extensions":{{"KHR_animation_pointer":{{"pointer":"{}"}}}})", pointer));
  }
  InputFile file(const std::string& primitive = {}) {
    const int positions =
        accessor("VEC3", {1, 1, 1, 2, -1, 0, 0, 2, -1, -1, 0, 2, /**/ 1, 1, 1}, 3);
    const auto path = temporaryPath("a.gltf");
    const std::string text = fmt::format(
        R"({{"asset":{{"version":"2.0"}},"nodes":[{}],"meshes":[{{"primitives":[{{)"
        R"("attributes":{{"POSITION":{}{}}}]}}],"animations":[{{"name":"go","samplers":[{}],)"
        R"("channels":[{}]}}],"accessors":[{}],"bufferViews":[{{"buffer":0,"byteLength":{}}}],)"
        R"("buffers":[{{"byteLength":{},"uri":"a.bin"}}]{}}})",
        nodes, positions, primitive.empty() ? R"(},"mode":5)" : primitive, samplerText_,
        channelText_, accessors_, bytes_.size(), bytes_.size(), more);
    writeFile("a.bin", bytes_);
    return {path, text};
  }

 private:
  std::string bytes_;
  std::string accessors_;
  std::string samplerText_;
  std::string channelText_;
  int count_ = 0;
  int channels_ = 0;
};

/// Reads with the tolerance of vertices alone, unless edges count, too.
AnimatedScene readOf(const InputFile& file, double tolerance, double edgeFactor = 0) {
  auto scene = readGltfAnimation(file, {"", "", tolerance, edgeFactor});
  EXPECT_TRUE(scene) << scene.error().text();
  return scene ? std::move(*scene) : AnimatedScene{};
}

std::vector<Point3> positionsAt(const AnimatedBody& body, std::uint64_t key) {
  std::vector<Point3> positions(body.mesh.vertices.size());
  EXPECT_TRUE(body.runs[0]->positions(key, positions));
  return positions;
}

/// The largest distance of vertices between two coarse keys from the places at the fine keys.
double deviation(const AnimatedBody& coarse, const AnimatedBody& fine) {
  double largest = 0;
  std::uint64_t next = 1;
  for (std::uint64_t key = 0; key < fine.runs[0]->count(); ++key) {
    const double time = fine.runs[0]->time(key);
    while (coarse.runs[0]->time(next) < time) ++next;
    const double begin = coarse.runs[0]->time(next - 1);
    const double s = (time - begin) / (coarse.runs[0]->time(next) - begin);
    const auto from = positionsAt(coarse, next - 1);
    const auto to = positionsAt(coarse, next);
    const auto there = positionsAt(fine, key);
    for (std::size_t i = 0; i < there.size(); ++i) {
      largest = std::max(largest, ((1 - s) * from[i] + s * to[i] - there[i]).norm());
    }
  }
  return largest;
}

/// Checks the promise of the tolerance, and that it is not kept by far too many keys.
void expectWithinTolerance(const InputFile& file, double tolerance, double used) {
  const AnimatedScene coarse = readOf(file, tolerance);
  const AnimatedScene fine = readOf(file, tolerance / 400);
  ASSERT_EQ(coarse.bodies.size(), 1U);
  ASSERT_GT(fine.bodies[0].runs[0]->count(), 4 * coarse.bodies[0].runs[0]->count());
  const double found = deviation(coarse.bodies[0], fine.bodies[0]);
  EXPECT_LE(found, tolerance);
  EXPECT_GE(found, used * tolerance) << coarse.bodies[0].runs[0]->count() << " keys";
}

const double kHalf = std::sqrt(0.5);

TEST(GltfAnimation, RotationsStayWithinTheTolerance) {
  Gltf gltf;
  gltf.animate(0, "rotation", "LINEAR", {0, 2}, {0, 0, 0, 1, 0, 0, kHalf, kHalf});
  for (const double tolerance : {0.3, 0.01, 1e-4}) {
    expectWithinTolerance(gltf.file(), tolerance, 0.3);
  }
}

TEST(GltfAnimation, TheToleranceOfABodyIsAThousandthOfItsOwnSize) {
  Gltf gltf;
  gltf.nodes = R"({"name":"body","mesh":0},{"name":"ground","mesh":0,"scale":[1000,1000,1000]})";
  gltf.animate(0, "rotation", "LINEAR", {0, 2}, {0, 0, 0, 1, 0, 0, kHalf, kHalf});
  const auto scene = readGltfAnimation(gltf.file(), {});
  ASSERT_TRUE(scene) << scene.error().text();
  ASSERT_EQ(scene->bodies.size(), 2U);
  const double own = scene->bodies[0].tolerance.value_or(0);
  EXPECT_NEAR(own, 3e-3, 1.5e-3);
  EXPECT_NEAR(scene->bodies[1].tolerance.value_or(0), 3, 1e-6);
  Gltf alone;
  alone.animate(0, "rotation", "LINEAR", {0, 2}, {0, 0, 0, 1, 0, 0, kHalf, kHalf});
  const auto one = readGltfAnimation(alone.file(), {});
  ASSERT_TRUE(one) << one.error().text();
  EXPECT_EQ(one->bodies[0].tolerance, own);
  EXPECT_EQ(one->bodies[0].runs[0]->count(), scene->bodies[0].runs[0]->count());
}

TEST(GltfAnimation, SlicesStayWithinTheTolerance) {
  Gltf gltf;
  gltf.nodes = R"({"name":"parent","children":[1],"scale":[1,2,3]},{"name":"body","mesh":0})";
  gltf.animate(0, "rotation", "LINEAR", {0, 2}, {0, 0, 0, 1, 0, 0, kHalf, kHalf});
  gltf.animate(1, "scale", "LINEAR", {0, 2}, {1, 1, 1, 2, 1, 1});
  const AnimatedScene fine = readOf(gltf.file(), 1e-6);
  for (const double tolerance : {0.3, 0.01, 1e-3}) {
    for (const double factor : {model::kEdgeFactorOf14, model::kEdgeFactorOf3}) {
      const AnimatedScene scene = readOf(gltf.file(), tolerance, factor);
      const AnimatedBody& body = scene.bodies.at(0);
      double edges = 0;
      for (std::uint64_t key = 1; key < body.runs[0]->count(); ++key) {
        edges =
            std::max(edges, model::edgeDeviation(positionsAt(body, key - 1), positionsAt(body, key),
                                                 body.mesh.triangles, factor));
      }
      EXPECT_LE(edges + deviation(body, fine.bodies[0]), tolerance);
      EXPECT_GE(edges, 0.1 * tolerance) << body.runs[0]->count() << " keys";
    }
  }
}

TEST(GltfAnimation, HalfTurnsAreListed) {
  Gltf gltf;
  gltf.animate(0, "rotation", "LINEAR", {0, 1, 2, 4},
               {0, 0, 0, 1, 0, 0, 1, 0, 0, 0, kHalf, kHalf, kHalf, 0, kHalf, 1e-4});
  const AnimatedScene scene = readOf(gltf.file(), 0.1);
  ASSERT_EQ(scene.halfTurns.size(), 1U);
  EXPECT_EQ(scene.halfTurns[0].between, "keys 0 and 1 of node 'body'");
  EXPECT_EQ(scene.halfTurns[0].time.end, 1);
  EXPECT_TRUE(std::ranges::any_of(scene.notices, [](const std::string& notice) {
    return notice.starts_with("keys 0 and 1 of node 'body' are half a turn apart");
  }));
}

TEST(GltfAnimation, SplinesStayWithinTheTolerance) {
  Gltf moved;
  moved.animate(0, "translation", "CUBICSPLINE", {0, 1, 3},
                {0, 0, 0, 0, 0, 0, 5, 0, 0, 1, 2, 3, 4, 4, 0, -5, 1, 0, 0, 9, 0, 0, 0, 1, 0, 0, 0});
  expectWithinTolerance(moved.file(), 0.01, 0.3);
  Gltf turned;
  turned.animate(0, "rotation", "CUBICSPLINE", {0, 1, 3},
                 {0, 0,     0, 0, 0, 0,  0, 1, 1, 0, 0.5, 0, 0.2, 0.3, 0, 0, kHalf, 0,
                  0, kHalf, 0, 1, 0, -1, 0, 0, 0, 0, 0,   1, 0,   0,   0, 0, 0,     0});
  expectWithinTolerance(turned.file(), 0.01, 0.02);
}

/// The spline of glTF 2.0, appendix C.5: the tangents count by the duration of the segment.
Eigen::VectorXd splineAt(const std::vector<double>& times, const std::vector<double>& numbers,
                         double time) {
  const auto width = static_cast<Eigen::Index>(numbers.size() / times.size() / 3);
  const auto number = [&](std::size_t key, Eigen::Index i) {
    const auto at = static_cast<Eigen::Index>(3 * key) + i;
    return Eigen::VectorXd(Eigen::Map<const Eigen::VectorXd>(&numbers[at * width], width));
  };
  if (time >= times.back()) return number(times.size() - 1, 1);
  std::size_t key = 0;
  while (times[key + 1] <= time) ++key;
  const double duration = times[key + 1] - times[key];
  const double s = (time - times[key]) / duration;
  return (2 * s * s * s - 3 * s * s + 1) * number(key, 1) +
         duration * (s * s * s - 2 * s * s + s) * number(key, 2) +
         (-2 * s * s * s + 3 * s * s) * number(key + 1, 1) +
         duration * (s * s * s - s * s) * number(key + 1, 0);
}

/// The places at every key of what `gltf` makes of its only body are those that `placed` says.
template <class Placed>
void expectPlaced(Gltf gltf, const Placed& placed) {
  const AnimatedScene scene = readOf(gltf.file(), 0.01);
  ASSERT_EQ(scene.bodies.size(), 1U);
  const AnimatedBody& body = scene.bodies[0];
  ASSERT_GT(body.runs[0]->count(), 20U);
  const std::vector<Point3> base = {{1, 1, 1}, {2, -1, 0}, {0, 2, -1}, {-1, 0, 2}};
  for (std::uint64_t key = 0; key < body.runs[0]->count(); ++key) {
    const double time = body.runs[0]->time(key);
    const std::vector<Point3> found = positionsAt(body, key);
    for (std::size_t i = 0; i < base.size(); ++i) {
      // Numbers of the file are float32.
      EXPECT_LT((found[i] - placed(time, base[i])).norm(), 1e-5) << "at " << time;
    }
  }
}

TEST(GltfAnimation, PlacesAreThoseOfTheCurvesAtAllKeys) {
  const std::vector<double> times = {0, 1, 3};
  // Ends before the other curve.
  const std::vector<double> ways = {0, 0,  0, 0, 0, 0, 5, 0, 0, 1, 2, 3, 4, 4,
                                    0, -5, 1, 0, 0, 9, 0, 0, 0, 1, 0, 0, 0};
  const std::vector<double> turns = {0,   0,   0, 0, 0,     0, 0, 1,     1, 0, 0.5, 0,
                                     0.2, 0.3, 0, 0, kHalf, 0, 0, kHalf, 0, 1, 0,   -1,
                                     0,   0,   0, 0, 0,     1, 0, 0,     0, 0, 0,   0};
  Gltf splines;
  splines.animate(0, "translation", "CUBICSPLINE", times, ways);
  splines.animate(0, "rotation", "CUBICSPLINE", {0, 2, 4.5}, turns);
  expectPlaced(splines, [&](double time, const Point3& p) -> Point3 {
    const Eigen::Quaterniond turn(Eigen::Vector4d(splineAt({0, 2, 4.5}, turns, time)));
    return turn.normalized() * p + Point3(splineAt(times, ways, time));
  });
  // The node turns by 90 degrees about z in a unit of time, and on by 120 in two.
  const double sine = std::sin(105 * std::numbers::pi / 180);
  const double cosine = std::cos(105 * std::numbers::pi / 180);
  Gltf linear;
  linear.animate(0, "rotation", "LINEAR", times,
                 {0, 0, 0, 1, 0, 0, kHalf, kHalf, 0, 0, sine, cosine});
  expectPlaced(linear, [](double time, const Point3& p) -> Point3 {
    const double degrees = time < 1 ? 90 * time : 90 + 60 * (time - 1);
    return Eigen::AngleAxisd(degrees * std::numbers::pi / 180, Eigen::Vector3d::UnitZ()) * p;
  });
}

TEST(GltfAnimation, HierarchiesStayWithinTheTolerance) {
  Gltf gltf;
  gltf.nodes = R"({"name":"body","mesh":0,"translation":[2,0,0]},{"children":[0],"scale":[1,2,1]},)"
               R"({"children":[1],"matrix":[0,2,0,0,-2,0,0,0,0,0,2,0,1,1,1,1]})";
  gltf.animate(0, "rotation", "LINEAR", {0, 0.5, 2},
               {0, 0, 0, 1, 0, 0.6, 0, 0.8, 0, 0, kHalf, -kHalf});
  gltf.animate(1, "translation", "LINEAR", {0, 2}, {0, 0, 0, 3, 1, 0});
  gltf.animate(1, "rotation", "LINEAR", {0, 1, 2}, {0, 0, 0, 1, 0.6, 0, 0, 0.8, 0, 0, 0, 1});
  gltf.animate(1, "scale", "LINEAR", {0, 2}, {1, 2, 1, 2, 0.5, 1});
  expectWithinTolerance(gltf.file(), 0.02, 0.05);
}

TEST(GltfAnimation, AScaleKeepsItsSignOrHides) {
  const auto read = [](const char* interpolation, const std::vector<double>& scales) {
    Gltf gltf;
    gltf.nodes = R"({"name":"body","mesh":0})";
    gltf.animate(0, "scale", interpolation, {0, 1}, scales);
    gltf.animate(0, "translation", "LINEAR", {0, 2}, {0, 0, 0, 1, 0, 0});
    return readGltfAnimation(gltf.file(), {});
  };
  for (const double end : {0.0, -1.0}) {
    const auto refused = read("LINEAR", {1, 1, 1, 1, 1, end});
    ASSERT_FALSE(refused);
    EXPECT_TRUE(refused.error().message.starts_with("its scale shrinks to zero"));
  }
  EXPECT_TRUE(read("LINEAR", {-1, 1, 1, -2, 1, 0.1}));
  // Hidden at first, and so without a size at time 0.
  EXPECT_TRUE(read("STEP", {0, 0, 0, 1, 1, 1}));
  // The scale goes from 1 to 1, by way of -0.25 or of 0.25.
  const auto spline = [](double tangent) {
    return std::vector<double>{0, 0, 0, 1, 1, 1, tangent, 0, 0, -tangent, 0, 0, 1, 1, 1, 0, 0, 0};
  };
  EXPECT_FALSE(read("CUBICSPLINE", spline(-5)));
  EXPECT_TRUE(read("CUBICSPLINE", spline(-3)));
}

/// A tetrahedron with a skin, a morph target and curves of several kinds.
InputFile skinned() {
  Gltf gltf;
  gltf.nodes = R"({"name":"body","mesh":0,"skin":0},{},{"translation":[0,1,0]})";
  gltf.animate(1, "rotation", "LINEAR", {0, 2}, {0, 0, 0, 1, 0, 0, kHalf, kHalf});
  gltf.animate(2, "rotation", "LINEAR", {0, 1, 2}, {0, 0, 0, 1, 0.6, 0, 0, 0.8, 0, 0, 0, 1});
  gltf.animate(0, "weights", "CUBICSPLINE", {0, 2}, {0, 0, 2, 0, 1, 0});
  const int both =
      gltf.accessor("VEC4", {0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0}, 4);
  const int weights = gltf.accessor(
      "VEC4", {0.5, 0.5, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0.25, 0.75, 0, 0, 0.5, 0.5, 0, 0}, 4);
  const int target = gltf.accessor("VEC3", {0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1}, 3);
  gltf.more = R"(,"skins":[{"joints":[1,2]}])";
  return gltf.file(fmt::format(R"(,"JOINTS_0":{},"WEIGHTS_0":{}}},"targets":[{{"POSITION":{}}}],)"
                               R"("mode":5)",
                               both, weights, target));
}

TEST(GltfAnimation, SkinsAndMorphTargetsStayWithinTheTolerance) {
  expectWithinTolerance(skinned(), 0.02, 0.05);
}

/// A tetrahedron with a morph target, three times: as it is, turned and mirrored, hidden.
InputFile instanced(const char* nodes = R"({"name":"body","mesh":0,"extensions":)"
                                        R"({"EXT_mesh_gpu_instancing":{"attributes":)"
                                        R"({"TRANSLATION":0,"ROTATION":1,"SCALE":2}}}})") {
  Gltf gltf;
  gltf.nodes = nodes;
  gltf.accessor("VEC3", {0, 0, 0, 10, 0, 0, 0, 0, 0}, 3);
  gltf.accessor("VEC4", {0, 0, 0, 1, 0, 0, kHalf, kHalf, 0, 0, 0, 1}, 4);
  gltf.accessor("VEC3", {1, 1, 1, -1, 2, 1, 0, 0, 0}, 3);
  gltf.animate(0, "rotation", "LINEAR", {0, 2}, {0, 0, 0, 1, 0, 0, kHalf, kHalf});
  gltf.animate(0, "weights", "LINEAR", {0, 2}, {0, 1});
  const int target = gltf.accessor("VEC3", {0, 0, 1, 0, 1, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1}, 3);
  return gltf.file(fmt::format(R"(}},"targets":[{{"POSITION":{}}}],"mode":5)", target));
}

TEST(GltfAnimation, InstancesOfANodeAreOneBody) {
  const AnimatedScene scene = readOf(instanced(), 0.01);
  ASSERT_EQ(scene.bodies.size(), 1U);
  EXPECT_EQ(scene.losses, std::vector<std::string>{});
  EXPECT_EQ(scene.notices,
            std::vector<std::string>{"left out 1 hidden instance, whose scale is zero"});
  const AnimatedBody& body = scene.bodies[0];
  ASSERT_EQ(body.mesh.vertices.size(), 8U);
  ASSERT_EQ(body.mesh.triangles.size(), 6U);
  // The mirrored one is turned over.
  for (std::size_t i = 0; i < 3; ++i) {
    const auto [x, y, z] = body.mesh.triangles[i];
    EXPECT_EQ(body.mesh.triangles[3 + i], (model::Triangle{x + 4, z + 4, y + 4}));
  }
  // At the end the target has its whole weight, and the node is turned by 90 degrees about z.
  const auto quarter = [](const Point3& p) { return Point3(-p.y(), p.x(), p.z()); };
  const auto placed = [&](const Point3& p) {
    return Point3(quarter({-p.x(), 2 * p.y(), p.z()}) + Point3(10, 0, 0));
  };
  const auto last = positionsAt(body, body.runs[0]->count() - 1);
  const std::vector<Point3> base = {{1, 1, 1}, {2, -1, 0}, {0, 2, -1}, {-1, 0, 2}};
  const std::vector<Point3> moved = {{0, 0, 1}, {0, 1, 0}, {1, 0, 0}, {0, 1, 0}};
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_LT((last[i] - quarter(base[i] + moved[i])).norm(), 1e-6);
    EXPECT_LT((last[4 + i] - quarter(placed(base[i] + moved[i]))).norm(), 1e-6);
  }
  expectWithinTolerance(instanced(), 0.02, 0.05);
}

TEST(GltfAnimation, InstancesOfASkinAreRefused) {
  const auto scene = readGltfAnimation(
      instanced(R"({"name":"body","mesh":0,"skin":0,"extensions":{"EXT_mesh_gpu_instancing":)"
                R"({"attributes":{"TRANSLATION":0}}}})"),
      {});
  ASSERT_FALSE(scene);
  EXPECT_TRUE(scene.error().message.starts_with("has a skin and instances"));
}

class DamagedGltfAnimation : public testing::TestWithParam<InputFile (*)()> {};

InputFile instancedWhole() { return instanced(); }

INSTANTIATE_TEST_SUITE_P(Files, DamagedGltfAnimation, testing::Values(&skinned, &instancedWhole));

TEST_P(DamagedGltfAnimation, IsReadOrRefused) {
  const InputFile whole = GetParam()();
  const auto judge = [](const InputFile& file) {
    const auto scene = readGltfAnimation(file, {"", "", 0.5});
    if (!scene) {
      EXPECT_TRUE(scene.error().where.file.starts_with(file.path.string())) << scene.error().text();
      return;
    }
    for (const AnimatedBody& body : scene->bodies) {
      std::vector<Point3> positions(body.mesh.vertices.size());
      for (const auto& run : body.runs) {
        ASSERT_GE(run->count(), 2U);
        // Damaged numbers may ask for a million keys.
        for (std::uint64_t key = 0; key < std::min<std::uint64_t>(run->count(), 50); ++key) {
          EXPECT_TRUE(run->positions(key, positions));
          EXPECT_TRUE(key == 0 || run->time(key) > run->time(key - 1));
        }
      }
    }
  };
  for (std::size_t size = 0; size < whole.bytes.size(); ++size) {
    judge({whole.path, whole.bytes.substr(0, size)});
  }
  std::mt19937 random(2);
  const std::string telling = "0123456789-,:{}[]\"";
  for (int round = 0; round < 1500; ++round) {
    InputFile damaged = whole;
    for (int i = 0; i < 2; ++i) {
      damaged.bytes[random() % damaged.bytes.size()] = telling[random() % telling.size()];
    }
    judge(damaged);
  }
  // The numbers of the curves, in the buffer.
  const std::string numbers = platform::contents(temporaryPath("a.bin"));
  for (int round = 0; round < 300; ++round) {
    std::string damaged = numbers;
    damaged[random() % damaged.size()] = static_cast<char>(random());
    writeFile("a.bin", damaged);
    judge(whole);
  }
}

TEST(GltfAnimation, LinearMotionHasKeysOnlyWhereTheFileHas) {
  Gltf gltf;
  gltf.animate(0, "translation", "LINEAR", {0.5, 1, 3}, {0, 0, 0, 1, 2, 3, 9, 9, 9});
  const AnimatedScene scene = readOf(gltf.file(), 1e-9);
  const auto& run = *scene.bodies[0].runs[0];
  ASSERT_EQ(run.count(), 4U);
  EXPECT_EQ(run.time(0), 0);
  EXPECT_EQ(run.time(1), 0.5);
  EXPECT_EQ(run.time(3), 3);
  EXPECT_EQ(positionsAt(scene.bodies[0], 0), positionsAt(scene.bodies[0], 1));
  EXPECT_TRUE(run.pose(2));
}

TEST(GltfAnimation, KeysBeforeTimeZeroShapeTheCurvesAfterIt) {
  // At time 0 half way from key 0 to key 1; before the first key, what the first key says.
  Gltf gltf;
  gltf.animate(0, "translation", "LINEAR", {-1, 1, 2}, {0, 0, 0, 4, 0, 0, 4, 8, 0});
  const AnimatedScene scene = readOf(gltf.file(), 1e-9);
  const auto& body = scene.bodies.at(0);
  ASSERT_EQ(body.runs.size(), 1U);
  ASSERT_EQ(body.runs[0]->count(), 3U);
  EXPECT_EQ(body.runs[0]->time(0), 0);
  EXPECT_EQ(body.runs[0]->time(1), 1);
  EXPECT_EQ(positionsAt(body, 0)[0], Point3(1 + 2, 1, 1));
  EXPECT_EQ(positionsAt(body, 1)[0], Point3(1 + 4, 1, 1));
  EXPECT_EQ(scene.notices,
            std::vector<std::string>{"1 key is before time 0, where the animation begins"});
}

TEST(GltfAnimation, JumpsBeforeTimeZeroAreOver) {
  Gltf gltf;
  gltf.animate(0, "translation", "STEP", {-2, -1, 0, 1}, {9, 9, 9, 8, 8, 8, 1, 0, 0, 2, 0, 0});
  gltf.animate(0, "scale", "LINEAR", {-3, -2, 2}, {-1, -1, -1, 1, 1, 1, 1, 1, 1});
  const AnimatedScene scene = readOf(gltf.file(), 1e-9);
  const auto& body = scene.bodies.at(0);
  ASSERT_EQ(body.runs.size(), 2U);
  EXPECT_EQ(body.runs[0]->time(0), 0);
  EXPECT_EQ(body.runs[0]->time(body.runs[0]->count() - 1), 1);
  EXPECT_EQ(positionsAt(body, 0)[0], Point3(2, 1, 1));
}

TEST(GltfAnimation, PointersToNodesMoveThemAsPathsDo) {
  Gltf paths;
  paths.animate(0, "translation", "LINEAR", {0, 2}, {0, 0, 0, 5, 0, 0});
  paths.animate(0, "rotation", "LINEAR", {0, 2}, {0, 0, 0, 1, 0, 0, kHalf, kHalf});
  Gltf pointers;
  pointers.animatePointer("/nodes/0/translation", "LINEAR", {0, 2}, {0, 0, 0, 5, 0, 0});
  pointers.animate(0, "rotation", "LINEAR", {0, 2}, {0, 0, 0, 1, 0, 0, kHalf, kHalf});
  pointers.more = R"(,"extensionsUsed":["KHR_animation_pointer"],)"
                  R"("extensionsRequired":["KHR_animation_pointer"])";
  const AnimatedScene expected = readOf(paths.file(), 0.01);
  const AnimatedScene scene = readOf(pointers.file(), 0.01);
  EXPECT_TRUE(scene.losses.empty());
  const auto& runs = scene.bodies.at(0).runs;
  ASSERT_EQ(runs[0]->count(), expected.bodies[0].runs[0]->count());
  for (std::uint64_t key = 0; key < runs[0]->count(); ++key) {
    EXPECT_EQ(positionsAt(scene.bodies[0], key), positionsAt(expected.bodies[0], key));
  }
}

TEST(GltfAnimation, PointersToAnythingElseAreLostMotion) {
  Gltf gltf;
  gltf.animate(0, "translation", "LINEAR", {0, 2}, {0, 0, 0, 5, 0, 0});
  gltf.animatePointer("/materials/0/emissiveFactor", "LINEAR", {0, 2}, {0, 0, 0, 5, 0, 0});
  EXPECT_EQ(readOf(gltf.file(), 0.01).losses,
            std::vector<std::string>{
                "the animation of /materials/0/emissiveFactor: it neither moves nodes nor morphs"});
  Gltf alone;
  alone.animatePointer("/materials/0/emissiveFactor", "LINEAR", {0, 2}, {0, 0, 0, 5, 0, 0});
  const auto nothing = readGltfAnimation(alone.file(), {});
  ASSERT_FALSE(nothing);
  EXPECT_EQ(nothing.error().message,
            "has no key after time 0 that moves a node of the scene, so nothing moves; what moves "
            "is not read: /materials/0/emissiveFactor");
  EXPECT_EQ(nothing.error().remedy, Remedy::GiveMotion);
}

/// The text with two animations before `go`: of one sampler, for two seconds.
InputFile withAnimationsBefore(Gltf& gltf, const char* targetOfRun, const char* targetOf1) {
  InputFile file = gltf.file();
  const std::string go = R"("animations":[)";
  const char* animation =
      R"({{{}"samplers":[{{"input":0,"output":1}}],"channels":[{{"sampler":0,"target":{}}}]}},)";
  file.bytes.insert(file.bytes.find(go) + go.size(),
                    fmt::format(fmt::runtime(animation), R"("name":"run",)", targetOfRun) +
                        fmt::format(fmt::runtime(animation), "", targetOf1));
  return file;
}

/// The x coordinate of the first vertex at the last key.
double xAtEnd(const AnimatedBody& body) {
  return positionsAt(body, body.runs.at(0)->count() - 1)[0].x();
}

TEST(GltfAnimation, OneOfSeveralIsReadOrAllTogether) {
  Gltf gltf;
  gltf.nodes = R"({"name":"body","mesh":0},{"mesh":0},{"mesh":0})";
  gltf.animate(0, "translation", "LINEAR", {0, 2}, {0, 0, 0, 5, 0, 0});
  gltf.animate(0, "scale", "LINEAR", {0, 1}, {1, 1, 1, 2, 2, 2});
  const InputFile file = withAnimationsBefore(gltf, R"({"node":1,"path":"translation"})",
                                              R"({"node":1,"path":"translation"})");
  const auto endOf = [&](const char* animation, std::size_t body) {
    const auto scene = readGltfAnimation(file, {animation, "", 0.1});
    EXPECT_TRUE(scene) << scene.error().text();
    return std::pair(scene->otherAnimations, xAtEnd(scene->bodies.at(body)));
  };
  using Names = std::vector<std::string>;
  EXPECT_EQ(endOf("go", 0), std::pair(Names({"'run'", "1"}), 7.0));
  EXPECT_EQ(endOf("", 1), std::pair(Names({"1", "'go'"}), 6.0));
  EXPECT_EQ(endOf("1", 0), std::pair(Names({"'run'", "'go'"}), 1.0));
  const auto error = readGltfAnimation(file, {"all", "", 0.1});
  ASSERT_FALSE(error);
  EXPECT_EQ(textOf(error.error(), file.path),
            "a.gltf: animations[1].channels[0]: moves the translation of node 1, as another "
            "animation that is read does");
  Gltf again = gltf;
  const auto all =
      readGltfAnimation(withAnimationsBefore(again, R"({"node":1,"path":"translation"})",
                                             R"({"node":2,"path":"translation"})"),
                        {"all", "", 0.1});
  ASSERT_TRUE(all) << all.error().text();
  EXPECT_TRUE(all->otherAnimations.empty());
  EXPECT_EQ(xAtEnd(all->bodies.at(0)), 7);
  EXPECT_EQ(xAtEnd(all->bodies.at(1)), 6);
  EXPECT_EQ(xAtEnd(all->bodies.at(2)), 6);
}

TEST(GltfAnimation, BodiesHaveTheMaterialsOfTheirTriangles) {
  Gltf gltf;
  gltf.animate(0, "translation", "LINEAR", {0, 1}, {0, 0, 0, 1, 0, 0});
  gltf.more = R"(,"materials":[{"name":"unused"},{"name":"fur"}])";
  const AnimatedScene scene = readOf(gltf.file(R"(},"mode":5,"material":1)"), 1);
  const model::TriangleMesh& mesh = scene.bodies.at(0).mesh;
  ASSERT_EQ(mesh.attributes.size(), 1U);
  EXPECT_EQ(mesh.attributes[0],
            model::makeAttribute("material", model::Domain::Cell,
                                 std::vector<std::uint32_t>(mesh.triangles.size(), 1)));
  EXPECT_EQ(scene.materials, (std::vector<std::string>{"", "fur"}));
}

TEST(GltfAnimation, WhatIsNoAnimationIsRefused) {
  const auto errorOf = [](Gltf gltf, const GltfAnimationOptions& options = {}) {
    const auto scene = readGltfAnimation(gltf.file(), options);
    if (scene) return std::string("(was accepted)");
    std::string text = scene.error().text();
    return text.substr(text.find("a.gltf"));
  };
  Gltf gltf;
  gltf.animate(0, "translation", "LINEAR", {0, 2, 1}, std::vector<double>(9, 0));
  EXPECT_EQ(errorOf(gltf),
            "a.gltf: animations[0].samplers[0]: key 2 is at time 1, not after the key before it, "
            "at 2");
  gltf = {};
  gltf.animate(0, "translation", "LINEAR", {0}, {0, 0, 0});
  EXPECT_EQ(errorOf(gltf),
            "a.gltf: animations[0]: has no key after time 0 that moves a node of the scene, so "
            "nothing moves");
  gltf = {};
  gltf.animate(7, "translation", "LINEAR", {0, 1}, {0, 0, 0, 1, 0, 0});
  EXPECT_TRUE(errorOf(gltf).starts_with(
      "a.gltf: animations[0].channels[0]: moves node 7, which does not exist; there are "));
  gltf = {};
  gltf.animate(0, "rotation", "LINEAR", {0, 1}, {0, 0, 0, 1, 0, 0, 0, 0});
  EXPECT_EQ(errorOf(gltf),
            "a.gltf: animations[0].samplers[0]: key 1 is a quaternion of length 0, "
            "expected 1");
  gltf = {};
  gltf.animate(0, "rotation", "CUBICSPLINE", {0, 1},
               {0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, -1, 0, 0, 0, 0});
  EXPECT_NE(errorOf(gltf).find("a rotation passes through zero"), std::string::npos)
      << errorOf(gltf);
  EXPECT_EQ(errorOf(gltf, {"", "none", {}}), "a.gltf: has no scene 'none'; it has none");
  EXPECT_EQ(errorOf(gltf, {"run", "", {}}), "a.gltf: has no animation 'run'; it has 'go'");
  gltf = {};
  gltf.animate(0, "weights", "LINEAR", {0, 1}, {0, 1});
  EXPECT_NE(errorOf(gltf).find("whose mesh has no morph targets"), std::string::npos);
}

}  // namespace
}  // namespace t4d::formats
