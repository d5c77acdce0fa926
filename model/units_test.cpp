#include "model/units.h"

#include <utility>

#include <gtest/gtest.h>

#include "model/converted_source.h"

namespace t4d::model {
namespace {

TEST(Units, DecimalsStayDecimalsWhereOneUnitIsAMultipleOfTheOther) {
  EXPECT_EQ((*lengthConversion("m", "mm"))(1.1), 1100);
  EXPECT_EQ((*lengthConversion("mm", "m"))(1.1), 0.0011);
  EXPECT_EQ((*lengthConversion("in", "mm"))(10), 254);
  EXPECT_EQ((*lengthConversion("ft", "in"))(2.5), 30);
  EXPECT_EQ((*timeConversion("min", "s"))(0.7), 42);
  EXPECT_EQ((*timeConversion("s", "ms"))(0.003), 3);
  EXPECT_EQ((*timeConversion("s", "h"))(5400), 1.5);
}

TEST(Units, ThereAndBackIsTheSameNumber) {
  for (const char* from : {"nm", "um", "µm", "mm", "cm", "dm", "m", "km", "in", "ft", "yd"}) {
    for (const char* to : {"mm", "m", "in"}) {
      const double there = (*lengthConversion(from, to))(0.7);
      EXPECT_DOUBLE_EQ((*lengthConversion(to, from))(there), 0.7) << from << " " << to;
      EXPECT_DOUBLE_EQ(there * *metresPer(to), 0.7 * *metresPer(from)) << from << " " << to;
    }
  }
}

TEST(Units, AreAsLargeAsTheirDefinitionsSay) {
  const std::pair<const char*, double> metres[] = {
      {"nm", 1e-9},         {"um", 1e-6},   {"µm", 1e-6},     {"mm", 1e-3},
      {"millimetre", 1e-3}, {"cm", 1e-2},   {"dm", 1e-1},     {"m", 1},
      {"metre", 1},         {"meter", 1},   {"km", 1e3},      {"in", 0.0254},
      {"inch", 0.0254},     {"ft", 0.3048}, {"foot", 0.3048}, {"yd", 0.9144}};
  for (const auto& [unit, size] : metres) EXPECT_EQ(metresPer(unit), size) << unit;
  const std::pair<const char*, double> seconds[] = {
      {"ns", 1e-9}, {"us", 1e-6},   {"µs", 1e-6},  {"ms", 1e-3},  {"millisecond", 1e-3},
      {"s", 1},     {"sec", 1},     {"second", 1}, {"min", 60},   {"minute", 60},
      {"h", 3600},  {"hour", 3600}, {"d", 86400},  {"day", 86400}};
  for (const auto& [unit, size] : seconds) EXPECT_EQ((*timeConversion(unit, "s"))(1), size) << unit;
}

TEST(Units, OnlyUnknownUnitsThatDifferCannotBeConverted) {
  EXPECT_TRUE(lengthConversion("metre", "m")->isIdentity());
  EXPECT_TRUE(lengthConversion("cubit", "cubit")->isIdentity());
  EXPECT_TRUE(timeConversion("", "")->isIdentity());
  EXPECT_FALSE(lengthConversion("cubit", "m"));
  EXPECT_FALSE(lengthConversion("m", "cubit"));
  EXPECT_FALSE(lengthConversion("s", "mm"));
  EXPECT_FALSE(timeConversion("frame", "s"));
}

/// Two tetrahedra whose common corner is the mean of two others.
Mesh smallMesh() {
  auto connectivity = std::make_shared<Connectivity>();
  connectivity->vertexCount = 5;
  connectivity->lowerCount = 2;
  connectivity->upperCount = 2;
  connectivity->cells = {{0, 1, 2, 3}, {0, 1, 2, 4}};
  connectivity->means.add(std::array<std::uint32_t, 2>{0, 3});
  Slab slab;
  slab.timeBegin = 0.1;
  slab.timeEnd = 0.7;
  slab.vertices = {{0.1, 0.2, 0.3, 0.1}, {0.7, 0, 0, 0.1}, {}, {0.9, 1, 1, 0.7}, {2, 2, 0, 0.7}};
  slab.connectivity = connectivity;
  setMeans(*connectivity, slab.vertices);
  Mesh mesh;
  EXPECT_TRUE(mesh.put(slab));
  return mesh;
}

TEST(ConvertedSource, HasTheSameMeshInOtherUnits) {
  Mesh mesh = smallMesh();
  ConvertedSource converted(mesh, *lengthConversion("m", "mm"), *timeConversion("min", "s"));
  EXPECT_EQ(converted.slabCount(), 1U);
  EXPECT_EQ(converted.timeSpan(0).begin, 6);
  EXPECT_EQ(converted.timeSpan(0).end, 42);
  const Slab& given = mesh.slabs()[0];
  const auto read = converted.slab(0);
  ASSERT_TRUE(read);
  const Slab& slab = **read;
  EXPECT_TRUE(checkSlab(slab));
  EXPECT_EQ(slab.connectivity, given.connectivity);
  EXPECT_EQ(slab.vertices[0], Point4(100, 200, 300, 6));
  EXPECT_EQ(slab.vertices[3], Point4(900, 1000, 1000, 42));
  EXPECT_EQ(slab.vertices[2], (slab.vertices[0] + slab.vertices[3]) / 2);
}

}  // namespace
}  // namespace t4d::model
