#include "platform/cleanup.h"

#include <atomic>
#include <chrono>
#include <csignal>
#include <fstream>
#include <string>
#include <thread>

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include "platform/temporary_folder.h"
#include "platform/test_folder.h"

namespace t4d::platform {
namespace {

namespace fs = std::filesystem;

class Cleanups : public testing::Test {
 protected:
  void SetUp() override {
    fs::create_directories(folder_ / "a" / "b" / "c");
    folder_.write("a/file", "text");
    folder_.write("a/b/c/file", "text");
  }

  /// A child that sleeps, in a process group of its own.
  static pid_t sleeper(bool stubborn) {
    // It is so from its first moment on.
    const auto before = std::signal(SIGTERM, stubborn ? SIG_IGN : SIG_DFL);
    const pid_t child = ::fork();
    if (child != 0) {
      std::signal(SIGTERM, before);
      ::setpgid(child, child);
      return child;
    }
    ::setpgid(0, 0);
    ::execlp("sleep", "sleep", "60", nullptr);
    ::_exit(127);
  }

  static int signalOf(pid_t child) {
    int status = 0;
    ::waitpid(child, &status, 0);
    return WIFSIGNALED(status) ? WTERMSIG(status) : 0;
  }

  TestFolder folder_;
};

TEST_F(Cleanups, RemoveAFolderWithAllThatIsInIt) {
  for (int i = 0; i < 500; ++i) {
    std::ofstream(folder_ / "a" / ("a file with a long name " + std::to_string(i))) << i;
  }
  fs::create_directory_symlink("/", folder_ / "a" / "link");
  const Cleanup note = Cleanup::folder(folder_ / "a");
  cleanUp();
  EXPECT_FALSE(fs::exists(folder_ / "a"));
  EXPECT_TRUE(fs::exists(folder_.path()));
}

TEST_F(Cleanups, RemoveAnEmptyFolderAfterItsFiles) {
  const Cleanup outer = Cleanup::emptyFolder(folder_ / "a" / "b" / "c");
  const Cleanup full = Cleanup::emptyFolder(folder_ / "a");
  const Cleanup file = Cleanup::file(folder_ / "a" / "b" / "c" / "file");
  cleanUp();
  EXPECT_FALSE(fs::exists(folder_ / "a" / "b" / "c"));
  EXPECT_TRUE(fs::exists(folder_ / "a" / "file"));
}

TEST_F(Cleanups, LeaveWhatTheyHaveBeenReleasedFrom) {
  Cleanup released = Cleanup::folder(folder_ / "a");
  Cleanup moved = std::move(released);
  moved.release();
  { const Cleanup gone = Cleanup::folder(folder_ / "a"); }
  cleanUp();
  EXPECT_TRUE(fs::exists(folder_ / "a" / "b" / "c" / "file"));
}

TEST_F(Cleanups, OfAForkLeaveWhatItsParentHas) {
  const Cleanup file = Cleanup::file(folder_ / "a" / "file");
  const pid_t child = ::fork();
  if (child == 0) {
    const Cleanup own = Cleanup::file(folder_ / "a" / "b" / "c" / "file");
    cleanUp();
    ::_exit(0);
  }
  ::waitpid(child, nullptr, 0);
  EXPECT_TRUE(fs::exists(folder_ / "a" / "file"));
  EXPECT_FALSE(fs::exists(folder_ / "a" / "b" / "c" / "file"));
}

TEST_F(Cleanups, EndProcessesAlsoThoseThatWillNot) {
  const pid_t willing = sleeper(false);
  const pid_t stubborn = sleeper(true);
  Cleanup one;
  Cleanup group;
  {
    const HeldCleanup held;
    one = Cleanup::process(held, willing);
    group = Cleanup::process(held, -stubborn);
  }
  cleanUp();
  const int willingBy = signalOf(willing);
  EXPECT_TRUE(willingBy == SIGTERM || willingBy == SIGKILL) << willingBy;
  EXPECT_EQ(signalOf(stubborn), SIGKILL);
}

/// Another thread that finds its child ended may go on to the next of its work.
TEST_F(Cleanups, LetNothingBeginBeforeTheyAreDone) {
  const pid_t stubborn = sleeper(true);
  Cleanup note;
  {
    const HeldCleanup held;
    note = Cleanup::process(held, -stubborn);
  }
  using Clock = std::chrono::steady_clock;
  const Clock::time_point begin = Clock::now();
  Clock::time_point made;
  std::thread other([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    EXPECT_TRUE(TemporaryFolder::createIn(folder_.path()));
    made = Clock::now();
  });
  cleanUp();
  const Clock::duration taken = Clock::now() - begin;
  other.join();
  EXPECT_EQ(signalOf(stubborn), SIGKILL);
  EXPECT_GT(made - begin, taken / 2);  // it would be a fifth
}

TEST_F(Cleanups, WaitForAProcessThatIsBeingStarted) {
  std::atomic<bool> begun = false;
  std::atomic<pid_t> started = 0;
  Cleanup note;
  std::thread other([&] {
    const HeldCleanup held;
    begun = true;
    const pid_t child = sleeper(false);
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    note = Cleanup::process(held, child);
    started = child;
  });
  while (!begun) std::this_thread::yield();
  cleanUp();
  EXPECT_NE(started, 0);
  other.join();
  EXPECT_NE(signalOf(started), 0);
}

TEST_F(Cleanups, TakeNoSignalsWhileAProcessIsStarted) {
  sigset_t blocked;
  {
    const HeldCleanup held;
    pthread_sigmask(SIG_SETMASK, nullptr, &blocked);
    EXPECT_EQ(sigismember(&blocked, SIGTERM), 1);
  }
  pthread_sigmask(SIG_SETMASK, nullptr, &blocked);
  EXPECT_EQ(sigismember(&blocked, SIGTERM), 0);
}

}  // namespace
}  // namespace t4d::platform
