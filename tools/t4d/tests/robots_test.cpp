#include <string>

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "tools/t4d/tests/box.h"
#include "tools/t4d/tests/program.h"

/// Robots as they come: links that are no solids, packages, and what `collide` says of many pairs.
namespace t4d::tools {
namespace {

using testing::HasSubstr;
using testing::Not;

std::string link(const std::string& name, const std::string& mesh) {
  return fmt::format(
      "<link name=\"{}\"><collision><geometry><mesh filename=\"{}\"/></geometry>"
      "</collision></link>\n",
      name, mesh);
}

std::string joint(const std::string& child, const std::string& parent, double x) {
  return fmt::format(
      "<joint name=\"{0}_joint\" type=\"prismatic\"><parent link=\"{1}\"/>"
      "<child link=\"{0}\"/><origin xyz=\"{2} 0 0\"/><axis xyz=\"1 0 0\"/>"
      "<limit lower=\"-9\" upper=\"9\" velocity=\"99\" effort=\"1\"/></joint>\n",
      child, parent, x);
}

class Robots : public Program {
 protected:
  void SetUp() override {
    Program::SetUp();
    const std::string box = boxText({0, 0, 0}, {1, 1, 1});
    write("box.obj", box);
    write("open.obj", box.substr(0, box.rfind("f ")));       // a side is half a hole
    write("finned.obj", box + "v 0.5 0.5 4\nf -2 -3 -1\n");  // its tip is at 4
    write("flat.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    write("joints.csv", "time,hand_joint\n0,0\n2,-4\n");
    write("r.urdf", "<robot name=\"r\">\n" + link("base", "box.obj") + link("arm", "open.obj") +
                        link("fork", "finned.obj") + link("tag", "flat.obj") +
                        link("hand", "box.obj") + joint("arm", "base", 3) +
                        joint("fork", "arm", 3) + joint("tag", "fork", 0) +
                        joint("hand", "base", 9) + "</robot>\n");
  }
};

TEST_F(Robots, NeverFailForOneMesh) {
  const Finished done = run("sweep r.urdf -m joints.csv -o r.t4d");
  EXPECT_EQ(done.exitCode, 3) << done.err;
  EXPECT_THAT(done.out, testing::ContainsRegex("arm +mended +1 +open"));
  EXPECT_THAT(done.out, testing::ContainsRegex("base +as it was +1"));
  // The hull of a cube and a point 3 above a diagonal of its top: 1, and a pyramid of height 3.
  EXPECT_THAT(done.out, testing::ContainsRegex("fork +its hull +2 +open"));
  EXPECT_THAT(done.err, HasSubstr("lost: 1 body without volume: tag"));
  EXPECT_THAT(done.err, HasSubstr("lost: the shape of bodies that were mended (--mend): arm\n"));
  EXPECT_THAT(done.err,
              HasSubstr("lost: the shape of bodies that became convex hulls (--hull): fork\n"));
  EXPECT_THAT(done.err, Not(HasSubstr("body 'arm': filled")));

  const Finished asked = run("sweep r.urdf -m joints.csv --mend --hull fallback -o r.t4d --json");
  EXPECT_EQ(asked.exitCode, 3);  // for the tag alone
  EXPECT_THAT(asked.err, Not(HasSubstr("the shape of")));
  const json report = json::parse(asked.out);
  EXPECT_EQ(report["mend"]["bodies"].size(), 4U);
  EXPECT_EQ(report["mend"]["changes"].back()["kind"], "hull");
  refuses("sweep r.urdf -m joints.csv --hull never -o out.t4d", "flat.obj: ");
  misused("sweep box.obj -m fx/rest.json --hull always -o out.t4d", "--hull are for a mechanism");

  const Finished collided = run("collide r.t4d --json");
  const json mended = json::parse(collided.out)["mended"];
  ASSERT_EQ(mended.size(), 2U);
  EXPECT_EQ(mended[0]["hull"], false);
  EXPECT_EQ(mended[1]["body"], "fork");
  EXPECT_EQ(mended[1]["hull"], true);
  EXPECT_THAT(collided.err,
              HasSubstr("the answer is about 2 bodies as the file has them: 'arm' of"));
}

TEST_F(Robots, HullsOfAllLinksAreAsked) {
  const json report =
      json::parse(run("sweep r.urdf -m joints.csv --hull always -o r.t4d --json").out);
  EXPECT_EQ(report["mend"]["changes"].size(), 4U);
  // A box is its own hull.
  EXPECT_NEAR(report["mend"]["bodies"][0]["hausdorff"].get<double>(), 0, 1e-12);
  EXPECT_NEAR(report["mend"]["bodies"][0]["volume_after"].get<double>(), 1, 1e-12);
}

TEST_F(Robots, PackagesAndTemplates) {
  write("p.urdf", "<robot name=\"r\">\n" + link("base", "package://parts/box.obj") +
                      link("hand", "box.obj") + joint("hand", "base", 3) + "</robot>\n");
  refuses("sweep p.urdf -m joints.csv -o out.t4d", "--package parts=FOLDER");
  EXPECT_EQ(run("sweep p.urdf -m joints.csv --package parts=. -o p.t4d").exitCode, 0);
  misused("sweep p.urdf -m joints.csv --package parts -o out.t4d", "is not NAME=FOLDER");
  write("t.urdf.xacro", "<robot><xacro:arm/></robot>");
  refuses("sweep t.urdf.xacro -m joints.csv -o out.t4d", "xacro t.urdf.xacro > robot.urdf");
}

// The hand moves by -2 x time from 9: it reaches the fork, from 6 to 7, at time 1.
TEST_F(Robots, CollisionsAreListedWithTheJointsAtTheFirst) {
  ASSERT_EQ(run("sweep r.urdf -m joints.csv -o r.t4d -q").exitCode, 3);
  const Finished done = run("collide r.t4d");
  EXPECT_THAT(done.out, HasSubstr("fork and hand\n  hit"));
  EXPECT_THAT(done.out, HasSubstr("first contact at t = 1,"));
  EXPECT_THAT(done.out, HasSubstr("joints: hand_joint -2 m\n"));
  EXPECT_THAT(done.out, Not(HasSubstr("base and fork")));
  EXPECT_THAT(done.out, HasSubstr("1 of 3 pairs hit; the others are clear by at least"));
  EXPECT_THAT(run("collide r.t4d --all").out, HasSubstr("base and fork\n  clear"));
  EXPECT_THAT(run("collide r.t4d --clearance 3").out,
              HasSubstr("nearer than the clearance or may be"));
  const json first = run("collide r.t4d --json").value()["pairs"].back()["first_contact"];
  EXPECT_EQ(first["joints"][0], json::parse(R"({"name": "hand_joint", "value": -2, "unit": "m"})"));
}

TEST_F(Robots, ThePictureHasASquareForEachPair) {
  ASSERT_EQ(run("sweep r.urdf -m joints.csv -o r.t4d -q").exitCode, 3);
  const json pairs = run("collide r.t4d --json --matrix m.svg").value()["pairs"];
  const std::string picture = contents(folder_ / "m.svg");
  std::size_t squares = 0;
  for (std::size_t at = 0; (at = picture.find("<title>", at)) != picture.npos; ++at) ++squares;
  EXPECT_EQ(squares, pairs.size());
  EXPECT_THAT(picture, HasSubstr("<title>fork and hand: hit</title>"));
  EXPECT_EQ(run("collide r.t4d --matrix m.png").exitCode, 0);
  EXPECT_TRUE(contents(folder_ / "m.png").starts_with("\x89PNG"));
  misused("collide r.t4d --matrix m.csv", "--matrix");
}

TEST_F(Robots, DefaultCollisionsOfALinkAreDisabledAndEnabled) {
  ASSERT_EQ(run("sweep r.urdf -m joints.csv -o r.t4d -q").exitCode, 3);
  const auto ignored = [&](const std::string& text) {
    write("r.srdf", "<robot name=\"r\">" + text + "</robot>");
    return run("collide r.t4d --ignore r.srdf --json").value()["pairs"].size();
  };
  const std::size_t all = ignored("");
  EXPECT_EQ(ignored("<disable_collisions link1=\"hand\" link2=\"fork\"/>"), all - 1);
  const std::string hand = "<disable_default_collisions link=\"hand\"/>";
  EXPECT_LT(ignored(hand), all - 1);
  EXPECT_EQ(ignored(hand + "<enable_collisions link1=\"fork\" link2=\"hand\"/>"),
            ignored(hand) + 1);
  write("r.srdf", "<robot name=\"r\"><disable_collisions link1=\"hand\" link2=\"nose\"/></robot>");
  EXPECT_THAT(run("collide r.t4d --ignore r.srdf").err,
              HasSubstr("r.srdf names links that have no body here: nose"));
}

}  // namespace
}  // namespace t4d::tools
