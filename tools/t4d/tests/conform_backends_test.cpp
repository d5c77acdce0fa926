#include <string>

#include <gmock/gmock.h>

#include "tools/t4d/tests/test_folder.h"

/// `t4d conform backends` from the user's point of view.
namespace t4d::tools {
namespace {

using testing::HasSubstr;
using testing::Not;

class ConformBackends : public InFolder {
 protected:
  Finished run(const std::string& arguments) const {
    return InFolder::run("conform backends " + arguments);
  }

  /// A script that runs `before`, then `t4d sweep`, then `after`; "$motion" is the motion file.
  std::string script(const std::string& name, const std::string& before = {},
                     const std::string& after = {}) const {
    return writeScript(name, "motion=$2\n" + before +
                                 "\n" T4D_PROGRAM
                                 " sweep \"$1\" --motion \"$motion\" --caps cone -o \"$3\"\n" +
                                 after);
  }
};

std::vector<std::string> failedChecks(const json& result) {
  std::vector<std::string> names;
  for (const json& check : result["checks"]) {
    if (!check["passed"]) names.push_back(check["name"]);
  }
  return names;
}

TEST_F(ConformBackends, PassAndSayByWhat) {
  const Finished done =
      run("--case paper-cube --case 'cube-*-rest' --quick --json --html page.html");
  EXPECT_EQ(done.exitCode, 0) << done.err;
  const json value = done.value();
  EXPECT_EQ(value["passed"], 4);
  EXPECT_EQ(value["failed"], 0);
  ASSERT_EQ(value["cases"].size(), 4U);
  EXPECT_EQ(value["cases"][0]["id"], "paper-cube");
  EXPECT_EQ(value["cases"][0]["backend"], "mesh4d");
  EXPECT_EQ(value["cases"][1]["backend"], "voxel4d");
  // The paper's Table 1.
  EXPECT_EQ(value["cases"][1]["levels"][0]["vertices"], 197'828);
  EXPECT_EQ(value["cases"][1]["levels"][0]["tetrahedra"], 1'185'280);
  for (const json& result : value["cases"]) {
    EXPECT_EQ(result["passed"], true);
    for (const json& check : result["checks"]) {
      for (const char* key : {"name", "expected", "actual", "tolerance", "passed", "reason"}) {
        EXPECT_TRUE(check.contains(key)) << key;
      }
    }
  }
  const std::string page = contents(folder_ / "page.html");
  EXPECT_THAT(page, HasSubstr("<polyline class=\"curve a\""));
  EXPECT_THAT(page, HasSubstr("197,828"));
  EXPECT_THAT(page, Not(HasSubstr("http")));

  const std::string text = run("--case cube-at-rest --backend mesh4d").out;
  EXPECT_THAT(text, HasSubstr("1 of 1 cases passed"));
  EXPECT_THAT(text, Not(HasSubstr("voxel4d")));
}

TEST_F(ConformBackends, ListRunsNothing) {
  const Finished done = run("--list");
  EXPECT_EQ(done.exitCode, 0);
  EXPECT_THAT(done.out, HasSubstr("merging-spheres           voxel4d"));
  EXPECT_THAT(done.out, HasSubstr("squirrel-size             mesh4d"));
  EXPECT_THAT(run("--list --quick").out, Not(HasSubstr("squirrel-size")));
}

TEST_F(ConformBackends, ARightProgramPasses) {
  const Finished done =
      run("--backend-program " + script("right") + " --keep kept --case 'cube-*' --json");
  EXPECT_EQ(done.exitCode, 0) << done.out;
  EXPECT_EQ(done.value()["passed"], 7);
  EXPECT_EQ(done.value()["cases"][0]["backend"], "program");
  for (const char* name :
       {"cube-screw.obj", "cube-screw.json", "cube-screw.t4d", "cube-screw.log"}) {
    EXPECT_TRUE(fs::exists(folder_ / "kept" / name)) << name;
  }
  // A quoted command, and a tolerance that its steps do not meet.
  const Finished strict =
      run("--backend-program '" + script("right") + "' --tolerance 0.001 --case cube-screw --json");
  EXPECT_EQ(strict.exitCode, 1);
  EXPECT_THAT(failedChecks(strict.value()["cases"][0]), testing::Contains("hypervolume"));
}

TEST_F(ConformBackends, WrongProgramsFailInTheRightCheck) {
  const auto failed = [&](const std::string& program) {
    const Finished done = run("--backend-program '" + program + "' --case cube-about-z --json");
    EXPECT_EQ(done.exitCode, 1) << program << done.err;
    const json value = done.value();
    EXPECT_EQ(value["failed"], 1);
    return value["cases"][0];
  };
  using testing::Contains;
  const json backward =
      failed(script("backward", "sed 's/\"angle_degrees\": /&-/' $2 > b.json; motion=b.json"));
  for (const std::string& name : failedChecks(backward)) {
    EXPECT_THAT(name, testing::AnyOf(HasSubstr("farthest vertex from the true surface"),
                                     "first contact with the obstacle"));
  }
  EXPECT_THAT(failedChecks(failed(
                  script("late",
                         "sed 's/{/{\"start_time\": 1,/' $2 > l.json; sed -i '2,$s/.start_time.: "
                         "1,//' l.json; motion=l.json"))),
              Contains("time begin"));
  EXPECT_THAT(failedChecks(failed(script("twice", "sed 's/90/180/' $2 > t.json; motion=t.json"))),
              Contains(HasSubstr("farthest vertex")));
  const json cut = failed(script("cut", "", "truncate -s -40 \"$3\""));
  EXPECT_THAT(failedChecks(cut), testing::ElementsAre("made"));
  EXPECT_THAT(cut["checks"][0]["found"].get<std::string>(), HasSubstr("cube-about-z.t4d"));
  const auto found = [&](const std::string& program) {
    return failed(program)["checks"][0]["found"].get<std::string>();
  };
  EXPECT_THAT(found("false"), HasSubstr("exited with 1 and printed nothing"));
  EXPECT_THAT(found("true"), HasSubstr("exited with 0 and wrote no cube-about-z.t4d"));
  EXPECT_THAT(found("sh -c \"echo cannot; exit 3\""),
              HasSubstr("exited with 3; last line of output: cannot"));
  EXPECT_THAT(found("sh -c \"kill -9 \\$\\$\""), HasSubstr("ended by signal 9"));
}

TEST_F(ConformBackends, AProgramThatHangsIsEnded) {
  const Finished done =
      run("--backend-program 'sh -c \"sleep 60\"' --timeout 0.2 --case cube-about-z --json");
  EXPECT_EQ(done.exitCode, 1);
  EXPECT_THAT(done.out, HasSubstr("timed out after 0.2 s"));
}

TEST_F(ConformBackends, AProgramThatMakesAPipeFailsInstead) {
  writeScript("pipe", "rm -f \"$3\"; mkfifo \"$3\"");
  const Finished done = run("--backend-program ./pipe --case cube-at-rest --timeout 1");
  EXPECT_EQ(done.exitCode, 1);
  EXPECT_THAT(done.out, HasSubstr("is not a regular file"));
}

TEST_F(ConformBackends, WrongUsageIsExit2) {
  for (const char* arguments :
       {"--case nothing", "--backend squirrel", "--tolerance 0.1", "--keep x", "--list --json",
        "--backend-program true --tolerance 0", "--case squirrel-size --quick",
        "--case squirrel-size --backend voxel4d", "--backend-program ./none",
        "--backend-program 'none at all'", "--backend-program ''", "--list --case nothing"}) {
    const Finished done = run(arguments);
    EXPECT_EQ(done.exitCode, 2) << arguments;
    EXPECT_EQ(done.out, "") << arguments;
    EXPECT_NE(done.err, "") << arguments;
  }
  EXPECT_THAT(run("--backend-program ''").err, HasSubstr("the command is empty"));
  EXPECT_EQ(run("--case cube-at-rest --html no/such/folder.html").exitCode, 1);
}

}  // namespace
}  // namespace t4d::tools
