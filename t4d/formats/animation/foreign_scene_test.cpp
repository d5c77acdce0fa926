#include "t4d/formats/animation/foreign_scene.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "t4d/formats/gltf/gltf_animation.h"
#include "t4d/formats/gltf/gltf_reader.h"
#include "t4d/formats/test_files.h"
#include "t4d/model/triangle_mesh.h"

namespace t4d::formats {
namespace {

using model::Point3;

constexpr const char* kBoxCorners = "0 0 0 2 0 0 0 3 0 2 3 0 0 0 4 2 0 4 0 3 4 2 3 4";

/// A COLLADA source of numbers or names.
std::string source(const std::string& id, const std::string& values, int count, int width,
                   const char* type = "float") {
  const bool names = std::string(type) == "name";
  const char* array = names ? "Name_array" : "float_array";
  std::string parameters;
  for (int i = 0; i < (width == 16 ? 1 : width); ++i) {
    parameters += fmt::format(R"(<param name="{}" type="{}"/>)",
                              width == 3 ? std::string(1, static_cast<char>('X' + i)) : "A",
                              width == 16 ? "float4x4" : type);
  }
  return fmt::format(
      R"(<source id="{0}"><{1} id="{0}-array" count="{2}">{3}</{1}><technique_common>)"
      R"(<accessor source="#{0}-array" count="{4}" stride="{5}">{6}</accessor>)"
      R"(</technique_common></source>)",
      id, array, count * width, values, count, width, parameters);
}

std::string animation(const std::string& id, const std::string& times, const std::string& values,
                      const std::string& target) {
  const auto count = static_cast<int>(1 + std::ranges::count(times, ' '));
  std::string linear = "LINEAR";
  for (int i = 1; i < count; ++i) linear += " LINEAR";
  return fmt::format(
      R"(<animation id="{0}">{1}{2}{3}<sampler id="{0}-s">)"
      R"(<input semantic="INPUT" source="#{0}-t"/><input semantic="OUTPUT" source="#{0}-v"/>)"
      R"(<input semantic="INTERPOLATION" source="#{0}-i"/></sampler>)"
      R"(<channel source="#{0}-s" target="{4}"/></animation>)",
      id, source(id + "-t", times, count, 1), source(id + "-v", values, count, 1),
      source(id + "-i", linear, count, 1, "name"), target);
}

/// A box of 2 x 3 x 4 cm, z up, in a scene with these nodes.
struct Collada {
  std::string nodes =
      R"(<node id="parent" name="parent"><translate sid="at">100 0 0</translate>)"
      R"(<node id="box" name="box"><translate sid="at">0 5 7</translate>)"
      R"(<rotate sid="turn">0 0 1 0</rotate><instance_geometry url="#g"/></node></node>)";
  std::string animations = animation("x", "0 1 2 4", "0 3 6 6", "box/at.X") +
                           animation("r", "0 1 2 4", "0 0 90 180", "box/turn.ANGLE");
  std::string controllers;
  std::string up = "Z_UP";
  std::string metres = "0.01";

  InputFile file() const {
    const std::string text = fmt::format(
        R"(<?xml version="1.0" encoding="utf-8"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><created>2020-01-01T00:00:00</created><modified>2020-01-01T00:00:00</modified>
<unit name="u" meter="{}"/><up_axis>{}</up_axis></asset>
<library_geometries><geometry id="g" name="g"><mesh>{}
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<polylist count="6"><input semantic="VERTEX" source="#v" offset="0"/><vcount>4 4 4 4 4 4</vcount>
<p>0 2 3 1 4 5 7 6 0 1 5 4 2 6 7 3 0 4 6 2 1 3 7 5</p></polylist></mesh></geometry>
</library_geometries>{}
<library_animations>{}</library_animations>
<library_visual_scenes><visual_scene id="s" name="s">{}</visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>)",
        metres, up, source("p", kBoxCorners, 8, 3), controllers, animations, nodes);
    return {"box.dae", text};
  }
};

/// The box and its motion as FBX, in units of `centimetres`.
InputFile fbx(const std::string& axes, double centimetres) {
  const auto curve = [](int id, const char* values) {
    return fmt::format(
        "AnimationCurve: {}, \"AnimCurve::\", \"\" {{\nKeyVer: 4009\nKeyTime: *4 {{\n"
        "a: 0,46186158000,92372316000,184744632000\n}}\nKeyValueFloat: *4 {{\na: {}\n}}\n"
        "KeyAttrFlags: *1 {{\na: 4\n}}\nKeyAttrDataFloat: *4 {{\na: 0,0,0,0\n}}\n"
        "KeyAttrRefCount: *1 {{\na: 4\n}}\n}}\n",
        id, values);
  };
  const auto node = [](int id, const char* kind, const char* rest) {
    return fmt::format(
        "AnimationCurveNode: {}, \"AnimCurveNode::{}\", \"\" {{\nProperties70: {{\n{}}}\n}}\n", id,
        kind, rest);
  };
  std::string corners = kBoxCorners;
  std::ranges::replace(corners, ' ', ',');
  const std::string text =
      "; FBX 7.4.0 project file\nFBXHeaderExtension: {\nFBXHeaderVersion: 1003\nFBXVersion: "
      "7400\n}\nGlobalSettings: {\nVersion: 1000\nProperties70: {\n" +
      axes +
      fmt::format("P: \"UnitScaleFactor\", \"double\", \"Number\", \"\", {}\n", centimetres) +
      "P: \"TimeMode\", \"enum\", \"\", \"\", 11\n}\n}\nObjects: {\nGeometry: 11, \"Geometry::\", "
      "\"Mesh\" {\nVertices: *24 {\na: " +
      corners +
      "\n}\nPolygonVertexIndex: *24 {\n"
      "a: 0,2,3,-2,4,5,7,-7,0,1,5,-5,2,6,7,-4,0,4,6,-3,1,3,7,-6\n}\n}\n"
      "Model: 12, \"Model::parent\", \"Null\" {\nVersion: 232\nProperties70: {\n"
      "P: \"Lcl Translation\", \"Lcl Translation\", \"\", \"A\", 100,0,0\n}\n}\n"
      "Model: 13, \"Model::box\", \"Mesh\" {\nVersion: 232\nProperties70: {\n"
      "P: \"Lcl Translation\", \"Lcl Translation\", \"\", \"A\", 0,5,7\n}\n}\n"
      "AnimationStack: 14, \"AnimStack::take\", \"\" {\nProperties70: {\n"
      "P: \"LocalStart\", \"KTime\", \"Time\", \"\", 0\n"
      "P: \"LocalStop\", \"KTime\", \"Time\", \"\", 184744632000\n}\n}\n"
      "AnimationLayer: 15, \"AnimLayer::\", \"\" {\n}\n" +
      node(16, "T",
           "P: \"d|X\", \"Number\", \"\", \"A\", 0\nP: \"d|Y\", \"Number\", \"\", \"A\", 5\n"
           "P: \"d|Z\", \"Number\", \"\", \"A\", 7\n") +
      node(17, "R",
           "P: \"d|X\", \"Number\", \"\", \"A\", 0\nP: \"d|Y\", \"Number\", \"\", \"A\", 0\n"
           "P: \"d|Z\", \"Number\", \"\", \"A\", 0\n") +
      curve(18, "0,3,6,6") + curve(19, "5,5,5,5") + curve(20, "7,7,7,7") + curve(21, "0,0,0,0") +
      curve(22, "0,0,0,0") + curve(23, "0,0,90,180") +
      "}\nConnections: {\nC: \"OO\", 12, 0\nC: \"OO\", 13, 12\nC: \"OO\", 11, 13\n"
      "C: \"OO\", 15, 14\nC: \"OO\", 16, 15\nC: \"OO\", 17, 15\n"
      "C: \"OP\", 16, 13, \"Lcl Translation\"\nC: \"OP\", 17, 13, \"Lcl Rotation\"\n"
      "C: \"OP\", 18, 16, \"d|X\"\nC: \"OP\", 19, 16, \"d|Y\"\nC: \"OP\", 20, 16, \"d|Z\"\n"
      "C: \"OP\", 21, 17, \"d|X\"\nC: \"OP\", 22, 17, \"d|Y\"\nC: \"OP\", 23, 17, \"d|Z\"\n}\n";
  return {"box.fbx", text};
}

std::string axisText(const char* name, int axis, int sign) {
  return fmt::format(
      "P: \"{0}\", \"int\", \"Integer\", \"\", {1}\n"
      "P: \"{0}Sign\", \"int\", \"Integer\", \"\", {2}\n",
      name, axis, sign);
}

Result<AnimatedScene> sceneOf(const InputFile& file) {
  auto converted = readForeignScene(file);
  if (!converted) return converted.error();
  EXPECT_TRUE(converted->losses.empty());
  return readGltfAnimation(converted->glb, {"", "", 1e-4});
}

std::string errorOf(const InputFile& file) {
  const auto scene = sceneOf(file);
  return scene ? "(was accepted)" : scene.error().text();
}

/// The bounds of a body at the layer at `time`, times 100.
model::Bounds3 boundsAt(const AnimatedBody& body, double time) {
  model::Bounds3 bounds;
  const auto& run = *body.runs.front();
  std::vector<Point3> positions(body.mesh.vertices.size());
  for (std::uint64_t key = 0; key < run.count(); ++key) {
    if (run.time(key) != time) continue;
    EXPECT_TRUE(run.positions(key, positions));
    for (const Point3& p : positions) bounds.add(100 * p);
  }
  return bounds;
}

void expectBounds(const model::Bounds3& bounds, const Point3& least, const Point3& most) {
  EXPECT_LT((bounds.min - least).norm(), 1e-4) << bounds.min.transpose();
  EXPECT_LT((bounds.max - most).norm(), 1e-4) << bounds.max.transpose();
}

void expectTheBox(const Result<AnimatedScene>& scene) {
  ASSERT_TRUE(scene) << scene.error().text();
  EXPECT_TRUE(scene->losses.empty());
  ASSERT_EQ(scene->bodies.size(), 1U);
  const AnimatedBody& body = scene->bodies.front();
  EXPECT_EQ(body.name, "box");
  EXPECT_EQ(body.mesh.vertices.size(), 8U);
  EXPECT_EQ(body.mesh.triangles.size(), 12U);
  EXPECT_TRUE(isClosed(body.mesh));
  EXPECT_GT(signedVolume(body.mesh), 0);
  ASSERT_EQ(body.runs.size(), 1U);
  EXPECT_EQ(body.runs[0]->time(0), 0);
  EXPECT_EQ(body.runs[0]->time(body.runs[0]->count() - 1), 4);
  // (x, y, z) with z up is (x, z, -y) with y up.
  expectBounds(boundsAt(body, 0), {100, 7, -8}, {102, 11, -5});
  expectBounds(boundsAt(body, 1), {103, 7, -8}, {105, 11, -5});
  expectBounds(boundsAt(body, 2), {103, 7, -7}, {106, 11, -5});
  expectBounds(boundsAt(body, 4), {104, 7, -5}, {106, 11, -2});
}

TEST(ForeignScene, ColladaIsWhereItsKeysUnitsAndAxesSay) {
  expectTheBox(sceneOf(Collada{}.file()));
  Collada metres;
  metres.up = "Y_UP";
  metres.metres = "1";
  const auto scene = sceneOf(metres.file());
  ASSERT_TRUE(scene) << scene.error().text();
  expectBounds(boundsAt(scene->bodies[0], 2), {10300, 500, 700}, {10600, 700, 1100});
}

TEST(ForeignScene, ColladaKeepsItsAxesIfTold) {
  for (const char* up : {"Y_UP", "Z_UP", "X_UP"}) {
    Collada still;
    still.animations = "";
    still.up = up;
    const auto scene = readForeignScene(still.file(), /*keepAxes=*/true);
    ASSERT_TRUE(scene) << scene.error().text();
    const auto read = readGltf(scene->glb);
    ASSERT_TRUE(read) << read.error().text();
    expectBounds(boundsOf(read->mesh), {1, 0.05, 0.07}, {1.02, 0.08, 0.11});
  }
}

TEST(ForeignScene, FbxIsWhereItsKeysUnitsAndAxesSay) {
  const std::string zUp =
      axisText("UpAxis", 2, 1) + axisText("FrontAxis", 1, -1) + axisText("CoordAxis", 0, 1);
  expectTheBox(sceneOf(fbx(zUp, 1)));
  const auto scene = sceneOf(fbx("", 100));
  ASSERT_TRUE(scene) << scene.error().text();
  expectBounds(boundsAt(scene->bodies[0], 2), {10300, 500, 700}, {10600, 700, 1100});
  EXPECT_NE(errorOf(fbx(axisText("UpAxis", 0, 1), 1)).find("its axes are not axes"),
            std::string::npos);
}

/// The box and its motion as FBX, z up, with other lines in place of those that begin and end the
/// take.
InputFile fbxWithTake(const std::string& start, const std::string& stop) {
  InputFile file =
      fbx(axisText("UpAxis", 2, 1) + axisText("FrontAxis", 1, -1) + axisText("CoordAxis", 0, 1), 1);
  for (const auto& [name, line] : {std::pair{"LocalStart", &start}, {"LocalStop", &stop}}) {
    const auto begin = file.bytes.find(std::string("P: \"") + name);
    file.bytes.replace(begin, file.bytes.find('\n', begin) + 1 - begin, *line);
  }
  return file;
}

/// In seconds.
std::string takeLine(const char* name, double seconds) {
  return fmt::format("P: \"{}\", \"KTime\", \"Time\", \"\", {}\n", name,
                     static_cast<std::int64_t>(seconds * 46186158000));
}

double lastTimeOf(const AnimatedBody& body) {
  return body.runs.front()->time(body.runs.front()->count() - 1);
}

TEST(ForeignScene, KeysOutsideATakeShapeItsCurves) {
  // From half way between the keys at 0 and 1 s to the one at 2 s; x goes from 0 over 3 to 6.
  const InputFile file = fbxWithTake(takeLine("LocalStart", 0.5), takeLine("LocalStop", 2));
  const auto converted = readForeignScene(file);
  ASSERT_TRUE(converted) << converted.error().text();
  EXPECT_EQ(converted->notices.front(), "animation 'take' begins at 0.5 s, which becomes time 0");
  const auto scene = sceneOf(file);
  ASSERT_TRUE(scene) << scene.error().text();
  const AnimatedBody& body = scene->bodies.at(0);
  EXPECT_EQ(lastTimeOf(body), 1.5);
  expectBounds(boundsAt(body, 0), {101.5, 7, -8}, {103.5, 11, -5});
  expectBounds(boundsAt(body, 0.5), {103, 7, -8}, {105, 11, -5});
  expectBounds(boundsAt(body, 1.5), {103, 7, -7}, {106, 11, -5});
  // A take from 0 on need not say so. It ends between keys, half way from x = 0 to x = 3.
  const auto early = sceneOf(fbxWithTake("", takeLine("LocalStop", 0.5)));
  ASSERT_TRUE(early) << early.error().text();
  EXPECT_EQ(lastTimeOf(early->bodies.at(0)), 0.5);
  expectBounds(boundsAt(early->bodies.at(0), 0.5), {101.5, 7, -8}, {103.5, 11, -5});
}

TEST(ForeignScene, AnFbxWithoutATakeBeginsAtItsFirstKey) {
  expectTheBox(sceneOf(fbxWithTake("", "")));
  expectTheBox(sceneOf(fbxWithTake(takeLine("LocalStart", 0), takeLine("LocalStop", 0))));
}

TEST(ForeignScene, KeysBeforeTimeZeroAreShifted) {
  Collada early;
  early.animations = animation("x", "-1 0 1 3", "0 3 6 6", "box/at.X") +
                     animation("r", "-1 0 1 3", "0 0 90 180", "box/turn.ANGLE");
  expectTheBox(sceneOf(early.file()));
  const auto converted = readForeignScene(early.file());
  ASSERT_TRUE(converted) << converted.error().text();
  ASSERT_EQ(converted->notices.size(), 1U);
  EXPECT_TRUE(converted->notices[0].ends_with("begins at -1 s, which becomes time 0"));
}

TEST(ForeignScene, IsReadAtRestAsATriangleMesh) {
  Collada collada;
  for (const InputFile& file : {collada.file(), fbxWithTake("", "")}) {
    const auto path = writeFile("rest" + file.path.extension().string(), file.bytes);
    const auto mesh = readTriangleMesh(path);
    ASSERT_TRUE(mesh) << mesh.error().text();
    expectBounds(boundsOf(mesh->mesh), {1, 0.07, -0.08}, {1.02, 0.11, -0.05});
    EXPECT_EQ(mesh->losses.front(), "the animation of 1 node: the mesh is as it is at rest");
  }
}

TEST(ForeignScene, SkinsFollowTheirBones) {
  Collada skinned;
  // The lower half hangs on one bone, the upper half on another, which rises by 6 and then turns.
  const std::string bind = "1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1 1 0 0 0 0 1 0 0 0 0 1 -4 0 0 0 1";
  skinned.controllers = fmt::format(
      R"(<library_controllers><controller id="c"><skin source="#g">)"
      R"(<bind_shape_matrix>1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1</bind_shape_matrix>{}{}{})"
      R"(<joints><input semantic="JOINT" source="#j"/>)"
      R"(<input semantic="INV_BIND_MATRIX" source="#b"/></joints>)"
      R"(<vertex_weights count="8"><input semantic="JOINT" source="#j" offset="0"/>)"
      R"(<input semantic="WEIGHT" source="#w" offset="1"/><vcount>1 1 1 1 1 1 1 1</vcount>)"
      R"(<v>0 0 0 0 0 0 0 0 1 0 1 0 1 0 1 0</v></vertex_weights></skin></controller>)"
      R"(</library_controllers>)",
      source("j", "low high", 2, 1, "name"), source("b", bind, 2, 16), source("w", "1", 1, 1));
  skinned.nodes =
      R"(<node id="low" sid="low" name="low" type="JOINT"><node id="high" sid="high" name="high" )"
      R"(type="JOINT"><translate sid="at">0 0 4</translate><rotate sid="turn">0 0 1 0</rotate>)"
      R"(</node></node><node id="body" name="body"><instance_controller url="#c">)"
      R"(<skeleton>#low</skeleton></instance_controller></node>)";
  skinned.animations = animation("z", "0 1 2", "4 10 10", "high/at.Z") +
                       animation("r", "0 1 2", "0 0 90", "high/turn.ANGLE");
  const auto scene = sceneOf(skinned.file());
  ASSERT_TRUE(scene) << scene.error().text();
  ASSERT_EQ(scene->bodies.size(), 1U);
  const AnimatedBody& body = scene->bodies.front();
  EXPECT_EQ(body.name, "body");
  expectBounds(boundsAt(body, 0), {0, 0, -3}, {2, 4, 0});
  expectBounds(boundsAt(body, 1), {0, 0, -3}, {2, 10, 0});
  // The upper half turns about z, from x in [0, 2] and y in [0, 3] to x in [-3, 0] and y in [0, 2].
  expectBounds(boundsAt(body, 2), {-3, 0, -3}, {2, 10, 0});
}

TEST(ForeignScene, DamagedFilesAreRefused) {
  const std::string text = Collada{}.file().bytes;
  for (const std::size_t size : {std::size_t{0}, text.size() / 4, text.size() / 2}) {
    EXPECT_NE(errorOf({"a.dae", text.substr(0, size)}).find("a.dae"), std::string::npos) << size;
  }
  const std::string whole = fbx("", 1).bytes;
  EXPECT_NE(errorOf({"a.fbx", whole.substr(0, whole.size() / 2)}).find("a.fbx: "),
            std::string::npos);
  EXPECT_NE(errorOf({"a.fbx", "Kaydara FBX Binary  "}).find("a.fbx: Assimp cannot read it"),
            std::string::npos);
  Collada still;
  still.animations.clear();
  EXPECT_EQ(errorOf(still.file()), "box.dae: has no animation");
}

}  // namespace
}  // namespace t4d::formats
