#include "t4d/error.h"

#include <memory>

#include <gtest/gtest.h>

namespace t4d {
namespace {

Result<int> half(int number) {
  if (number % 2 != 0) return invalid("is odd", "number");
  return number / 2;
}

TEST(Result, CopiesHaveTheValueOfTheOriginalAlsoIfItIsABool) {
  Result<bool> original = false;
  const Result<bool> copied = original;
  const Result<bool> constructed(original);
  auto deduced = original;
  EXPECT_TRUE(copied && constructed && deduced);
  EXPECT_FALSE(*copied || *constructed || *deduced);
  original = invalid("is neither");
  deduced = original;
  EXPECT_EQ(deduced.error().message, "is neither");
}

TEST(Result, ChainsWithFunctionsThatReturnResults) {
  EXPECT_EQ(half(12).and_then(half), 3);
  EXPECT_EQ(half(6).and_then(half).error().text(), "number: is odd");
  const Result<double> third = half(6).map([](int number) { return number / 3.0; });
  EXPECT_EQ(third, 1);
  EXPECT_EQ(half(3).or_else([](const Error&) { return half(8); }), 4);
}

TEST(Result, HoldsWhatCannotBeCopied) {
  Result<std::unique_ptr<int>> made = std::make_unique<int>(7);
  const Result<std::unique_ptr<const int>> moved = std::move(made);
  EXPECT_EQ(**moved, 7);
}

TEST(Place, SaysTheFileTheLineAndThePartThatThereAre) {
  EXPECT_TRUE(Place().empty());
  EXPECT_EQ(Place().text(), "");
  EXPECT_EQ(Place("a.obj").text(), "a.obj");
  EXPECT_EQ(Place("a.obj", 12).text(), "a.obj:12");
  EXPECT_EQ(placeIn("m.t4d", "slab 3").text(), "m.t4d: slab 3");
  EXPECT_EQ(placeIn({}, "slab 3").text(), "slab 3");
  EXPECT_EQ(placeIn("a.obj", "").text(), "a.obj");
}

TEST(Place, OfAnInnerFileIsAPartOfTheOuterOne) {
  const Place inner = placeIn("mesh.stl", "byte 84");
  const Place outer = placeIn({"robot.urdf", 14}, inner.text());
  EXPECT_EQ(outer.text(), "robot.urdf:14: mesh.stl: byte 84");
  EXPECT_EQ(outer.file, "robot.urdf");
  EXPECT_EQ(placeIn(placeIn("arm.json", "bodies[2]"), inner.text()).text(),
            "arm.json: bodies[2]: mesh.stl: byte 84");
}

}  // namespace
}  // namespace t4d
