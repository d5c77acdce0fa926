#include <fstream>
#include <string>
#include <utility>

#include <gmock/gmock.h>

#include "conformance/corpus/corpus.h"
#include "platform/child_process.h"
#include "tools/t4d/tests/test_folder.h"

/// `t4d conform reader`, `copy` and `list` from the user's point of view.
namespace t4d::tools {
namespace {

using platform::ProgramRun;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::StartsWith;

class ConformReader : public InFolder {
 protected:
  platform::ProgramRun shell(const std::string& script) {
    const std::string there = "cd '" + folder_.path().string() + "'; ";
    const auto run = platform::runProgram({"/bin/sh", "-c", there + script}, {.limit = 600});
    EXPECT_TRUE(run) << run.error().text();
    return run.value_or(platform::ProgramRun{});
  }
  platform::ProgramRun conform(const std::string& arguments) {
    return shell("exec " T4D_PROGRAM " conform " + arguments);
  }
  /// A reader as a shell script: "$1" is the file, "$2" the request.
  std::string reader(const std::string& script) const {
    return "--reader " + writeScript("my-reader", script) + " ";
  }
};

TEST_F(ConformReader, OurReaderPassesWhatIsChosen) {
  const platform::ProgramRun run = conform(
      "reader --reader " T4D_READER " --only valid 'overwrite/*' --skip 'valid/*zstd*' --json");
  EXPECT_EQ(run.code, 0) << run.output;
  const json report = json::parse(run.output);
  EXPECT_EQ(report["reader"], T4D_READER);
  EXPECT_EQ(report["corpus_version"], conformance::kCorpusVersion);
  EXPECT_GT(report["passed"], 50);
  EXPECT_GT(report["skipped"], 3);
  EXPECT_EQ(report["failed"], 0);
  EXPECT_EQ(report["passed"].get<int>() + report["skipped"].get<int>(), report["cases"].size());
  for (const json& test : report["cases"]) {
    const std::string id = test["id"];
    EXPECT_TRUE(id.starts_with("valid/") || id.starts_with("overwrite/")) << id;
    const bool skipped = id.starts_with("valid/") && id.find("zstd") != std::string::npos;
    EXPECT_EQ(test["outcome"], skipped ? "skipped" : "passed") << id;
  }
}

TEST_F(ConformReader, AReaderThatRefusesAllFailsTheValidFilesAlone) {
  const platform::ProgramRun run =
      conform("reader " + reader("echo no >&2; exit 1") + "--skip cut flip");
  EXPECT_EQ(run.code, 1);
  EXPECT_THAT(run.output, HasSubstr("refused, but the file is valid; it said: no"));
  EXPECT_THAT(run.output, HasSubstr("more (--verbose lists all)"));
  EXPECT_THAT(run.output, HasSubstr("Look first at valid/"));
  // The command that it prints works.
  const std::size_t at = run.output.find("t4d conform copy corpus   # once\n  ./my-reader ");
  ASSERT_NE(at, std::string::npos);
  std::string commands = run.output.substr(at, run.output.find("\n  The right", at) - at);
  commands.replace(0, 3, T4D_PROGRAM);
  EXPECT_THAT(shell(commands).output, testing::EndsWith("\n1\n"));
  EXPECT_THAT(shell(commands).message, HasSubstr("not an empty folder"));
}

TEST_F(ConformReader, AReaderWithoutAFeatureRefusesItsFiles) {
  const std::string filter =
      reader("grep -aq '\"zstd\"' \"$1\" && exit 1; exec " T4D_READER " \"$@\"") +
      "--only 'valid/zstd*' --json";
  EXPECT_EQ(conform("reader --without zstd " + filter).code, 0);
  EXPECT_EQ(conform("reader --without means,zstd " + filter).code, 0);
  EXPECT_EQ(conform("reader " + filter).code, 1);
  EXPECT_EQ(conform("reader --without means " + filter).code, 1);
}

/// The corpus has files of every feature, and a reader that knows none of them is no wrong one.
TEST_F(ConformReader, AReaderMayLackEveryFeature) {
  const std::string lacking =
      reader("grep -aqE '\"(zstd|means|pose|grid)\"' \"$1\" && exit 1; exec " T4D_READER
             " \"$@\"") +
      "--only 'valid/grid*' 'valid/poses*' 'valid/means*' --json";
  EXPECT_EQ(conform("reader --without zstd,means,pose,grid " + lacking).code, 0);
  for (const char* without : {"zstd,means,pose", "zstd,means,grid"}) {
    EXPECT_EQ(conform(std::string("reader --without ") + without + " " + lacking).code, 1)
        << without;
  }
}

TEST_F(ConformReader, CrashesAndSleepAreToldApart) {
  const platform::ProgramRun run = conform(
      "reader --json --timeout 0.1 --only 'valid/one-simplex' 'invalid/H*' " +
      reader("case $2 in slice) kill -SEGV $$ ;; esac; grep -aq simplex \"$1\" && sleep 60"));
  EXPECT_EQ(run.code, 1);
  const json report = json::parse(run.output);
  EXPECT_EQ(report["cases"][0]["outcome"], "crashed") << run.output;
  EXPECT_THAT(report["cases"][0]["message"].get<std::string>(), HasSubstr("(SIGSEGV)"));
  EXPECT_GT(report["timed_out"], 0);
}

TEST_F(ConformReader, WritesWhatContinuousIntegrationReads) {
  const platform::ProgramRun run = conform("reader " + reader("printf '<\\001&' >&2; exit 1") +
                                           "--only valid 'invalid/H*' --junit out.xml --json");
  EXPECT_EQ(run.code, 1);
  const json report = json::parse(run.output);
  const std::string xml = contents(folder_ / "out.xml");
  const std::string count = std::to_string(report["cases"].size());
  EXPECT_THAT(xml, StartsWith("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites "));
  EXPECT_THAT(xml, HasSubstr(" tests=\"" + count + "\" failures=\"" +
                             std::to_string(report["failed"].get<int>()) + "\""));
  EXPECT_THAT(xml, HasSubstr("it said: &lt;\\x01&amp;"));
  const platform::ProgramRun parsed = shell(
      "exec python3 -c 'import xml.etree.ElementTree as t; "
      "print(len(t.parse(\"out.xml\").findall(\"testsuite/testcase\")))'");
  if (parsed.code == 127) GTEST_SKIP() << "no python3 to parse it with";
  EXPECT_EQ(parsed.output, count + "\n") << parsed.message;
}

TEST_F(ConformReader, KeepsWhatWentWrong) {
  const platform::ProgramRun run =
      conform("reader " + reader("exec " T4D_READER " \"$1\" describe") +
              "--only overwrite --first --keep kept");
  EXPECT_EQ(run.code, 1);
  EXPECT_THAT(run.output, HasSubstr("Look first at overwrite/"));
  EXPECT_THAT(run.output, HasSubstr("refused, but the slice needs none of these"));
  const std::size_t at = run.output.find("./my-reader corpus/") + 12;
  std::string file = run.output.substr(at, run.output.find(' ', at) - at);
  file.replace(0, 6, "kept");
  EXPECT_TRUE(fs::exists(folder_ / file)) << file;
}

TEST_F(ConformReader, AnInterruptionEndsReadersAndLeavesNothing) {
  reader("echo $$ >> pids; exec sleep 600");
  const platform::ProgramRun run =
      shell("mkdir tmp; export TMPDIR=$PWD/tmp; " T4D_PROGRAM
            " conform reader --reader ./my-reader --parallel 3 & "
            "while ! [ -s pids ]; do sleep 0.05; done; sleep 0.2; kill -TERM $!; wait $!; echo $?; "
            "ls tmp; for pid in $(cat pids); do [ -d /proc/$pid ] && ps -o stat= $pid; done; true");
  EXPECT_EQ(run.output, "143\n");
}

TEST_F(ConformReader, WrongUsageIsExit2) {
  write("not-executable", "print()\n");
  for (const auto& [arguments, expected] :
       {std::pair{"", "--reader is required"},
        {"--reader ./none", "./none: is not there"},
        {"--reader ./not-executable", "chmod +x ./not-executable"},
        {"--reader none-such", "is not in PATH"},
        {"--reader true --only nothing", "no case is called nothing"},
        {"--reader true --skip 'x*'", "`t4d conform list` lists them"},
        {"--reader true --without float32", "float32"},
        {"--reader true --timeout 0", "timeout"},
        {"--reader true --parallel 0", "parallel"}}) {
    const platform::ProgramRun run = conform(std::string("reader ") + arguments);
    EXPECT_EQ(run.code, 2) << arguments;
    EXPECT_EQ(run.output, "") << arguments;
    EXPECT_THAT(run.message, HasSubstr(expected));
  }
  EXPECT_EQ(conform("").code, 2);
  EXPECT_EQ(conform("list --only nothing").code, 2);
}

TEST_F(ConformReader, TheCorpusIsCopiedWithItsManifest) {
  EXPECT_EQ(conform("copy corpus").code, 0);
  const json manifest = json::parse(contents(folder_ / "corpus/manifest.json"));
  EXPECT_EQ(manifest["corpus_version"], conformance::kCorpusVersion);
  EXPECT_TRUE(fs::exists(folder_ / "corpus/README.md"));
  for (const json& file : manifest["files"]) {
    EXPECT_EQ(fs::file_size(folder_ / "corpus" / file["file"]), file["bytes"]);
  }
  // Existing files are not overwritten unless requested.
  const fs::path one = folder_ / "corpus/valid/one-simplex.t4d";
  std::ofstream(one) << "mine";
  const platform::ProgramRun again = conform("copy corpus");
  EXPECT_EQ(again.code, 2);
  EXPECT_THAT(again.message, HasSubstr("corpus: is not an empty folder; --force"));
  EXPECT_EQ(contents(one), "mine");
  EXPECT_EQ(conform("copy corpus --force").code, 0);
  EXPECT_NE(contents(one), "mine");
  write("file", "mine");
  EXPECT_EQ(conform("copy file --force").code, 2);
  EXPECT_EQ(conform("copy /proc/none").code, 1);
}

TEST_F(ConformReader, CasesAreListed) {
  const json list = json::parse(conform("list --json").output);
  EXPECT_EQ(list["corpus_version"], conformance::kCorpusVersion);
  EXPECT_GT(list["cases"].size(), 500U);
  for (const json& test :
       json::parse(conform("list --json --only 'invalid/H2*'").output)["cases"]) {
    EXPECT_EQ(test["result"], "invalid");
    EXPECT_EQ(test["clause"], "H2");
    EXPECT_EQ(test["offset"], 20);
  }
  const platform::ProgramRun text =
      conform("list --only 'valid/one-simplex' cut --skip 'cut/[a-y]*'");
  EXPECT_THAT(text.output, StartsWith("valid/one-simplex  "));
  EXPECT_THAT(text.output, HasSubstr("cut/zstd"));
}

/// A writer under test, whose one good file is that of the corpus.
TEST_F(ConformReader, AWriterIsTestedByTheFilesThatItMakes) {
  ASSERT_EQ(conform("copy corpus").code, 0);
  const auto writer = [&](const std::string& script) {
    return "writer --writer " + writeScript("my-writer", script) + " ";
  };
  const std::string copies = "cp corpus/valid/one-simplex.t4d \"$2\"";
  const auto right = conform(writer(copies) + "--only one-simplex");
  EXPECT_EQ(right.code, 0) << right.output << right.message;
  EXPECT_THAT(right.output, HasSubstr("1 of 1 cases"));

  const auto wrong = conform(writer(copies) + "--only 'plain/cube-*' --keep kept --json");
  EXPECT_EQ(wrong.code, 1);
  const json report = json::parse(wrong.output);
  EXPECT_EQ(report["writer"], "./my-writer");
  EXPECT_EQ(report["passed"], 0);
  for (const json& test : report["cases"]) {
    EXPECT_THAT(test["id"].get<std::string>(), StartsWith("plain/"));
    EXPECT_EQ(test["outcome"], "failed");
    EXPECT_TRUE(fs::exists(folder_ / "kept" / (test["id"].get<std::string>() + ".json")));
    EXPECT_TRUE(fs::exists(folder_ / "kept" / (test["id"].get<std::string>() + ".t4d")));
  }
  EXPECT_EQ(conform(writer("kill -9 $$") + "--only one-simplex --junit w.xml").code, 1);
  EXPECT_THAT(contents(folder_ / "w.xml"), HasSubstr("t4d conform writer: ./my-writer"));
  EXPECT_EQ(conform("writer --writer ./none").code, 2);
  EXPECT_EQ(conform(writer("true") + "--only nothing").code, 2);
}

TEST_F(ConformReader, AQuickRunIsShort) {
  const auto run = conform("reader --reader " T4D_READER " --quick");
  EXPECT_EQ(run.code, 0) << run.output;
  EXPECT_EQ(conform("reader --reader " T4D_READER " --quick --thorough").code, 2);
}

TEST_F(ConformReader, TheCorpusHasALicenseAndAVersion) {
  ASSERT_EQ(conform("copy corpus").code, 0);
  EXPECT_THAT(contents(folder_ / "corpus/LICENSE"), HasSubstr("CC0 1.0 Universal"));
  EXPECT_EQ(contents(folder_ / "corpus/VERSION"),
            std::string("corpus ") + conformance::kCorpusVersion + "\nformat 1.1\n");
}

}  // namespace
}  // namespace t4d::tools
