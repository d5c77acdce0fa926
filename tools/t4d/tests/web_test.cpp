#include <fstream>
#include <optional>
#include <string>
#include <vector>

#include <gmock/gmock.h>

#include "platform/child_process.h"
#include "platform/test_folder.h"
#include "tests/web_server.h"
#include "tools/t4d/tests/test_folder.h"

/// Files on a web server, from the user's point of view: the same results as from a local file with
/// few requests, and a reason where a server is at fault.
namespace t4d::tools {
namespace {

using formats::WebServer;
using testing::Each;
using testing::HasSubstr;
using testing::Not;

platform::ProgramRun t4d(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), T4D_PROGRAM);
  auto run = platform::runProgram(arguments);
  EXPECT_TRUE(run);
  return run ? *run : platform::ProgramRun{};
}

json answer(std::vector<std::string> arguments) {
  arguments.emplace_back("--json");
  const auto run = t4d(std::move(arguments));
  EXPECT_EQ(run.code, 0) << run.message;
  return json::parse(run.output, nullptr, false);
}

class Web : public testing::Test {
 protected:
  /// The bolt, and a woven torus with slabs of several hundred kB.
  static void SetUpTestSuite() {
    folder_.emplace();
    copyFixtures(at("fx"));
    const auto made = [](const std::string& solid, const std::string& motion,
                         const std::string& name, std::vector<std::string> more) {
      more.insert(more.begin(), {"sweep", at("fx/" + solid + ".obj"), "--motion",
                                 at("fx/" + motion + ".json"), "-o", at(name)});
      const auto run = t4d(more);
      ASSERT_EQ(run.code, 0) << run.message;
    };
    made("bolt", "screw-in", "bolt.t4d", {"--caps", "cone"});
    made("paper-cube", "paper-translation", "cube.t4d", {"--caps", "cone"});
    made("torus", "several-segments", "torus.t4d",
         {"--backend", "voxel4d", "--voxel-size", "0.5", "--frames", "30"});
  }
  static void TearDownTestSuite() { folder_.reset(); }

  static std::string at(const std::string& name) { return (*folder_ / name).string(); }

  /// Cuts the local file and the one of the server: the same bytes and numbers. Returns what
  /// --json says of the latter.
  json cutBoth(const std::string& name, const std::vector<std::string>& how,
               const std::string& fault = "plain") {
    std::vector<std::string> local = {"slice", at(name), "-o", at("local.ply")};
    std::vector<std::string> remote = {"slice", server_.url(fault + "/" + name), "-o",
                                       at("remote.ply")};
    for (auto* arguments : {&local, &remote}) {
      arguments->insert(arguments->end(), how.begin(), how.end());
    }
    json expected = answer(local);
    json found = answer(remote);
    EXPECT_EQ(expected["requests"], 0);
    EXPECT_TRUE(contents(at("local.ply")) == contents(at("remote.ply")));
    fs::remove(at("remote.ply"));
    json same = found;
    for (const char* key : {"requests", "bytes_read"}) same[key] = expected[key];
    EXPECT_EQ(same, expected);
    return found;
  }

  /// A slice fails with this message and no output. Returns all that was said.
  std::string fails(const std::string& url, const std::string& expected) {
    const auto run = t4d({"slice", url, "--time", "1", "-o", at("none.ply")});
    EXPECT_EQ(run.code, 4) << url << run.message;
    EXPECT_EQ(run.output, "");
    EXPECT_THAT(run.message, HasSubstr(expected)) << url;
    EXPECT_THAT(folder_->names(), Each(Not(HasSubstr("none")))) << url;
    return run.message;
  }

  /// Expects the torus, served with the fault of that name, to be refused. Messages name the URL.
  void failsBy(const std::string& fault, const std::string& expected) {
    SCOPED_TRACE(fault);
    const std::string url = server_.url(fault + "/torus.t4d");
    EXPECT_THAT(fails(url, expected), HasSubstr("t4d: " + url + ": "));
  }

  static inline std::optional<platform::TestFolder> folder_;
  WebServer server_{folder_->path()};
};

TEST_F(Web, ASliceAtATimeTakesThreeRequestsAtMost) {
  for (const char* time : {"0", "0.001", "1.3", "5"}) {
    const json bolt = cutBoth("bolt.t4d", {"--time", time});
    EXPECT_LE(bolt["requests"], 3) << time;
    EXPECT_LE(bolt["bytes_read"], 300'000) << time;
  }
  const std::uint64_t size = fs::file_size(at("torus.t4d"));
  ASSERT_GT(size, 1'500'000);
  for (const char* time : {"0", "0.2", "1.7"}) {
    const json torus = cutBoth("torus.t4d", {"--time", time});
    EXPECT_LE(torus["requests"], 3) << time;
    EXPECT_GT(torus["requests"], 1) << time;
    EXPECT_LT(torus["bytes_read"], size / 3) << time;
  }
}

TEST_F(Web, ASliceAcrossTimeTakesAFewLargeRequests) {
  for (const std::string name : {"bolt.t4d", "torus.t4d"}) {
    const std::uint64_t size = fs::file_size(at(name));
    const json found = cutBoth(name, {"--x", "0.1"});
    EXPECT_LE(found["requests"], 4 + size / 2'000'000);
    EXPECT_LE(found["bytes_read"], size);
  }
}

TEST_F(Web, AnIndexThatIsLongerThanTheFirstPartTakesOneMoreRequest) {
  const auto made =
      t4d({"sweep", at("fx/paper-cube.obj"), "--motion", at("fx/paper-screw.json"), "--caps",
           "cone", "--steps", "4000", "--compression", "0", "-o", at("long.t4d")});
  ASSERT_EQ(made.code, 0) << made.message;
  ASSERT_GT(answer({"info", at("long.t4d")})["chunks"].back()["bytes"], 262'144);
  EXPECT_LE(cutBoth("long.t4d", {"--time", "1"})["requests"], 4);
}

TEST_F(Web, TheServerSentWhatTheProgramSaysItRead) {
  const json found = cutBoth("torus.t4d", {"--time", "1"});
  const auto requests = server_.requests("plain/");
  std::uint64_t sent = 0;
  for (const auto& request : requests) sent += request.bytes;
  EXPECT_EQ(found["requests"], requests.size());
  EXPECT_EQ(found["bytes_read"], sent);
}

TEST_F(Web, OtherVerbsReadUrlsAsWell) {
  const std::string url = server_.url("plain/cube.t4d");
  json local = answer({"info", at("cube.t4d"), "--slabs"});
  EXPECT_EQ(answer({"info", url, "--slabs"}), local);
  EXPECT_EQ(server_.requests("plain/").size(), 1);
  EXPECT_EQ(answer({"validate", url}), answer({"validate", at("cube.t4d")}));
  const json compared = answer({"compare", url, at("cube.t4d"), "--slices", "2"});
  EXPECT_EQ(compared["slices"].size(), 2);
  EXPECT_EQ(compared["slices"],
            answer({"compare", at("cube.t4d"), at("cube.t4d"), "--slices", "2"})["slices"]);
  EXPECT_EQ(t4d({"flipbook", url, "--frames", "3", "-o", at("book.glb")}).code, 0);
  EXPECT_EQ(t4d({"rasterize", url, "--voxel-size", "1", "--frames", "2", "-o", at("grids")}).code,
            0);
  const auto recover = t4d({"recover", url, "-o", at("recovered.t4d")});
  EXPECT_EQ(recover.code, 4);
  EXPECT_THAT(recover.message, HasSubstr("download it first"));
}

TEST_F(Web, RedirectsAreFollowed) {
  const std::uint64_t direct = cutBoth("torus.t4d", {"--time", "1"})["requests"];
  EXPECT_EQ(cutBoth("torus.t4d", {"--time", "1"}, "redirect")["requests"], 2 * direct);
  failsBy("redirect-for-ever", "redirects");
  failsBy("redirect-to-file", "\"file\"");
}

TEST_F(Web, ADroppedConnectionIsTriedAgainTwice) {
  const std::uint64_t once = cutBoth("torus.t4d", {"--time", "1"})["requests"];
  EXPECT_EQ(cutBoth("torus.t4d", {"--time", "1"}, "dropped-once")["requests"], 2 * once);
  failsBy("dropped", "tried 3 times");
  EXPECT_EQ(server_.requests("dropped/").size(), 3);
  failsBy("dropped-later", "tried 3 times");
}

TEST_F(Web, AFileThatChangesIsNoticed) {
  cutBoth("torus.t4d", {"--time", "1"}, "no-etag");
  cutBoth("torus.t4d", {"--time", "1"}, "weak-etag");
  for (const char* fault : {"changed", "etag-ignored", "time-changed", "length-changed"}) {
    failsBy(fault, "the file has changed while it was read; start again");
  }
  failsBy("changed-unnoticed", "byte ");
}

TEST_F(Web, WrongAnswersAreRefused) {
  failsBy("short", "bytes and says 'bytes ");
  failsBy("long", "more than the 262144 bytes requested");
  failsBy("fewer", "were requested; the server sends those from");
  failsBy("shifted", "were requested; the server sends those from");
  failsBy("no-range", "Content-Range");
  failsBy("nonsense", "Content-Range");
  failsBy("total-unknown", "Content-Range");
  failsBy("total-false", "the footer says that the file has");
  failsBy("zipped", "download the file first");
  failsBy("status-403", "the server answers HTTP/1.1 403 Forbidden");
  failsBy("status-404", "the server answers HTTP/1.1 404 Not Found");
  failsBy("status-503", "the server answers HTTP/1.1 503 Service Unavailable");
  failsBy("status-416", "the file is empty");
}

TEST_F(Web, AFileOfOneByteIsNoT4d) {
  std::ofstream(at("one.t4d")) << 'x';
  const std::string said = fails(server_.url("plain/one.t4d"), "one.t4d: ");
  EXPECT_THAT(said, Not(HasSubstr("Content-Range")));
}

TEST_F(Web, AFileThatIsNotSentInPartsIsNotDownloaded) {
  // The file that this server begins to send has no end.
  failsBy("whole", "download the file first");
  EXPECT_EQ(server_.requests("whole/").size(), 1);
}

TEST_F(Web, CredentialsAreUsedAndNotShown) {
  const std::string url = server_.url("login/torus.t4d?key=hidden", "user:secret@");
  EXPECT_EQ(t4d({"slice", url, "--time", "1"}).code, 0);
  const auto info = t4d({"info", url});
  EXPECT_THAT(info.output, Not(HasSubstr("secret")));
  EXPECT_THAT(info.output, Not(HasSubstr("hidden")));
  const std::string wrong = server_.url("login/torus.t4d?key=hidden", "user:hidden@");
  EXPECT_THAT(fails(wrong, "401 Unauthorized"), Not(HasSubstr("hidden")));
  const std::string other = server_.url("plain/fx/torus.obj?key=hidden", "user:hidden@");
  EXPECT_THAT(fails(other, "is not a .t4d file"), Not(HasSubstr("hidden")));
}

TEST_F(Web, AFileWithoutIndexIsReadFromTheFront) {
  for (const auto& entry : fs::directory_iterator(T4D_CORPUS "/valid")) {
    if (entry.path().extension() != ".t4d") continue;
    const json info = answer({"info", entry.path().string(), "--slabs"});
    if (info["indexed"]) continue;
    fs::copy_file(entry.path(), at("no-index.t4d"), fs::copy_options::overwrite_existing);
    EXPECT_EQ(answer({"info", server_.url("plain/no-index.t4d"), "--slabs"}), info);
    return;
  }
  FAIL() << "the corpus has no file without index";
}

TEST_F(Web, WhatIsNoUrlOfAWebServerIsRefused) {
  EXPECT_THAT(fails("ftp://user:pass@host/a.t4d", "ftp:// cannot be read"), Not(HasSubstr("pass")));
  fails("file://" + at("torus.t4d"), "give the path");
  // Nothing listens there.
  EXPECT_THAT(fails("http://127.0.0.1:1/a.t4d", "connect"), HasSubstr("http://127.0.0.1:1/a.t4d"));
  fails("https://127.0.0.1" + server_.url("plain/torus.t4d").substr(16), "SSL");
}

}  // namespace
}  // namespace t4d::tools
