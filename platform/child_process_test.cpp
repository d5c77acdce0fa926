#include "platform/child_process.h"

#include <atomic>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <thread>

#include <gmock/gmock.h>
#include <sys/wait.h>

#include "platform/test_folder.h"

namespace t4d::platform {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;

ProgramRun shell(const std::string& script, const RunOptions& options = {}) {
  const auto run = runProgram({"/bin/sh", "-c", script}, options);
  EXPECT_TRUE(run) << run.error().text();
  return run.value_or(ProgramRun{});
}

/// A folder of its own, which is the current one while the test runs.
class SplitCommand : public testing::Test {
 protected:
  void SetUp() override {
    before_ = fs::current_path();
    fs::current_path(folder_.path());
  }
  void TearDown() override { fs::current_path(before_); }
  void write(const std::string& name, const std::string& text, bool executable) {
    const fs::path path = folder_.write(name, text);
    if (executable) fs::permissions(path, fs::perms::owner_all);
  }
  std::string fault(const std::string& command) {
    const auto words = splitCommand(command);
    return words ? "none" : words.error().text();
  }

  TestFolder folder_;
  fs::path before_;
};

int openDescriptors() {
  return static_cast<int>(std::distance(fs::directory_iterator("/proc/self/fd"), {}));
}

TEST(RunProgram, ExitCodeAndBothStreamsComeBack) {
  const ProgramRun run = shell("echo answer; echo why >&2; exit 7");
  EXPECT_EQ(run.end, ProgramRun::End::Exited);
  EXPECT_EQ(run.code, 7);
  EXPECT_EQ(run.output, "answer\n");
  EXPECT_EQ(run.message, "why\n");
  EXPECT_EQ(shell("exit 0").code, 0);
}

TEST(RunProgram, SignalsAreToldFromExitCodes) {
  const ProgramRun run = shell("echo before; kill -SEGV $$");
  EXPECT_EQ(run.end, ProgramRun::End::Signalled);
  EXPECT_EQ(run.code, SIGSEGV);
  EXPECT_EQ(run.output, "before\n");
  EXPECT_EQ(shell("exit 139").end, ProgramRun::End::Exited);
}

/// Gone, or a zombie that nobody has waited for.
bool hasEnded(int process) {
  std::ifstream stat("/proc/" + std::to_string(process) + "/stat");
  std::string state;
  return !(stat >> state >> state >> state) || state == "Z";
}

TEST(RunProgram, WhatTakesTooLongIsEndedWithAllThatItStarted) {
  RunOptions options;
  options.limit = 1;
  const ProgramRun run = shell("trap '' TERM; sleep 600 & echo $!; wait", options);
  EXPECT_EQ(run.end, ProgramRun::End::TimedOut);
  EXPECT_GE(run.seconds, 1);
  const int started = std::stoi(run.output);
  // It is killed, not waited for: nobody but its parent can.
  for (int tries = 0; tries < 1000 && !hasEnded(started); ++tries) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  EXPECT_TRUE(hasEnded(started));
}

TEST(RunProgram, ALimitOfProcessorTimeCountsWhatTheProgramComputes) {
  RunOptions options;
  options.limit = TimeLimit::ofProcessor(0.2);
  // Time that passes is not counted, as long as it is not ten times as much.
  const ProgramRun sleeping = shell("sleep 0.5; echo late", options);
  EXPECT_EQ(sleeping.end, ProgramRun::End::Exited);
  EXPECT_EQ(sleeping.output, "late\n");
  options.limit.seconds = 60;
  const ProgramRun busy = shell("while :; do :; done", options);
  EXPECT_EQ(busy.end, ProgramRun::End::TimedOut);
  EXPECT_LT(busy.seconds, 30);
  options.limit = TimeLimit::ofProcessor(0.05);
  EXPECT_EQ(shell("sleep 60", options).end, ProgramRun::End::TimedOut);
}

TEST(RunProgram, WhatItLeavesBehindIsNotWaitedFor) {
  const ProgramRun run = shell("sleep 60 & echo done");
  EXPECT_EQ(run.end, ProgramRun::End::Exited);
  EXPECT_EQ(run.output, "done\n");
  EXPECT_LT(run.seconds, 30);
}

TEST(RunProgram, OutputWithoutEndIsTakenUpToALimit) {
  RunOptions options;
  options.outputBytes = 1000;
  const ProgramRun run =
      shell("head -c 3000000 /dev/zero; head -c 3000000 /dev/zero >&2; exit 1", options);
  EXPECT_EQ(run.code, 1);
  EXPECT_EQ(run.output.size(), 1000U);
  EXPECT_EQ(run.message.size(), 1000U);
  EXPECT_EQ(shell("head -c 3000000 /dev/zero").output.size(), 3000000U);
}

TEST(RunProgram, StreamsThatAreClosedDoNotEndIt) {
  const ProgramRun run = shell("exec >&- 2>&-; sleep 0.2; exit 5");
  EXPECT_EQ(run.end, ProgramRun::End::Exited);
  EXPECT_EQ(run.code, 5);
}

TEST(RunProgram, StandardInputIsEmptyAndNothingElseIsOpen) {
  EXPECT_EQ(shell("cat; echo end").output, "end\n");
  const int before = openDescriptors();
  EXPECT_EQ(shell("ls /proc/self/fd | wc -l").output, "4\n");  // three, and that of the folder
  EXPECT_EQ(openDescriptors(), before);
}

TEST(RunProgram, IsEndedOnRequest) {
  std::atomic<bool> stop = false;
  RunOptions options;
  options.stop = &stop;
  options.limit = 60;
  std::thread later([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    stop = true;
  });
  const ProgramRun run = shell("sleep 60", options);
  later.join();
  EXPECT_EQ(run.end, ProgramRun::End::Stopped);
  EXPECT_LT(run.seconds, 30);
}

TEST(RunProgram, ManyRunAtATimeAndNoneIsLeft) {
  std::atomic<int> right = 0;
  std::vector<std::thread> threads;
  for (int i = 0; i < 8; ++i) {
    threads.emplace_back([&right, i] {
      for (int j = 0; j < 25; ++j) {
        const std::string word = std::to_string(100 * i + j);
        const auto run = runProgram({"/bin/sh", "-c", "echo " + word + "; exit " + word});
        if (run && run->output == word + "\n" && run->code == (100 * i + j) % 256) ++right;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(right, 200);
  EXPECT_EQ(waitpid(-1, nullptr, WNOHANG), -1);
  EXPECT_EQ(errno, ECHILD);
}

TEST(RunProgram, TimesOutWhileItPrintsWithoutEnd) {
  const ProgramRun run = shell("yes", {.limit = 0.3, .outputBytes = 1000});
  EXPECT_EQ(run.end, ProgramRun::End::TimedOut);
  EXPECT_LT(run.seconds, 30);
}

/// A program that prints each line that it is sent in capitals.
ChildProcess capitals(const std::string& before = {}) {
  const std::string script = before + "while read -r line; do echo $line | tr a-z A-Z; done";
  auto child = ChildProcess::start({"/bin/sh", "-c", script}, {.pipeInput = true});
  EXPECT_TRUE(child);
  return std::move(*child);
}

TEST(ChildProcess, AnswersLineByLine) {
  const int before = openDescriptors();
  {
    ChildProcess child = capitals();
    for (const char* word : {"one", "two"}) {
      ASSERT_TRUE(child.send(std::string(word) + "\n"));
      const auto line = [&] { return child.output().find('\n') != std::string::npos; };
      EXPECT_EQ(child.wait(30, nullptr, line), ChildProcess::Wait::Done);
    }
    EXPECT_EQ(child.output(), "ONE\nTWO\n");
    EXPECT_EQ(child.wait(0), ChildProcess::Wait::TimedOut);
  }
  EXPECT_EQ(openDescriptors(), before);
  EXPECT_EQ(waitpid(-1, nullptr, WNOHANG), -1);
}

TEST(ChildProcess, WhatItDoesNotReadDoesNotBlockOrEndUs) {
  ChildProcess closed = capitals("exec <&-; sleep 60; ");
  while (closed.send("word\n")) {  // until it has closed it
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  ChildProcess deaf = capitals("sleep 60; ");
  EXPECT_FALSE(deaf.send(std::string(std::size_t{1} << 20, 'x')));
  EXPECT_EQ(deaf.finish().end, ProgramRun::End::Signalled);
}

TEST(RunSelf, RunsThisProgramWithOtherArguments) {
  const auto run = runSelf({"--gtest_list_tests", "--gtest_filter=RunSelf.*"});
  ASSERT_TRUE(run);
  EXPECT_EQ(run->code, 0);
  EXPECT_THAT(run->output, HasSubstr("RunsThisProgramWithOtherArguments"));
}

TEST_F(SplitCommand, IsTakenApartAsAShellDoes) {
  write("my reader", "#!/bin/sh\n", true);
  write("reader", "#!/bin/sh\n", true);
  EXPECT_THAT(*splitCommand("./reader"), ElementsAre("./reader"));
  EXPECT_THAT(*splitCommand("./my reader"), ElementsAre("./my reader"));
  EXPECT_THAT(*splitCommand(" ./reader  -a 'b c' \"d 'e'\" f\\ g '' "),
              ElementsAre("./reader", "-a", "b c", "d 'e'", "f g", ""));
  EXPECT_THAT(*splitCommand("sh -x"), ElementsAre(HasSubstr("/sh"), "-x"));
}

TEST_F(SplitCommand, SaysWhatToDoWhereItCannotBeRun) {
  write("reader.py", "print()\n", false);
  write("local", "#!/bin/sh\n", true);
  EXPECT_EQ(fault("./none"), "./none: is not there");
  EXPECT_THAT(fault("./reader.py"), HasSubstr("`chmod +x ./reader.py`"));
  EXPECT_THAT(fault("/"), HasSubstr("is not a file"));
  EXPECT_THAT(fault("no-such-program-anywhere"), HasSubstr("is not in PATH"));
  EXPECT_THAT(fault("local"), HasSubstr("./local"));
  EXPECT_THAT(fault("'./reader.py"), HasSubstr("quote"));
  EXPECT_THAT(fault("  "), HasSubstr("empty"));
}

TEST_F(SplitCommand, SaysWhyItCannotBeStarted) {
  write("no-interpreter", "#!/no/such/python\n", true);
  write("no-first-line", "print()\n", true);
  auto run = runProgram({"./no-interpreter"});
  ASSERT_FALSE(run);
  EXPECT_EQ(run.error().code, ErrorCode::InvalidInput);
  EXPECT_THAT(run.error().text(), HasSubstr("interpreter"));
  run = runProgram({"./no-first-line"});
  ASSERT_FALSE(run);
  EXPECT_THAT(run.error().text(), HasSubstr("#!/usr/bin/env python3"));
}

}  // namespace
}  // namespace t4d::platform
