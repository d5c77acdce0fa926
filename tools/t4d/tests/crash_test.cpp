#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <fstream>
#include <functional>
#include <iostream>
#include <limits>
#include <random>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <sys/prctl.h>
#include <sys/wait.h>

#include "formats/t4d/test_slabs.h"
#include "platform/child_process.h"
#include "tools/t4d/tests/test_folder.h"

/// However writing ends, the target is the old file, the complete new file, or absent; and the part
/// that a killed program leaves behind can be recovered.
namespace t4d::tools {
namespace {

using Words = std::vector<std::string>;
using Seconds = std::chrono::duration<double>;

/// The end of a process, and its output.
struct Ended {
  int exitCode = -1;  // -1 if it was killed by a signal
  int signal = 0;
  std::string out;
  std::string err;
};

/// A folder with an input for each verb, and a folder `target` to write into.
class Crash : public InFolder {
 protected:
  void SetUp() override {
    InFolder::SetUp();
    fs::create_directory(folder_ / "target");
    copyFixtures(folder_ / "fx");
  }

  /// Starts a program in the folder. `before` is a line of a shell script, run in the same process.
  platform::ChildProcess start(const Words& words, const std::string& before = {}) const {
    Words all = {"/bin/sh", "-c",
                 "cd '" + folder_.path().string() + "'; " + before + " exec \"$@\"", "sh"};
    all.insert(all.end(), words.begin(), words.end());
    auto child = platform::ChildProcess::start(all, {});
    if (!child) throw std::runtime_error(child.error().text());
    return std::move(*child);
  }

  static Ended wait(platform::ChildProcess child) {
    child.wait(std::numeric_limits<double>::infinity());
    platform::ProgramRun run = child.finish();
    const bool exited = run.end == platform::ProgramRun::End::Exited;
    return {exited ? run.code : -1, exited ? 0 : run.code, std::move(run.output),
            std::move(run.message)};
  }

  static Words t4d(Words words) {
    words.insert(words.begin(), T4D_PROGRAM);
    return words;
  }
  Ended run(const Words& words, const std::string& before = {}) const {
    return wait(start(t4d(words), before));
  }

  Ended killed(const Words& words, Seconds after, int signal) const {
    platform::ChildProcess child = start(t4d(words));
    std::this_thread::sleep_for(after);
    ::kill(child.pid(), signal);
    return wait(std::move(child));
  }

  /// Kills it as soon as the part has `size` bytes, unless it exits first.
  Ended killedAtSize(const Words& words, std::uint64_t size) const {
    platform::ChildProcess child = start(t4d(words));
    fs::path part;
    std::error_code ignored;
    siginfo_t ended{};
    while (ended.si_pid == 0) {
      if (part.empty()) {
        if (const auto found = parts(); !found.empty()) part = found.front();
      }
      const std::uintmax_t now = fs::file_size(part, ignored);
      if (now != static_cast<std::uintmax_t>(-1) && now >= size) break;
      ::waitid(P_PID, static_cast<id_t>(child.pid()), &ended, WEXITED | WNOHANG | WNOWAIT);
    }
    ::kill(child.pid(), SIGKILL);
    return wait(std::move(child));
  }

  /// Sweeps a sphere along a screw motion in `steps` steps of equal hypervolume.
  static Words sweep(int steps, const std::string& output = "target/out.t4d") {
    return {"sweep",
            "fx/icosphere.obj",
            "-m",
            "fx/paper-screw.json",
            "--caps",
            "cone",
            "--steps",
            std::to_string(steps),
            "--prism",
            "3",
            "--compression",
            "0",
            "-o",
            output};
  }

  /// Makes a folder of grids and returns the command that weaves them.
  Words weave(const std::string& output = "target/out.t4d") const {
    const Ended made = run({"voxelize", "fx/torus.obj", "-m", "fx/paper-screw.json", "--voxel-size",
                            "0.7", "--frames", "24", "-o", "grids"});
    EXPECT_EQ(made.exitCode, 0) << made.err;
    return {"weave", "grids", "--compression", "0", "-o", output};
  }

  fs::path target() const { return folder_ / "target" / "out.t4d"; }

  /// The .part files in the target folder.
  std::vector<fs::path> parts() const {
    std::vector<fs::path> found;
    for (const auto& entry : fs::recursive_directory_iterator(folder_ / "target")) {
      if (entry.path().extension() == ".part") found.push_back(entry.path());
    }
    return found;
  }

  void clear() const {
    fs::remove_all(folder_ / "target");
    fs::create_directories(folder_ / "target");
  }
};

constexpr const char* kOld = "the old file";

/// What a command writes when it is not interrupted, and how long it takes.
struct Reference {
  std::string bytes;
  std::vector<formats::ChunkHeader> chunks;
  Seconds duration{0};

  /// The number of complete slabs in the first `size` bytes.
  std::uint64_t slabsBefore(std::size_t size) const {
    return static_cast<std::uint64_t>(
        std::count_if(chunks.begin(), chunks.end(), [&](const formats::ChunkHeader& chunk) {
          return chunk.name() == "SLAB" && chunk.end() <= size;
        }));
  }
};

class Killed : public Crash {
 protected:
  Reference referenceOf(const Words& words) const {
    Reference reference;
    for (int i = 0; i < 3; ++i) {
      const auto begin = std::chrono::steady_clock::now();
      const Ended done = run(words);
      const Seconds taken = std::chrono::steady_clock::now() - begin;
      reference.duration = i == 0 ? taken : std::min(reference.duration, taken);
      EXPECT_EQ(done.exitCode, 0) << done.err;
    }
    reference.bytes = contents(target());
    reference.chunks = formats::listChunks(reference.bytes);
    clear();
    return reference;
  }

  /// Recovers a part that was left. `hypervolumeOf` gives the hypervolume of that many slabs.
  void recoverPart(const fs::path& part, const Reference& reference,
                   const std::function<double(std::uint64_t)>& hypervolumeOf) {
    const std::string bytes = contents(part);
    ASSERT_TRUE(reference.bytes.starts_with(bytes));
    const std::uint64_t whole = reference.slabsBefore(bytes.size());
    const Ended recovered = run({"recover", part.string(), "-o", "recovered.t4d", "--json"});
    if (whole <= 1) {  // a cap alone encloses nothing
      EXPECT_EQ(recovered.exitCode, 4) << recovered.err;
      return;
    }
    EXPECT_EQ(recovered.exitCode, bytes.size() == reference.bytes.size() ? 0 : 3) << recovered.err;
    const json said = json::parse(recovered.out);
    EXPECT_EQ(said["slabs_saved"], whole);
    EXPECT_EQ(said["valid"], true);
    const double expected = hypervolumeOf(whole);
    if (expected > 0) {
      EXPECT_NEAR(said["hypervolume"].get<double>(), expected, expected * 1e-9);
    }
    ++recoveredParts_;
  }

  void killAtManyMoments(const Words& words, int times, unsigned seed,
                         const std::function<double(std::uint64_t)>& hypervolumeOf) {
    const Reference reference = referenceOf(words);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> moment(0, 1.1 * reference.duration.count());
    int done = 0;
    int none = 0;
    for (int i = 0; i < times; ++i) {
      const bool old = i % 2 == 1;
      const bool bySize = i % 4 >= 2;
      const Seconds after(moment(random));
      const std::uint64_t size = random() % reference.bytes.size();
      SCOPED_TRACE(bySize ? "killed at " + std::to_string(size) + " bytes"
                          : "killed after " + std::to_string(after.count()) + " s");
      clear();
      if (old) std::ofstream(target()) << kOld;
      const Ended ended = bySize ? killedAtSize(words, size) : killed(words, after, SIGKILL);
      EXPECT_TRUE(ended.exitCode == 0 || ended.signal == SIGKILL) << ended.err;
      const std::string found = contents(target());
      if (found == reference.bytes) {
        // It was renamed before it was killed.
        EXPECT_TRUE(parts().empty());
        ++done;
        continue;
      }
      EXPECT_NE(ended.exitCode, 0);
      EXPECT_EQ(fs::exists(target()), old);
      EXPECT_EQ(found, old ? kOld : "");
      const auto left = parts();
      ASSERT_LE(left.size(), 1U);
      if (left.empty()) {
        ++none;
      } else {
        recoverPart(left.front(), reference, hypervolumeOf);
      }
    }
    std::cout << "killed " << times << " times, half of them within "
              << 1.1 * reference.duration.count() << " s, half by the size of the part: " << none
              << " before it wrote, " << done << " after it was done; " << recoveredParts_
              << " parts with slabs recovered\n";
    // With fewer, this would have tested nothing.
    EXPECT_GT(recoveredParts_, times / 5);
  }

  int recoveredParts_ = 0;
};

TEST_F(Killed, ASweepLeavesTheOldFileOrNoneAndAPartThatIsRecovered) {
  constexpr int kSteps = 2000;
  ASSERT_EQ(run(sweep(kSteps)).exitCode, 0);
  const Ended judged = run({"validate", "target/out.t4d", "--json"});
  const double whole = json::parse(judged.out)["hypervolume"];
  killAtManyMoments(sweep(kSteps), 40, 1, [=](std::uint64_t slabs) {
    return whole * static_cast<double>(std::min<std::uint64_t>(slabs - 1, kSteps)) / kSteps;
  });
}

TEST_F(Killed, AWeaveLeavesTheOldFileOrNoneAndAPartThatIsRecovered) {
  killAtManyMoments(weave(), 20, 2, [](std::uint64_t) { return 0; });
}

using Signalled = Killed;

TEST_F(Signalled, ASweepLeavesNothingBehind) {
  const Words words = sweep(2000);
  const Reference reference = referenceOf(words);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> moment(0, 1.1 * reference.duration.count());
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    int ended = 0;
    for (int i = 0; i < 12; ++i) {
      const bool old = i % 2 == 1;
      const Seconds after(moment(random));
      SCOPED_TRACE(std::string(strsignal(signal)) + " after " + std::to_string(after.count()));
      clear();
      if (old) std::ofstream(target()) << kOld;
      const Ended done = killed(words, after, signal);
      EXPECT_TRUE(done.exitCode == 0 || done.signal == signal) << done.exitCode << done.err;
      EXPECT_TRUE(parts().empty());
      const std::string found = contents(target());
      if (found == reference.bytes) continue;
      ++ended;
      EXPECT_EQ(done.signal, signal);
      EXPECT_EQ(fs::exists(target()), old);
      EXPECT_EQ(found, old ? kOld : "");
    }
    EXPECT_GT(ended, 2);
  }
}

TEST_F(Signalled, AFolderOfFramesLeavesNoParts) {
  std::mt19937 random(4);
  const Words words = {"voxelize",     "fx/torus.obj", "-m",       "fx/paper-screw.json",
                       "--voxel-size", "0.5",          "--frames", "24",
                       "-o",           "target"};
  const auto begin = std::chrono::steady_clock::now();
  ASSERT_EQ(run(words).exitCode, 0);
  std::uniform_real_distribution<double> moment(
      0, Seconds(std::chrono::steady_clock::now() - begin).count());
  for (int i = 0; i < 12; ++i) {
    clear();
    const Ended done = killed(words, Seconds(moment(random)), SIGTERM);
    EXPECT_TRUE(done.exitCode == 0 || done.signal == SIGTERM) << done.err;
    EXPECT_TRUE(parts().empty());
  }
}

/// Ends a command at many moments. Neither its temporary folders, which are made in `target`, nor
/// any process that it started may remain.
class SignalledParent : public Signalled {
 protected:
  void endsWithAllItHasStarted(const Words& words, double seconds) {
    // Orphaned processes become our children.
    ASSERT_EQ(::prctl(PR_SET_CHILD_SUBREAPER, 1), 0);
    std::mt19937 random(6);
    std::uniform_real_distribution<double> moment(0, seconds);
    for (int i = 0; i < 12; ++i) {
      const int signal = i % 2 == 0 ? SIGINT : SIGTERM;
      const Seconds after(moment(random));
      SCOPED_TRACE(std::string(strsignal(signal)) + " after " + std::to_string(after.count()));
      platform::ChildProcess child = start(t4d(words), "export TMPDIR=\"$PWD/target\";");
      std::this_thread::sleep_for(after);
      ::kill(child.pid(), signal);
      const Ended done = wait(std::move(child));
      EXPECT_TRUE(done.exitCode == 0 || done.signal == signal) << done.exitCode << done.err;
      EXPECT_TRUE(fs::is_empty(folder_ / "target"));
      // A killed process may take a moment to end, and longer where the machine is busy.
      bool alive = true;
      for (int look = 0; look < 1000 && alive; ++look) {
        while (::waitpid(-1, nullptr, WNOHANG) > 0) {
        }
        alive = ::waitpid(-1, nullptr, WNOHANG) == 0;
        if (alive) std::this_thread::sleep_for(std::chrono::milliseconds(10));
      }
      EXPECT_FALSE(alive);
      clear();
    }
    ::prctl(PR_SET_CHILD_SUBREAPER, 0);
  }
};

TEST_F(SignalledParent, ACompareEndsItsSweeps) {
  endsWithAllItHasStarted({"compare", "fx/torus.obj", "-m", "fx/paper-screw.json", "--voxel-size",
                           "0.3", "--frames", "200", "--steps", "500", "--caps", "cone"},
                          1.5);
}

TEST_F(SignalledParent, ConformEndsTheBackendProgram) {
  const std::string slow = writeScript("slow", "sleep 60 & wait");
  endsWithAllItHasStarted({"conform", "backends", "--backend-program", slow}, 0.5);
}

TEST_F(Signalled, AFolderThatWasMadeGoes) {
  const Words words = {"voxelize",     "fx/torus.obj", "-m",       "fx/paper-screw.json",
                       "--voxel-size", "0.1",          "--frames", "500",
                       "-o",           "target/made"};
  platform::ChildProcess child = start(t4d(words));
  while (parts().empty()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  ::kill(child.pid(), SIGINT);
  EXPECT_EQ(wait(std::move(child)).signal, SIGINT);
  EXPECT_TRUE(fs::is_empty(folder_ / "target"));
}

TEST_F(Signalled, WhatIgnoresTheSignalGoesOn) {
  const Words words = sweep(2000);
  const Reference reference = referenceOf(words);
  platform::ChildProcess child = start(t4d(words), "trap '' HUP;");
  std::this_thread::sleep_for(reference.duration / 2);
  ::kill(child.pid(), SIGHUP);
  const Ended done = wait(std::move(child));
  EXPECT_EQ(done.exitCode, 0) << done.signal << done.err;
  EXPECT_EQ(contents(target()), reference.bytes);
}

/// Commands that write more than a megabyte into the folder `target`.
class Full : public Crash {
 protected:
  std::vector<Words> commands() const {
    EXPECT_EQ(run(sweep(5000, "swept.t4d")).exitCode, 0);
    const std::string swept = contents(folder_ / "swept.t4d");
    write("broken.t4d", swept.substr(0, swept.size() - swept.size() / 5));
    return {sweep(5000),
            weave(),
            {"recover", "broken.t4d", "-o", "target/out.t4d"},
            {"flipbook", "swept.t4d", "--frames", "200", "-o", "target/out.glb"},
            {"flipbook", "swept.t4d", "--frames", "100", "-o", "target/out.usda"},
            {"voxelize", "fx/torus.obj", "-m", "fx/paper-screw.json", "--voxel-size", "0.25",
             "--frames", "24", "-o", "target"}};
  }

  static void expectRefusal(const Ended& ended, const Words& words, const std::string& reason) {
    EXPECT_EQ(ended.exitCode, 1) << ended.signal << ended.err;
    EXPECT_THAT(ended.err, testing::HasSubstr(reason));
    // In a folder, the error names the file that did not fit.
    const std::string named = words.back() == "target" ? "target/frame_" : words.back();
    EXPECT_THAT(ended.err, testing::HasSubstr(named));
  }
};

TEST_F(Full, ASmallFileSystemKeepsTheOldFileAndNothingElse) {
  // A file system that only this process and its children see, if the kernel permits one.
  const auto inNamespace = [](const std::string& script, const Words& words) {
    Words all = {"unshare", "-rm", "sh", "-c", script, "sh"};
    all.insert(all.end(), words.begin(), words.end());
    return all;
  };
  const std::string mount = "mount -t tmpfs -o size=1m tmpfs target && ";
  if (wait(start(inNamespace(mount + "true", {}))).exitCode != 0) {
    GTEST_SKIP() << "no file systems of our own here; the limit on the size of a file is tried";
  }
  std::cout << "a tmpfs of 1 MB\n";
  for (const Words& words : commands()) {
    SCOPED_TRACE(testing::PrintToString(words));
    fs::remove_all(folder_ / "left");
    const Ended ended = wait(start(inNamespace(
        mount +
            "printf old > target/out.t4d && { \"$@\"; code=$?; cp -a target left; exit $code; }",
        t4d(words))));
    expectRefusal(ended, words, "No space left on device");
    EXPECT_EQ(contents(folder_ / "left" / "out.t4d"), "old");
    EXPECT_EQ(std::distance(fs::directory_iterator(folder_ / "left"), {}), 1);
  }
}

TEST_F(Full, ALimitOnTheSizeOfAFileKeepsTheOldFileAndNothingElse) {
  for (const Words& words : commands()) {
    SCOPED_TRACE(testing::PrintToString(words));
    if (words.back() == "target") continue;  // its files are small
    clear();
    std::ofstream(target()) << kOld;
    const Ended ended = run(words, "ulimit -f 2048;");  // blocks of 512 bytes
    expectRefusal(ended, words, "File too large");
    EXPECT_EQ(contents(target()), kOld);
    EXPECT_EQ(std::distance(fs::directory_iterator(folder_ / "target"), {}), 1);
  }
}

using FailingDisk = Crash;

/// Makes the disk fail from the first write operation in the target folder onwards, then from the
/// second, and so on, until the command succeeds.
TEST_F(FailingDisk, NeverLeavesAWrongFile) {
  const std::string output = target().string();
  const Words words = sweep(300, output);
  ASSERT_EQ(run(words).exitCode, 0);
  const std::string whole = contents(target());
  for (const int reason : {ENOSPC, EIO, EROFS}) {
    for (const bool old : {false, true}) {
      for (int from = 1;; ++from) {
        SCOPED_TRACE(std::string(std::strerror(reason)) + " from call " + std::to_string(from));
        clear();
        if (old) std::ofstream(target()) << kOld;
        // AddressSanitizer otherwise insists on being the first library.
        const Ended ended = run(words, "export LD_PRELOAD='" T4D_FAILING_DISK
                                       "' ASAN_OPTIONS=verify_asan_link_order=0 "
                                       "T4D_FAIL_FOLDER=\"$PWD/target\" T4D_FAIL_FROM=" +
                                           std::to_string(from) +
                                           " T4D_FAIL_ERRNO=" + std::to_string(reason) + ";");
        const std::string found = contents(target());
        if (ended.exitCode == 0) {
          EXPECT_EQ(found, whole);
          // Open, write a megabyte at a time, sync, rename, sync the folder.
          EXPECT_GT(from, 1 + static_cast<int>(whole.size() >> 20) + 3);
          break;
        }
        ASSERT_LT(from, 1000);
        EXPECT_EQ(ended.exitCode, 1) << ended.signal << ended.err;
        EXPECT_THAT(ended.err, testing::HasSubstr(output));
        EXPECT_THAT(ended.err, testing::HasSubstr(std::strerror(reason)));
        if (found == whole) {
          // Only the new name might not survive a power failure.
          EXPECT_THAT(ended.err, testing::HasSubstr("cannot sync the directory"));
        } else {
          EXPECT_EQ(fs::exists(target()), old);
          EXPECT_EQ(found, old ? kOld : "");
        }
        // Nothing can be removed from a disk that became read-only.
        EXPECT_TRUE(reason == EROFS || parts().empty());
      }
    }
  }
}

}  // namespace
}  // namespace t4d::tools
