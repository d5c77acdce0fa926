#include "t4d/formats/usd/usd_animation.h"

#include "t4d/formats/test_files.h"
#include "t4d/formats/triangle/triangle_mesh_writer.h"
#include "t4d/formats/usd/usd_shape.h"

namespace t4d::formats {
namespace {

constexpr const char* kHead =
    "#usda 1.0\n(\n    metersPerUnit = 0.001\n    upAxis = \"Z\"\n    timeCodesPerSecond = 10\n)\n";

/// A cube from 0 to 1 of quads.
const std::string kCube =
    "int[] faceVertexCounts = [4, 4, 4, 4, 4, 4]\n"
    "int[] faceVertexIndices = [0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, "
    "7, 5]\n"
    "uniform token subdivisionScheme = \"none\"\n";
const std::string kCorners =
    "[(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0), (0, 0, 1), (1, 0, 1), (0, 1, 1), (1, 1, 1)]";

std::string inMesh(const std::string& body) {
  return kHead + ("def Mesh \"cube\"\n{\n" + kCube + body + "}\n");
}
std::string movedCube(const std::string& ops) {
  return inMesh("point3f[] points = " + kCorners + "\n" + ops);
}

Result<AnimatedScene> readText(const std::string& text, double tolerance = 1e-3,
                               double edgeFactor = 0) {
  return readUsdAnimation({temporaryPath("scene.usda"), text}, {"", "", tolerance, edgeFactor});
}

AnimatedScene sceneOf(const std::string& text, double tolerance = 1e-3) {
  auto scene = readText(text, tolerance);
  EXPECT_TRUE(scene) << scene.error().text() << "\n" << text;
  return scene ? std::move(*scene) : AnimatedScene{};
}

std::string refusalOf(const std::string& text) {
  const auto scene = readText(text);
  return scene ? "(was accepted)" : textOf(scene.error(), temporaryPath("scene.usda"));
}

std::vector<model::Point3> verticesAt(const AnimatedBody& body, std::uint64_t key,
                                      std::size_t run = 0) {
  std::vector<model::Point3> points(body.mesh.vertices.size());
  EXPECT_TRUE(body.runs[run]->positions(key, points));
  return points;
}

void expectNear(const model::Point3& found, const model::Point3& expected, double off = 1e-12) {
  EXPECT_LE((found - expected).norm(), off) << found.transpose() << " and " << expected.transpose();
}

TEST(UsdAnimation, ReadsPointsAtTheirSamples) {
  const AnimatedScene scene = sceneOf(inMesh(
      "point3f[] points.timeSamples = {\n 5: [(0, 0, 0), (0.1, 0, 0), (0, 1, 0), (1, 1, 0), (0, 0, "
      "1), (1, 0, 1), (0, 1, 1), (1, 1, 1)], # the first\n 20: " +
      kCorners + " }\n"));
  ASSERT_EQ(scene.bodies.size(), 1U);
  EXPECT_EQ(scene.bodies[0].name, "cube");
  EXPECT_EQ(scene.lengthUnit, "mm");
  EXPECT_EQ(scene.up, "z");
  EXPECT_EQ(scene.bodies[0].mesh.triangles.size(), 12U);
  const model::VertexKeys& run = *scene.bodies[0].runs.at(0);
  ASSERT_EQ(run.count(), 2U);
  EXPECT_EQ(run.time(0), 0.5);
  EXPECT_EQ(run.time(1), 2.0);
  EXPECT_FALSE(run.pose(0));
  EXPECT_EQ(verticesAt(scene.bodies[0], 0)[1], model::Point3(0.1F, 0, 0))
      << "float32, as USD has it";
  EXPECT_EQ(verticesAt(scene.bodies[0], 1)[1], model::Point3(1, 0, 0));
}

TEST(UsdAnimation, AppliesOpsInTheirOrder) {
  // x is turned first: (1, 0, 0) -> (0, 0, -1) by y, (0, 1, 0) -> (0, 0, 1) by x, and so on.
  const struct {
    const char* ops;
    model::Point3 of100;
    model::Point3 of010;
  } cases[] = {
      {"double3 xformOp:translate.timeSamples = { 0: (0, 0, 0), 10: (1, 2, 3) }\n"
       "uniform token[] xformOpOrder = [\"xformOp:translate\"]\n",
       {2, 2, 3},
       {1, 3, 3}},
      {"float3 xformOp:rotateXYZ.timeSamples = { 0: (0, 0, 0), 10: (90, 90, 0) }\n"
       "uniform token[] xformOpOrder = [\"xformOp:rotateXYZ\"]\n",
       {0, 0, -1},
       {1, 0, 0}},
      {"float3 xformOp:rotateYXZ.timeSamples = { 0: (0, 0, 0), 10: (90, 90, 0) }\n"
       "uniform token[] xformOpOrder = [\"xformOp:rotateYXZ\"]\n",
       {0, 1, 0},
       {0, 0, 1}},
      {"float xformOp:rotateZ.timeSamples = { 0: 0, 10: 90 }\n"
       "double3 xformOp:translate:pivot = (1, 0, 0)\n"
       "uniform token[] xformOpOrder = [\"xformOp:translate:pivot\", \"xformOp:rotateZ\", "
       "\"!invert!xformOp:translate:pivot\"]\n",
       {1, 0, 0},
       {0, -1, 0}},
      {"quatf xformOp:orient.timeSamples = { 0: (1, 0, 0, 0), 10: (0.70710678, 0, 0, 0.70710678) "
       "}\n"
       "float3 xformOp:scale = (2, 3, 1)\n"
       "uniform token[] xformOpOrder = [\"xformOp:orient\", \"xformOp:scale\"]\n",
       {0, 2, 0},
       {-3, 0, 0}},
      {"matrix4d xformOp:transform.timeSamples = { 0: ( (1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), "
       "(0, 0, 0, 1) ), 10: ( (0, 1, 0, 0), (-1, 0, 0, 0), (0, 0, 1, 0), (5, 6, 7, 1) ) }\n"
       "uniform token[] xformOpOrder = [\"xformOp:transform\"]\n",
       {5, 7, 7},
       {4, 6, 7}},
  };
  for (const auto& [ops, of100, of010] : cases) {
    const AnimatedScene scene = sceneOf(movedCube(ops));
    ASSERT_EQ(scene.bodies.size(), 1U) << ops;
    const std::uint64_t last = scene.bodies[0].runs.at(0)->count() - 1;
    EXPECT_TRUE(scene.bodies[0].runs[0]->pose(last)) << ops;
    const auto points = verticesAt(scene.bodies[0], last);
    expectNear(points[1], of100, 1e-7);
    expectNear(points[2], of010, 1e-7);
  }
}

TEST(UsdAnimation, StaysWithinTheTolerance) {
  const std::string text =
      kHead + std::string("def Xform \"arm\"\n{\n") +
      "float3 xformOp:rotateXYZ.timeSamples = { 0: (0, 0, 0), 10: (400, 30, "
      "-200), 15: (0, 0, 0) }\n"
      "double3 xformOp:translate.timeSamples = { 3: (0, 0, 0), 8: (4, 5, 6) }\n"
      "uniform token[] xformOpOrder = [\"xformOp:rotateXYZ\", "
      "\"xformOp:translate\"]\n"
      "def Mesh \"cube\"\n{\n" +
      kCube + "point3f[] points.timeSamples = { 0: " + kCorners +
      ", 12: [(0, 0, 0), (2, 0, 0), (0, 1, 0), (1, 1, 0), (0, 0, 3), (1, 0, "
      "1), (0, 1, 1), (1, 1, 1)] }\n"
      "quatd xformOp:orient.timeSamples = { 0: (1, 0, 0, 0), 9: (0.6, 0, 0.8, "
      "0) }\nuniform token[] xformOpOrder = [\"xformOp:orient\"]\n}\n}\n";
  const auto usd = readUsdScene({temporaryPath("scene.usda"), text});
  ASSERT_TRUE(usd) << usd.error().text();
  LoadedMesh loaded;
  const auto shape = UsdShape::read(*usd, usd->meshes.at(0), UsdShape::When::Played, loaded);
  ASSERT_TRUE(shape) << shape.error().text();
  for (const double tolerance : {0.1, 0.001}) {
    const AnimatedScene scene = sceneOf(text, tolerance);
    const model::VertexKeys& run = *scene.bodies.at(0).runs.at(0);
    double farthest = 0;
    std::vector<model::Point3> true_(8);
    for (std::uint64_t key = 0; key + 1 < run.count(); ++key) {
      const auto from = verticesAt(scene.bodies[0], key);
      const auto to = verticesAt(scene.bodies[0], key + 1);
      for (const double s : {0.25, 0.5, 0.75}) {
        (*shape)->place(run.time(key) + s * (run.time(key + 1) - run.time(key)), false, true_);
        for (std::size_t i = 0; i < 8; ++i) {
          farthest = std::max(farthest, (from[i] + s * (to[i] - from[i]) - true_[i]).norm());
        }
      }
    }
    EXPECT_LE(farthest, tolerance);
    EXPECT_GT(farthest, tolerance / 50);
  }
}

TEST(UsdAnimation, LeavesOutBodiesWhileTheyAreInvisible) {
  const AnimatedScene scene =
      sceneOf(kHead + std::string("def Xform \"a\" (displayName = \"a \\\"name\\\"\")\n{\n") +
              "token visibility.timeSamples = { 0: \"inherited\", 4: \"invisible\", 6: "
              "\"inherited\", 10: \"inherited\" }\n"
              "def Mesh \"cube\" (displayName = \"a \\\"name\\\"\")\n{\n" +
              kCube + "point3f[] points = " + kCorners + "\n}\n}\n");
  ASSERT_EQ(scene.bodies.size(), 1U);
  EXPECT_EQ(scene.bodies[0].name, "a \"name\"");
  ASSERT_EQ(scene.bodies[0].runs.size(), 2U);
  EXPECT_EQ(scene.bodies[0].runs[0]->time(1), 0.4);
  EXPECT_EQ(scene.bodies[0].runs[1]->time(0), 0.6);
  EXPECT_EQ(scene.bodies[0].runs[1]->time(1), 1.0);
}

TEST(UsdAnimation, MirrorsWhatItsTransformMirrors) {
  const AnimatedScene scene = sceneOf(
      movedCube("float3 xformOp:scale = (-2, 1, 1)\n"
                "double3 xformOp:translate.timeSamples = { 0: (0, 0, 0), 10: (1, 0, 0) }\n"
                "uniform token[] xformOpOrder = [\"xformOp:translate\", \"xformOp:scale\"]\n"));
  model::TriangleMesh mesh = scene.bodies.at(0).mesh;
  mesh.vertices = verticesAt(scene.bodies[0], 1);
  EXPECT_NEAR(model::signedVolume(mesh), 2, 1e-12);
  EXPECT_NEAR(model::boundsOf(mesh).min.x(), -1, 1e-12);
  EXPECT_GT(scene.bodies[0].runs[0]->pose(0)->leftCols<3>().determinant(), 0);
  const AnimatedScene left =
      sceneOf(movedCube("uniform token orientation = \"leftHanded\"\n"
                        "double3 xformOp:translate.timeSamples = { 0: (0, 0, 0), 10: (1, 0, 0) }\n"
                        "uniform token[] xformOpOrder = [\"xformOp:translate\"]\n"));
  EXPECT_NEAR(model::signedVolume(left.bodies.at(0).mesh), -1, 1e-12);
}

TEST(UsdAnimation, PlaysWhatTheStageSays) {
  std::string text = movedCube(
      "double3 xformOp:translate.timeSamples = { 0: (0, 0, 0), 10: (1, 0, 0) }\n"
      "uniform token[] xformOpOrder = [\"xformOp:translate\"]\n");
  text.insert(text.find("    upAxis"), "    startTimeCode = 5\n    endTimeCode = 20\n");
  const AnimatedScene scene = sceneOf(text);
  const model::VertexKeys& run = *scene.bodies.at(0).runs.at(0);
  EXPECT_EQ(run.count(), 3U);
  EXPECT_EQ(run.time(0), 0.5);
  EXPECT_EQ(run.time(1), 1.0);
  EXPECT_EQ(run.time(2), 2.0);
  expectNear(verticesAt(scene.bodies[0], 0)[0], {0.5, 0, 0});
  expectNear(verticesAt(scene.bodies[0], 2)[0], {1, 0, 0});
}

TEST(UsdAnimation, ListsWhatItDoesNotRead) {
  std::string text = movedCube(
      "normal3f[] normals = [(0, 0, 1)]\n"
      "color3f[] primvars:displayColor = [(1, 0, 0)] (interpolation = \"constant\")\n"
      "vector3f[] velocities = []\nfloat3[] extent = []\n"
      "double3 xformOp:translate.timeSamples = { 0: (0, 0, 0), 10: (1, 0, 0) }\n"
      "uniform token[] xformOpOrder = [\"xformOp:translate\"]\n");
  text +=
      "def Sphere \"ball\" { }\ndef Scope \"looks\" { def Material \"red\" { } }\n"
      "class \"_c\" { def Cone \"c\" { } }\nover \"elsewhere\" { }\n"
      "def Mesh \"off\" (active = false) { }\n"
      "def Mesh \"proxy\" { uniform token purpose = \"proxy\" }\n";
  const AnimatedScene scene = sceneOf(text);
  EXPECT_EQ(scene.bodies.size(), 1U);
  EXPECT_EQ(scene.losses,
            (std::vector<std::string>{"1 Material, 1 Sphere: only prims of the type Mesh are read",
                                      "displayColor, normals: only points and faces are read"}));
  EXPECT_EQ(scene.notices,
            std::vector<std::string>{"left out 1 prim whose purpose is guide or proxy"});
}

TEST(UsdAnimation, OtherThanTextOfOneLayerIsRefused) {
  EXPECT_EQ(refusalOf("PXR-USDC\0\0\0"),
            "scene.usda: is binary USD of which only text is read; `usdcat --flatten IN.usd -o "
            "OUT.usda` converts it");
  EXPECT_EQ(refusalOf("v 0 0 0\n"), "scene.usda: begins with 'v 0 0 0?', expected #usda");
  EXPECT_EQ(refusalOf("#usda 1.0\n(subLayers = [@a.usda@])\n"),
            "scene.usda:2: the stage has subLayers, which are not read; `usdcat --flatten IN.usd "
            "-o OUT.usda` writes one text with all that they say");
  for (const std::string field :
       {"references = @a.usda@</A> (offset = 1)", "payload = [@a.usda@]", "prepend inherits = </c>",
        "prepend variantSets = \"v\"", "clips = { dictionary default = { } }"}) {
    const std::string why = refusalOf("#usda 1.0\ndef Xform \"a\" (\n    " + field + "\n)\n{ }\n");
    EXPECT_EQ(why.substr(0, 30), "scene.usda:3: prim 'a' has " + why.substr(27, 3)) << why;
    EXPECT_NE(why.find("usdcat --flatten"), why.npos) << why;
  }
  EXPECT_NE(refusalOf("#usda 1.0\ndef Mesh \"a\" { rel skel:skeleton = </s> }\n").find("skeleton"),
            std::string::npos);
  EXPECT_NE(refusalOf("#usda 1.0\ndef PointInstancer \"a\" { }\n").find("PointInstancer"),
            std::string::npos);
}

TEST(UsdAnimation, WhatDoesNotMoveOrChangesItsFacesIsRefused) {
  EXPECT_EQ(refusalOf(movedCube("")),
            "scene.usda: has no animation: nothing has time samples at two times");
  EXPECT_EQ(refusalOf("#usda 1.0\ndef Xform \"a\" { }\n"), "scene.usda: holds no Mesh prim");
  EXPECT_EQ(
      refusalOf(kHead +
                std::string("def Mesh \"m\"\n{\nint[] faceVertexCounts = [3]\n"
                            "int[] faceVertexIndices.timeSamples = {\n0: [0, 1, 2],\n1: [0, "
                            "2, 1] }\npoint3f[] points.timeSamples = { 0: [(0,0,0), "
                            "(1,0,0), (0,1,0)], 1: [] }\n}\n")),
      "scene.usda:12: the faces of Mesh 'm' change at time code 1: a solid that is swept keeps its "
      "faces. Meshes of single frames can be woven");
  EXPECT_EQ(refusalOf(inMesh("point3f[] points.timeSamples = { 0: " + kCorners +
                             ",\n1: [(0, 0, 0)] }\n")),
            "scene.usda:13: 1 points, and 8 in the first sample");
  const std::string shrinking =
      "float3 xformOp:scale.timeSamples = { 0: (1, 1, 1), 10: (-1, 1, 1) }\n"
      "uniform token[] xformOpOrder = [\"xformOp:scale\"]\n";
  EXPECT_EQ(
      refusalOf(movedCube(shrinking)),
      "scene.usda:7: the transform of Mesh 'cube' shrinks to nothing, or turns inside out, by "
      "time 1 s");
}

TEST(UsdAnimation, TextThatIsNoUsdIsRefusedWhereItIs) {
  const struct {
    const char* body;
    const char* message;
  } cases[] = {
      {"point3f[] points = [(0, 0, 0)", "expected ']'"},
      {"point3f[] points = [(0, 0)]\nint[] holeIndices = []\n", "expected 3 numbers before this"},
      {"point3f[] points = [(0, 0, zero)]\n", "found 'zero)]', expected a number"},
      {"point3f[] points = [(0, 0, inf)]\n", "expected finite coordinates"},
      {"point3f[] points = [(0, 0, 1e40)]\n", "expected finite coordinates"},
      {"point3f[] points.timeSamples = { 0: [], 0: [] }\n", "a second sample at time code 0"},
      {"point3f[] points.timeSamples = { x: [] }\n", "expected a time code"},
      {"point3f[] points = [(0, 0, 0)]]\n", "expected"},
      {"point3f[] points = \n", "expected a value"},
      {"string doc = \"no end\n", "expected a string that ends"},
      {"uniform token[] xformOpOrder = [\"xformOp:roll\"]\ndouble xformOp:roll = 1\n",
       "is not an op that is known"},
      {"uniform token[] xformOpOrder = [\"xformOp:scale\"]\n", "is not there"},
      {"float3 xformOp:scale.spline = { bezier }\nuniform token[] xformOpOrder = "
       "[\"xformOp:scale\"]\n",
       "is a spline"},
      {"matrix4d xformOp:transform = ((1,0,0,1),(0,1,0,0),(0,0,1,0),(0,0,0,1))\nuniform token[] "
       "xformOpOrder = [\"xformOp:transform\"]\n",
       "is not affine"},
      {"quatf xformOp:orient = (0, 0, 0, 0)\nuniform token[] xformOpOrder = [\"xformOp:orient\"]\n",
       "quaternion of length 0"},
      {"", "has no points"},
      {"int[] holeIndices = [1]\n", "holes"},
      {"def Xform \"a\" {", "the text ends"},
  };
  for (const auto& [body, message] : cases) {
    std::string text = inMesh(body);
    text.insert(text.find("    upAxis"), "    startTimeCode = 0\n    endTimeCode = 1\n");
    // Something that moves.
    text += "def Mesh \"other\" {\n" + kCube + "point3f[] points.timeSamples = { 0: " + kCorners +
            ", 1: " + kCorners + "} }\n";
    const std::string why = refusalOf(text);
    EXPECT_EQ(why.substr(0, 11), "scene.usda:") << why << " of " << body;
    EXPECT_NE(why.find(message), why.npos) << why << " of " << body;
  }
  const std::string deep = "#usda 1.0\n" + std::string(100'000, '(');
  EXPECT_NE(refusalOf(deep).find("scene.usda:2: "), std::string::npos);
  std::string nested = "#usda 1.0\n";
  for (int i = 0; i < 10'000; ++i) nested += "def \"a\" {";
  EXPECT_NE(refusalOf(nested).find("not nested as deep"), std::string::npos);
}

TEST(UsdPackage, DamagedOnesAreRefused) {
  const auto path = temporaryPath("whole.usdz");
  const std::string cube = movedCube(
      "double3 xformOp:translate.timeSamples = { 0: (0, 0, 0), 10: (1, 0, 0) }\n"
      "uniform token[] xformOpOrder = [\"xformOp:translate\"]\n");
  NamedMesh named{"box", readBytes("cube.usda", cube).mesh};
  ASSERT_TRUE(writeTriangleMeshes(path, std::vector{named}));
  const std::string bytes = system::contents(path);
  for (std::size_t length = 1; length < bytes.size(); ++length) {
    if (length > 200 && length + 200 < bytes.size()) continue;
    EXPECT_NE(errorOf("cut.usdz", bytes.substr(0, length)), "(was accepted)") << length;
  }
  std::string packed = bytes;
  packed[packed.rfind("PK\x01\x02") + 10] = 8;
  EXPECT_NE(errorOf("packed.usdz", packed).find("compressed"), std::string::npos);
  std::string binary = bytes;
  binary.replace(binary.find("#usda 1.0"), 8, "PXR-USDC");
  EXPECT_EQ(errorOf("binary.usdz", binary),
            "binary.usdz: is binary USD, 't4d.usda', of which only text is read; `usdcat --flatten "
            "IN.usd -o OUT.usda` converts it");
}

}  // namespace
}  // namespace t4d::formats
