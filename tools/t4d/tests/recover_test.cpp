#include <filesystem>
#include <string>

#include "tools/t4d/tests/program.h"

/// `t4d recover`, and what is said of damaged files.
namespace t4d::tools {
namespace {

TEST_F(Program, RecoversWhatIsWhole) {
  ASSERT_EQ(run(kPaper).exitCode, 0);
  const std::string whole = contents(folder_ / "cube.t4d");
  const Finished copied = run("recover cube.t4d -o out.t4d");
  EXPECT_EQ(copied.exitCode, 0) << copied.err;
  EXPECT_EQ(copied.err, "");
  EXPECT_NE(copied.out.find("66 of 66 slabs saved"), std::string::npos) << copied.out;
  fs::remove(folder_ / "out.t4d");

  write("broken.t4d", whole.substr(0, whole.size() / 2));
  for (const char* verb :
       {"info", "validate", "slice --time 1", "flipbook --frames 2 -o out.glb"}) {
    refuses(std::string(verb) + " broken.t4d",
            "t4d: try: t4d recover broken.t4d -o broken-recovered.t4d");
  }
  const Finished saved = run("recover broken.t4d -o saved.t4d --json");
  EXPECT_EQ(saved.exitCode, 3) << saved.err;
  EXPECT_NE(saved.err.find("t4d: lost: byte "), std::string::npos) << saved.err;
  const json said = saved.value();
  EXPECT_GT(said["slabs_saved"], 10);
  EXPECT_EQ(said["slabs_known"], nullptr);
  ASSERT_EQ(said["caps"].size(), 1U);
  EXPECT_EQ(said["caps"][0]["triangles"], 24);
  // The start cap, and steps of unit time.
  const double steps = said["slabs_saved"].get<double>() - 1;
  EXPECT_EQ(said["caps"][0]["time"], steps);
  EXPECT_NEAR(said["hypervolume"].get<double>(), steps * 8000, 1e-6);
  EXPECT_EQ(run("validate saved.t4d --deep").exitCode, 0);
  EXPECT_EQ(contents(folder_ / "broken.t4d"), whole.substr(0, whole.size() / 2));

  EXPECT_EQ(run("recover broken.t4d -o broken.t4d").exitCode, 2);
  EXPECT_EQ(run("recover broken.t4d").exitCode, 2);
  write("begin.t4d", whole.substr(0, 500));
  refuses("recover begin.t4d -o out.t4d", "no closed solid could be recovered");
  refuses("recover fx/cube.obj -o out.t4d", "is not a .t4d file");
}

TEST_F(Program, SuggestsRecoveryOnlyWhereItSavesSomething) {
  ASSERT_EQ(run(kPaper).exitCode, 0);
  const std::string whole = contents(folder_ / "cube.t4d");
  const auto hint = [&](const std::string& command) {
    const std::string err = run(command).err;
    const std::size_t at = err.find("t4d: try: ");
    return at == std::string::npos ? "" : err.substr(at + 10, err.find('\n', at) - at - 10);
  };
  std::string connectivity = whole;  // damaged where all slabs but the caps share it
  connectivity[whole.find("CONN", whole.find("CONN") + 1) + 40] ^= 1;
  const std::size_t afterHead = whole.find("CONN") + 8;
  for (const std::string& lost : {whole.substr(0, 8), whole.substr(0, 23), connectivity,
                                  whole.substr(0, afterHead), std::string(9000, '\0')}) {
    write("lost.t4d", lost);
    for (const char* command :
         {"info lost.t4d", "validate lost.t4d", "recover lost.t4d -o out.t4d"}) {
      EXPECT_EQ(hint(command), "") << command << ", " << lost.size() << " bytes";
    }
  }

  std::string zeros = whole;
  zeros.replace(0, 512, 512, '\0');
  write("zeros.t4d", zeros);
  EXPECT_EQ(hint("info zeros.t4d"), "t4d recover zeros.t4d -o zeros-recovered.t4d");
  EXPECT_EQ(run("recover zeros.t4d -o zeros-recovered.t4d").exitCode, 3);
  EXPECT_EQ(hint("info zeros.t4d"), "t4d recover zeros.t4d -o zeros-recovered-2.t4d");

  write("-x.t4d", zeros);
  EXPECT_EQ(hint("info -- -x.t4d"), "t4d recover ./-x.t4d -o ./-x-recovered.t4d");
  EXPECT_EQ(run("recover ./-x.t4d -o ./-x-recovered.t4d").exitCode, 3);
  fs::create_directory(folder_ / "a b");
  write("a b/x.t4d", zeros);
  EXPECT_EQ(hint("info 'a b/x.t4d'"), "t4d recover 'a b/x.t4d' -o 'a b/x-recovered.t4d'");
}

TEST_F(Program, InfoTellsOfARecoveredFile) {
  ASSERT_EQ(run(kPaper).exitCode, 0);
  std::string bytes = contents(folder_ / "cube.t4d");
  EXPECT_EQ(run("info cube.t4d").out.find("recovered"), std::string::npos);
  bytes[bytes.find("SLAB", bytes.size() / 2) + 40] ^= 1;
  write("broken.t4d", bytes);
  EXPECT_EQ(run("recover broken.t4d -o saved.t4d").exitCode, 3);
  const Finished info = run("info saved.t4d");
  EXPECT_NE(info.out.find("recovered from broken.t4d: 65 of 66 slabs; nothing between time "),
            std::string::npos)
      << info.out;
}

TEST_F(Program, EveryTruncationAndEveryAlteredByteIsFound) {
  ASSERT_EQ(run("sweep fx/cube.obj -m fx/rest.json -o whole.t4d").exitCode, 0);
  const std::string whole = contents(folder_ / "whole.t4d");
  // The library's tests try all of them; here a sample goes through the program.
  for (std::size_t i = 0; i < whole.size(); i += 1 + whole.size() / 60) {
    write("bad.t4d", whole.substr(0, i));
    EXPECT_EQ(run("info bad.t4d").exitCode, 4) << "cut at " << i;
    EXPECT_EQ(run("slice bad.t4d --time 0").exitCode, 4) << "cut at " << i;
    const Finished validated = run("validate bad.t4d --json");
    EXPECT_EQ(validated.exitCode, 4) << "cut at " << i;
    EXPECT_EQ(validated.value()["valid"], false);
    std::string altered = whole;
    altered[i] = static_cast<char>(altered[i] ^ 0x10);
    write("bad.t4d", altered);
    const Finished judged = run("validate bad.t4d --json");
    EXPECT_EQ(judged.exitCode, 4) << "altered at " << i;
    EXPECT_TRUE(judged.value()["issues"]["messages"][0]["offset"].is_number()) << judged.out;
  }
}

}  // namespace
}  // namespace t4d::tools
