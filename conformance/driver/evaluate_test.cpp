#include "conformance/driver/evaluate.h"

#include <csignal>

#include <gmock/gmock.h>

#include "conformance/driver/plain_text.h"

namespace t4d::conformance {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

Reply exited(int code, const std::string& output = "", const std::string& message = "") {
  platform::ProgramRun run;
  run.code = code;
  run.output = output;
  run.message = message;
  return replyOf(run);
}

/// The message for a reply; "" if it is right.
std::string said(const Trial& trial, const Reply& reply) {
  return evaluate(trial, reply, "/tmp/x/3.t4d", 10).message;
}

Trial valid() {
  Trial trial;
  trial.request = {"describe"};
  trial.wrongToRefuse = "the file is valid";
  trial.answer = {R"({"version": "1.0", "bodies": [{"name": "a", "vertices": "14"}]})", "[{}]"};
  return trial;
}

Trial damaged() {
  Trial trial;
  trial.request = {"describe"};
  trial.wrongToAccept = "rule H2 is broken at byte 20: The checksum is wrong.";
  return trial;
}

TEST(Evaluate, TakesTheAnswerWithWhateverElseIsInIt) {
  EXPECT_EQ(said(valid(), exited(0, valid().answer.json)), "");
  EXPECT_EQ(said(valid(), exited(0, R"( {"more": [1], "version": "1.0",
      "bodies": [{"name": "a", "vertices": "14"}]} )")),
            "");
}

TEST(Evaluate, NamesTheMemberThatIsWrong) {
  EXPECT_EQ(said(valid(), exited(0, R"({"version": "1.0",
                                        "bodies": [{"name": "a", "vertices": "12"}]})")),
            "bodies[0].vertices is \"12\", not \"14\"");
  EXPECT_EQ(said(valid(), exited(0, "[]")), "the answer is not an object");
}

TEST(Evaluate, ShowsWhatIsPrintedInsteadOfJson) {
  EXPECT_EQ(said(valid(), exited(0, "14 vertices\n\x1b[0m")),
            "accepted, but what it printed is not one JSON object: wrong from byte 3, "
            "\"vertices\\n\\x1b[0m\"");
  EXPECT_EQ(said(valid(), exited(0, " \n")), "accepted, but it printed nothing");
  EXPECT_THAT(said(valid(), exited(0, std::string(100000, 'x'))), HasSubstr("xxx...\""));
  EXPECT_THAT(said(valid(), exited(0, R"({"version": 1} and more)")),
              HasSubstr("wrong from byte 15, \"and more"));
}

TEST(Evaluate, SaysWhyAFileMustBeAcceptedOrRefused) {
  EXPECT_EQ(said(damaged(), exited(0)),
            "accepted, but rule H2 is broken at byte 20: The checksum is wrong.");
  EXPECT_EQ(said(damaged(), exited(1)), "");
  EXPECT_EQ(said(valid(), exited(1, "", "reading\n/tmp/x/3.t4d: bad\n")),
            "refused, but the file is valid; it said: reading\\nFILE: bad");
  EXPECT_THAT(said(valid(), exited(1)), HasSubstr("it said nothing"));
}

TEST(Evaluate, LeavesToReadersWhatTheyMayDecide) {
  Trial either = valid();
  either.wrongToRefuse.clear();
  EXPECT_EQ(said(either, exited(1)), "");
  EXPECT_EQ(said(either, exited(0, either.answer.json)), "");
  EXPECT_THAT(said(either, exited(0, "{}")), HasSubstr("version is missing"));
  either.answer = {};
  EXPECT_EQ(said(either, exited(0, "anything")), "");
}

TEST(Evaluate, TellsCrashesFromRefusals) {
  platform::ProgramRun run;
  run.code = SIGSEGV;
  run.message = "one\ntwo\nthree\nfour\n";
  run.end = platform::ProgramRun::End::Signalled;
  TrialResult result = evaluate(damaged(), replyOf(run), "x", 10);
  EXPECT_EQ(result.outcome, Outcome::Crashed);
  EXPECT_EQ(result.message, "ended by signal 11 (SIGSEGV); it said: two\\nthree\\nfour");
  result = evaluate(damaged(), exited(3), "x", 10);
  EXPECT_EQ(result.outcome, Outcome::Crashed);
  EXPECT_THAT(result.message, StartsWith("ended with exit code 3"));
  run.end = platform::ProgramRun::End::TimedOut;
  result = evaluate(damaged(), replyOf(run), "x", 10);
  EXPECT_EQ(result.outcome, Outcome::TimedOut);
  EXPECT_THAT(result.message, StartsWith("no answer within 10 s of processor time"));
}

TEST(PlainText, KeepsTextAndEscapesTheRest) {
  EXPECT_EQ(plain("a \"b\" Kör\u00e9per \U0001F600"), "a \"b\" Kör\u00e9per \U0001F600");
  EXPECT_EQ(plain(std::string("\0\t\n\x7f", 4)), "\\x00\\x09\\n\\x7f");
  // A lone byte, an overlong slash, a surrogate, U+FFFF, beyond the last code point, a truncated
  // sequence.
  EXPECT_EQ(plain("\x80"), "\\x80");
  EXPECT_EQ(plain("\xc0\xaf"), "\\xc0\\xaf");
  EXPECT_EQ(plain("\xed\xa0\x80"), "\\xed\\xa0\\x80");
  EXPECT_EQ(plain("\xef\xbf\xbf"), "\\xef\\xbf\\xbf");
  EXPECT_EQ(plain("\xf4\x90\x80\x80"), "\\xf4\\x90\\x80\\x80");
  EXPECT_EQ(plain("\xe2\x82"), "\\xe2\\x82");
  EXPECT_EQ(plain("abcdef", 3), "abc...");
}

}  // namespace
}  // namespace t4d::conformance
