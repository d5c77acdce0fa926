#include "tools/t4d/observer.h"

#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "platform/test_folder.h"
#include "t4d/file.h"
#include "t4d/surface.h"
#include "tools/t4d/compress.h"
#include "tools/t4d/convert.h"
#include "tools/t4d/filter.h"
#include "tools/t4d/join.h"
#include "tools/t4d/merge.h"
#include "tools/t4d/sweep.h"
#include "tools/t4d/test_moving_cube.h"
#include "tools/t4d/transform.h"

/// Who watches a verb can stop it, up to its last report: the file gets its name after that.
namespace t4d::tools {
namespace {

/// Counts the reports of progress, and stops at one of them.
class Stopping : public Observer {
 public:
  explicit Stopping(std::uint64_t at) : at_(at) {}

  std::unique_ptr<Stage> stage(std::string, std::uint64_t, std::string) override {
    return std::make_unique<Counting>(*this);
  }
  std::uint64_t reports = 0;

 private:
  class Counting : public Stage {
   public:
    explicit Counting(Stopping& all) : all_(all) {}
    model::Progress callback() override {
      return [this](double) { return ++all_.reports != all_.at_; };
    }
    model::Progress part(std::uint64_t) override { return callback(); }

   private:
    Stopping& all_;
  };

  std::uint64_t at_;
};

class Observed : public testing::Test {
 protected:
  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  /// The cube that moves from `begin` to `end`.
  std::string cubeFile(const std::string& name, double begin, double end) const {
    const model::Mesh mesh = movingCube(begin, end);
    formats::Metadata metadata;
    metadata.bodies = {{name}};
    auto writer = formats::T4dWriter::create(path(name), metadata);
    EXPECT_TRUE(writer && model::pump(mesh, writer->body(0)) && writer->finish());
    return path(name);
  }

  platform::TestFolder folder_;
};

TEST_F(Observed, VerbsLeaveNoFileWhereTheirObserverStopsThemEvenAtTheLastReport) {
  const std::string cube = cubeFile("cube.t4d", 0, 4);
  const std::string other = cubeFile("other.t4d", 1, 3);
  const auto input = openInput(cube);
  ASSERT_TRUE(input);
  formats::NamedMesh solid{"cube", fixtures::cube(2)};
  ASSERT_TRUE(formats::writeTriangleMeshes(path("cube.obj"), {&solid, 1}));
  folder_.write("slide.json", R"({"segments": [{"duration": 3, "translation": [5, 0, 0]}]})");
  const std::map<std::string, std::function<bool(const std::string& output, Observer& observer)>>
      verbs = {
          {"sweep.t4d",
           [&](const std::string& output, Observer& observer) {
             SweepOptions options{.what = MotionSweep{path("cube.obj"), path("slide.json")},
                                  .caps = mesh4d::CapMethod::Cone};
             options.output.path = output;
             return sweep(options, observer).has_value();
           }},
          {"filter.t4d",
           [&](const std::string& output, Observer& observer) {
             return filter(*input, {.output = output}, observer).has_value();
           }},
          {"compress.t4d",
           [&](const std::string& output, Observer& observer) {
             return compress(*input, {.output = output}, observer).has_value();
           }},
          {"transform.t4d",
           [&](const std::string& output, Observer& observer) {
             return transform(*input, {.timeShift = 1, .output = output}, observer).has_value();
           }},
          {"convert.t4d",
           [&](const std::string& output, Observer& observer) {
             return convert({.input = cube, .output = output}, observer).has_value();
           }},
          {"convert.vtu",
           [&](const std::string& output, Observer& observer) {
             return convert({.input = cube, .output = output}, observer).has_value();
           }},
          {"merge.t4d",
           [&](const std::string& output, Observer& observer) {
             return merge({cube, other}, output, observer).has_value();
           }},
          {"join.t4d",
           [&](const std::string& output, Observer& observer) {
             return join({cube}, output, JoinInto::File, observer).has_value();
           }},
          {"join.t4dm",
           [&](const std::string& output, Observer& observer) {
             return join({cube}, output, JoinInto::Manifest, observer).has_value();
           }},
      };
  const std::size_t files = folder_.names().size();
  for (const auto& [name, verb] : verbs) {
    SCOPED_TRACE(name);
    Stopping counting(std::numeric_limits<std::uint64_t>::max());
    ASSERT_TRUE(verb(path(name), counting));
    ASSERT_GT(counting.reports, 0U);
    std::filesystem::remove(path(name));
    for (const std::uint64_t at : {std::uint64_t{1}, counting.reports}) {
      Stopping stopping(at);
      EXPECT_FALSE(verb(path(name), stopping));
      EXPECT_EQ(stopping.reports, at);
      EXPECT_EQ(folder_.names().size(), files);
    }
  }
}

}  // namespace
}  // namespace t4d::tools
