#include "conformance/driver/reader_suite.h"

#include <filesystem>
#include <fstream>
#include <map>
#include <set>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "conformance/driver/reader_report.h"
#include "platform/test_folder.h"

namespace t4d::conformance {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

constexpr const char* kAnswer = R"({"version": "1.0", "features": [], "bodies": []})";

/// Three cases for readers that are shell scripts: "good" must be answered, "bad" refused, and
/// truncated copies of "good" detected.
class ReaderSuite : public testing::Test {
 protected:
  void SetUp() override {
    good_.id = "valid/good";
    good_.bytes = "good";
    good_.fault = "A file.";
    bad_.id = "invalid/bad";
    bad_.bytes = "bad";
    bad_.fault = "It is <bad> & worse.";
    Trial trial;
    trial.about = "describe";
    trial.request = {"describe"};
    trial.wrongToRefuse = "the file is valid";
    trial.answer = {kAnswer, "[]"};
    cases_.push_back({good_.id, &good_, {trial}, {}});
    trial.wrongToRefuse.clear();
    trial.wrongToAccept = "it is bad";
    cases_.push_back({bad_.id, &bad_, {trial}, {}});
    cases_.push_back({"cut/good", &good_, {}, {}});
    for (std::size_t length = 0; length < 4; ++length) {
      trial.about = "cut to " + std::to_string(length) + " bytes";
      trial.damage = Cut{length};
      cases_.back().trials.push_back(trial);
    }
  }

  std::vector<ReaderResult> run(const std::string& script, SuiteOptions options = {}) {
    const fs::path reader = folder_ / "reader";
    std::ofstream(reader) << "#!/bin/sh\nanswer='" << kAnswer << "'\ntext=$(cat \"$1\")\n"
                          << script << "\n";
    fs::permissions(reader, fs::perms::owner_all);
    options.command = {reader.string()};
    options.parallel = 2;
    const auto results = runReaderCases(cases_, options);
    EXPECT_TRUE(results) << results.error().text();
    return results.value_or(std::vector<ReaderResult>{});
  }
  static std::vector<Outcome> outcomes(const std::vector<ReaderResult>& results) {
    std::vector<Outcome> all;
    for (const ReaderResult& result : results) all.push_back(result.outcome);
    return all;
  }

  static constexpr const char* kRight = R"([ x$text = xgood ] && echo "$answer")";

  platform::TestFolder folder_;
  CorpusFile good_;
  CorpusFile bad_;
  std::vector<ReaderCase> cases_;
};

TEST_F(ReaderSuite, ARightReaderPasses) {
  const auto results = run(kRight);
  EXPECT_THAT(outcomes(results), ElementsAre(Outcome::Passed, Outcome::Passed, Outcome::Passed));
  for (const ReaderResult& result : results) EXPECT_EQ(result.message, "");
  EXPECT_THAT(reportText("r", "t4d", false, cases_, results, 20), Not(HasSubstr("Look first")));
}

TEST_F(ReaderSuite, WrongReadersFailByTheRightCases) {
  const auto accepting = run(R"(echo "$answer")");
  EXPECT_THAT(outcomes(accepting), ElementsAre(Outcome::Passed, Outcome::Failed, Outcome::Failed));
  EXPECT_EQ(accepting[1].message, "describe: accepted, but it is bad");
  EXPECT_EQ(accepting[2].message,
            "cut to 0 bytes: accepted, but it is bad; also wrong: cut to 1 bytes, cut to 2 bytes, "
            "cut to 3 bytes (4 of 4 wrong)");
  const auto refusing = run("exit 1");
  EXPECT_THAT(outcomes(refusing), ElementsAre(Outcome::Failed, Outcome::Passed, Outcome::Passed));
  // A case takes the outcome of its worst trial.
  const auto crashing = run(R"(case x$text in
      xgood) echo "$answer" ;; xgoo) kill -ABRT $$ ;; xgo) echo "$answer" ;; *) exit 1 ;; esac)");
  EXPECT_THAT(outcomes(crashing), ElementsAre(Outcome::Passed, Outcome::Passed, Outcome::Crashed));
  EXPECT_THAT(crashing[2].message, StartsWith("cut to 3 bytes: ended by signal 6 (SIGABRT)"));
  EXPECT_THAT(crashing[2].message, HasSubstr("also wrong: cut to 2 bytes (2 of 4 wrong)"));
}

TEST_F(ReaderSuite, AReaderThatSleepsIsLeftAloneSoon) {
  SuiteOptions options;
  options.timeoutSeconds = 0.2;
  const auto results = run(R"([ x$text = xgood ] && echo "$answer" || sleep 60)", options);
  ASSERT_EQ(results.size(), 3U);
  EXPECT_EQ(results[1].outcome, Outcome::TimedOut);
  EXPECT_EQ(results[2].outcome, Outcome::TimedOut);
  EXPECT_THAT(results[2].message, HasSubstr(" not run)"));
}

TEST_F(ReaderSuite, StopsAtTheFirstFailureIfAsked) {
  SuiteOptions options;
  options.first = true;
  const auto results = run("exit 3", options);
  EXPECT_EQ(results[0].outcome, Outcome::Crashed);
  EXPECT_EQ(results[2].outcome, Outcome::Skipped);
}

TEST_F(ReaderSuite, SkipsWhatIsToBeSkippedAndWhatComesAfterAnInterruption) {
  cases_[1].skipped = "left out";
  EXPECT_THAT(outcomes(run(R"(echo "$answer")")),
              ElementsAre(Outcome::Passed, Outcome::Skipped, Outcome::Failed));
  const std::atomic<bool> stop = true;
  SuiteOptions options;
  options.stop = &stop;
  EXPECT_THAT(outcomes(run("sleep 60", options)),
              ElementsAre(Outcome::Skipped, Outcome::Skipped, Outcome::Skipped));
}

TEST_F(ReaderSuite, LeavesNoFiles) {
  const auto count = [] {
    std::size_t found = 0;
    for (const auto& entry : fs::directory_iterator(fs::temp_directory_path())) {
      found += entry.path().filename().string().starts_with("t4d-") ? 1 : 0;
    }
    return found;
  };
  const std::string before = std::getenv("TMPDIR") == nullptr ? "" : std::getenv("TMPDIR");
  setenv("TMPDIR", folder_.path().c_str(), 1);
  run(kRight);
  EXPECT_EQ(count(), 0U);
  before.empty() ? unsetenv("TMPDIR") : setenv("TMPDIR", before.c_str(), 1);
}

TEST_F(ReaderSuite, KeepsTheFilesThatWentWrong) {
  const auto results = run("kill -SEGV $$");
  const auto kept = keepWrongFiles(cases_, results, folder_ / "kept");
  ASSERT_TRUE(kept);
  EXPECT_EQ(*kept, 6U);
  std::string text;
  std::ifstream(folder_ / "kept/cut/good/cut-to-3-bytes.t4d") >> text;
  EXPECT_EQ(text, "goo");
  EXPECT_TRUE(fs::exists(folder_ / "kept/valid/good.t4d"));
  EXPECT_THAT(reportText("./r", "t4d", false, cases_, results, 20),
              HasSubstr("Look first at valid/good:\n  t4d conform copy corpus   # once\n"
                        "  ./r corpus/valid/good.t4d describe"));
}

TEST_F(ReaderSuite, ReportsInXmlThatHoldsWhateverAReaderSays) {
  cases_[2].skipped = "left out";
  const std::string xml =
      reportJunit("reader", "a \"b\" <c>",
                  reportsOf(cases_, run(R"(printf '<&"\001\377]]>' >&2; [ x$text = xbad ])")));
  EXPECT_THAT(xml, HasSubstr("name=\"t4d conform reader: a &quot;b&quot; &lt;c&gt;\" tests=\"3\" "
                             "failures=\"2\" errors=\"0\" skipped=\"1\""));
  EXPECT_THAT(xml, HasSubstr("it said: &lt;&amp;&quot;\\x01\\xff]]&gt;</failure>"));
  EXPECT_THAT(xml, HasSubstr("<testsuite name=\"cut\" tests=\"1\" failures=\"0\" errors=\"0\" "
                             "skipped=\"1\">\n    <testcase classname=\"t4d.cut\" name=\"good\""));
}

/// Runs the cases with a reader that serves: the script gets `$verb` and `$file` and prints a line.
class ServingSuite : public ReaderSuite {
 protected:
  std::vector<ReaderResult> serve(const std::string& script, SuiteOptions options = {}) {
    const fs::path reader = folder_ / "server";
    std::ofstream(reader) << "#!/bin/sh\n[ \"$1\" = --serve ] || exit 9\nanswer='accept " << kAnswer
                          << "'\necho started >>" << (folder_ / "starts").string()
                          << "\nwhile read -r verb file; do\ntext=$(cat \"$file\")\n"
                          << script << "\ndone\n";
    fs::permissions(reader, fs::perms::owner_all);
    options.command = {reader.string()};
    options.serve = true;
    const auto results = runReaderCases(cases_, options);
    EXPECT_TRUE(results) << results.error().text();
    return results.value_or(std::vector<ReaderResult>{});
  }
  int starts() const {
    const std::string lines = platform::contents(folder_ / "starts");
    return static_cast<int>(std::count(lines.begin(), lines.end(), '\n'));
  }

  static constexpr const char* kServed =
      R"(if [ x$text = xgood ]; then echo "$answer"; else echo "refuse because"; fi)";
};

TEST_F(ServingSuite, ARightReaderPassesInOneProcess) {
  const auto results = serve(kServed);
  EXPECT_THAT(outcomes(results), ElementsAre(Outcome::Passed, Outcome::Passed, Outcome::Passed));
  EXPECT_EQ(starts(), 1);
}

TEST_F(ServingSuite, WrongReadersFailByTheCasesOfThoseStartedEachTime) {
  const auto accepting = serve(R"(echo "$answer")");
  EXPECT_THAT(outcomes(accepting), ElementsAre(Outcome::Passed, Outcome::Failed, Outcome::Failed));
  EXPECT_EQ(accepting[1].message, "describe: accepted, but it is bad");
  EXPECT_THAT(accepting[2].message, HasSubstr("(4 of 4 wrong)"));
  const auto refusing = serve("echo refuse no file is any good");
  EXPECT_THAT(outcomes(refusing), ElementsAre(Outcome::Failed, Outcome::Passed, Outcome::Passed));
  EXPECT_EQ(refusing[0].message,
            "describe: refused, but the file is valid; it said: no file is any good");
}

TEST_F(ServingSuite, ChargesCrashesAndTimeoutsToTheirCases) {
  const auto crashing = serve(std::string("[ x$text = xbad ] && kill -SEGV $$\n") + kServed);
  EXPECT_THAT(outcomes(crashing), ElementsAre(Outcome::Passed, Outcome::Crashed, Outcome::Passed));
  EXPECT_THAT(crashing[1].message, StartsWith("describe: ended by signal 11 (SIGSEGV)"));
  const auto leaving = serve(std::string("[ x$text = xbad ] && exit 0\n") + kServed);
  EXPECT_THAT(outcomes(leaving), ElementsAre(Outcome::Passed, Outcome::Crashed, Outcome::Passed));
  EXPECT_THAT(leaving[1].message, HasSubstr("ended with exit code 0 instead of answering"));
  SuiteOptions options;
  options.timeoutSeconds = 0.2;
  const auto hanging = serve(std::string("[ x$text = xbad ] && sleep 60\n") + kServed, options);
  EXPECT_THAT(outcomes(hanging), ElementsAre(Outcome::Passed, Outcome::TimedOut, Outcome::Passed));
}

TEST_F(ServingSuite, RefusesWhatIsNoAnswer) {
  cases_.resize(1);
  for (const char* script : {"echo ok", "echo", "echo acceptable", "printf 'refuse'; exec >&-"}) {
    for (const ReaderResult& result : serve(script)) {
      EXPECT_EQ(result.outcome, Outcome::Crashed) << script << ": " << result.message;
    }
  }
  EXPECT_THAT(serve("echo ok")[0].message,
              HasSubstr("answered \"ok\", which is neither `accept JSON` nor `refuse WHY`"));
  EXPECT_THAT(serve("exec >&-; sleep 60")[0].message, HasSubstr("closed its standard output"));
}

TEST_F(ServingSuite, RefusesAnswersThatNobodyAskedFor) {
  const auto twice = serve(
      std::string("if [ x$text = xbad ]; then printf 'refuse\\nrefuse again\\n'; continue; fi\n") +
      kServed);
  EXPECT_THAT(outcomes(twice), ElementsAre(Outcome::Passed, Outcome::Crashed, Outcome::Passed));
  EXPECT_THAT(twice[1].message,
              HasSubstr("wrote more than one line for this request: \"refuse again"));
  // Replies written before any request.
  fs::permissions(folder_.write("early", "#!/bin/sh\nyes refuse\n"), fs::perms::owner_all);
  SuiteOptions options;
  options.command = {(folder_ / "early").string()};
  options.serve = true;
  const auto early = runReaderCases(cases_, options);
  ASSERT_TRUE(early);
  for (const ReaderResult& result : *early) EXPECT_NE(result.outcome, Outcome::Passed);
}

TEST_F(ServingSuite, SaysWhereAnEarlierRequestHasLeftSomething) {
  const auto results = serve(std::string("[ $seen ] && text=bad; seen=1\n") + kServed);
  EXPECT_THAT(outcomes(results), ElementsAre(Outcome::Passed, Outcome::Passed, Outcome::Passed));
  std::swap(cases_[0], cases_[1]);
  const auto swapped = serve(std::string("[ $seen ] && text=bad; seen=1\n") + kServed);
  EXPECT_EQ(swapped[1].outcome, Outcome::Failed);
  EXPECT_THAT(swapped[1].message, HasSubstr("a fresh process gets it right"));
}

TEST(ReaderCases, AreInOrderAndHaveNamesOfTheirOwn) {
  const std::vector<CorpusFile> files = makeCorpus();
  const std::vector<ReaderCase> cases = readerCases(files);
  std::set<std::string> ids;
  std::vector<std::string> kinds;
  for (const ReaderCase& test : cases) {
    EXPECT_TRUE(ids.insert(test.id).second) << test.id;
    EXPECT_FALSE(test.trials.empty()) << test.id;
    if (kinds.empty() || kinds.back() != kindOf(test.id)) kinds.push_back(kindOf(test.id));
    for (const Trial& trial : test.trials) {
      EXPECT_TRUE(trial.wrongToAccept.empty() || trial.wrongToRefuse.empty()) << test.id;
    }
  }
  EXPECT_EQ(std::set(kinds.begin(), kinds.end()).size(), kinds.size());
  EXPECT_EQ(kinds.front(), "valid");
  for (const CorpusFile& file : files) EXPECT_TRUE(ids.contains(file.id)) << file.id;
}

TEST(ReaderCases, ASliceThatReadsAnExchangedChunkMustBeRefused) {
  const std::vector<CorpusFile> files = makeCorpus();
  const std::vector<ReaderCase> cases = readerCases(files);
  for (const std::string part : {"slab", "connectivity", "layer", "pose", "end-mark"}) {
    const std::string id = "invalid/I2-" + part + "-exchanged";
    const auto test = std::ranges::find(cases, id, &ReaderCase::id);
    ASSERT_NE(test, cases.end()) << id;
    ASSERT_EQ(test->trials.size(), 2U) << id;
    EXPECT_EQ(test->trials[1].request[0], "slice") << id;
    EXPECT_THAT(test->trials[1].wrongToAccept, HasSubstr("rule I2 is broken")) << id;
  }
}

TEST(ReaderCases, OfAFeatureThatAReaderDoesNotKnowAreRefusals) {
  const std::vector<CorpusFile> files = makeCorpus();
  for (const std::string& feature : whatAReaderMayLack()) {
    if (feature == kHyperplanes) continue;
    SCOPED_TRACE(feature);
    int refusals = 0;
    for (const ReaderCase& test : readerCases(files, {.without = {feature}})) {
      const auto features = nlohmann::json::parse(
          test.file->describe ? test.file->describe->json : R"({"features": []})")["features"];
      if (std::find(features.begin(), features.end(), feature) == features.end()) continue;
      if (test.id != test.file->id) {
        EXPECT_NE(test.skipped, "") << test.id;
        continue;
      }
      ++refusals;
      ASSERT_EQ(test.trials.size(), 1U);
      EXPECT_THAT(test.trials[0].wrongToAccept, HasSubstr("names the feature " + feature));
      EXPECT_EQ(test.trials[0].wrongToRefuse, "");
    }
    EXPECT_GT(refusals, 0);
  }
}

TEST(ReaderCases, AQuickRunHasEveryRuleAndFeature) {
  const std::vector<CorpusFile> files = makeCorpus();
  std::set<std::string> rules;
  std::set<std::string> features;
  for (const CorpusFile& file : files) {
    if (file.validity == Validity::Invalid) rules.insert(file.rule);
    if (file.validity == Validity::Valid) {
      features.insert(file.features.begin(), file.features.end());
    }
  }
  std::set<std::string> kinds;
  std::size_t requests = 0;
  for (const ReaderCase& test : readerCases(files, {.without = {}, .quick = true})) {
    kinds.insert(kindOf(test.id));
    requests += test.trials.size();
    if (test.id != test.file->id) continue;
    rules.erase(test.file->rule);
    for (const std::string& feature : test.file->features) features.erase(feature);
  }
  EXPECT_TRUE(rules.empty()) << *rules.begin();
  EXPECT_TRUE(features.empty()) << *features.begin();
  EXPECT_THAT(kinds, ElementsAre("cut", "flip", "invalid", "overwrite", "valid"));
  EXPECT_LT(requests, 250U);
}

TEST(ReaderCases, AreChosenByGlobsAndFolders) {
  const std::vector<CorpusFile> files = makeCorpus();
  std::vector<ReaderCase> cases = readerCases(files);
  ASSERT_TRUE(selectCases(cases, {"valid/one-simplex*", "overwrite"}, {"*/one-simplex"}));
  for (const ReaderCase& test : cases) {
    EXPECT_TRUE(test.id.starts_with("valid/one-simplex") || test.id.starts_with("overwrite/"));
    EXPECT_EQ(test.skipped.empty(), !test.id.ends_with("/one-simplex")) << test.id;
  }
  EXPECT_THAT(selectCases(cases, {}, {"nothing/like*"}).error().text(),
              HasSubstr("no case is called nothing/like*"));
}

TEST(ReaderCases, AreChosenByNamesAndByWhatAShellMakesOfThem) {
  const std::vector<CorpusFile> files = makeCorpus();
  const auto chosen = [&](const std::string& pattern) {
    std::vector<ReaderCase> cases = readerCases(files);
    EXPECT_TRUE(selectCases(cases, {pattern}, {})) << pattern;
    return cases.size();
  };
  EXPECT_EQ(chosen("one-simplex"), 4U);  // in valid, cut, flip and overwrite
  EXPECT_EQ(chosen("valid/one-simplex.t4d"), 1U);
  EXPECT_EQ(chosen("invalid/"), chosen("invalid"));
}

TEST(ReaderCases, SomeMustBeLeft) {
  const std::vector<CorpusFile> files = makeCorpus();
  std::vector<ReaderCase> cases = readerCases(files);
  EXPECT_THAT(selectCases(cases, {"cut"}, {"cut"}).error().text(), HasSubstr("no case is left"));
}

/// A slice, too, must detect faults in what it reads.
TEST(ReaderCases, FilesAreSlicedWhereASliceMustBeRefused) {
  const std::vector<CorpusFile> files = makeCorpus();
  std::map<std::string, int> slices;
  for (const ReaderCase& test : readerCases(files)) {
    for (const Trial& trial : test.trials) {
      if (trial.request[0] == "slice" && !trial.wrongToAccept.empty()) {
        ++slices[test.id.substr(0, test.id.find('/'))];
        EXPECT_TRUE(trial.wrongToRefuse.empty());
      }
    }
  }
  EXPECT_GT(slices["invalid"], 250);
  EXPECT_GT(slices["cut"], 250);
  EXPECT_GT(slices["flip"], 250);
}

}  // namespace
}  // namespace t4d::conformance
