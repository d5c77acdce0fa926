#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "conformance/backends/milling.h"
#include "conformance/backends/own_backends.h"
#include "model/parallel.h"
#include "t4d/conformance.h"
#include "t4d/sweep.h"
#include "t4d/weave.h"
#include "voxel4d/sampled_frames.h"

namespace t4d::conformance {
namespace {

Case caseOf(const std::string& id) {
  for (Case& given : analyticCases()) {
    if (given.id == id) return given;
  }
  ADD_FAILURE() << id;
  return {};
}

std::string whyFailed(const CaseResult& result) {
  std::string text;
  for (const Check& check : result.checks) {
    if (!check.passed) text += result.id + " by " + result.backend + ": " + check.name + "\n";
  }
  return text;
}

std::vector<std::string> failedOf(const CaseResult& result) {
  std::vector<std::string> names;
  for (const Check& check : result.checks) {
    if (!check.passed) names.push_back(check.name);
  }
  return names;
}

TEST(Cases, AreNamedOnceAndKnowWhatTheyAre) {
  std::set<std::string> ids;
  for (const Case& given : analyticCases()) {
    SCOPED_TRACE(given.id);
    EXPECT_TRUE(ids.insert(given.id).second);
    EXPECT_EQ(given.id.find_first_not_of("abcdefghijklmnopqrstuvwxyz-"), std::string::npos);
    EXPECT_NE(given.mesh.has_value(), given.field.has_value());
    EXPECT_TRUE(given.mesh || given.field->volume);
    if (given.mesh) {
      EXPECT_NEAR(given.mesh->volume, signedVolume(given.mesh->mesh), 1e-12 * given.mesh->volume);
    }
    const auto resolutions = voxelResolutions(given);
    for (std::size_t i = 1; i < resolutions.size(); ++i) {
      EXPECT_EQ(2 * resolutions[i].voxelSize, resolutions[i - 1].voxelSize);
      EXPECT_EQ(resolutions[i].steps, 2 * resolutions[i - 1].steps);
    }
  }
}

TEST(Cases, SquirrelSizeHasThePapersCounts) {
  // The counts 3,909,554 and 18,266,982 are those of its 65 steps and the paper's caps.
  const Expectation expectation = *meshBackend()->expectation(caseOf("squirrel-size"), {});
  EXPECT_EQ(3'909'554 - expectation.sideCounts->vertices, 2 * 102U);
  EXPECT_EQ(18'266'982 - expectation.sideCounts->tetrahedra, 2 * 35'311U);
}

TEST(Backends, PassAllCasesQuickly) {
  const std::vector<Case> cases = analyticCases();
  const auto backends = ownBackends();
  std::vector<Job> jobs;
  for (const Case& given : cases) {
    for (const auto& backend : backends) {
      if (backend->supports(given) && !given.large) jobs.push_back({&given, backend.get()});
    }
  }
  const auto results = runCases(jobs, true);
  ASSERT_EQ(results.size(), jobs.size());
  for (std::size_t i = 0; i < jobs.size(); ++i) {
    EXPECT_EQ(results[i].id, jobs[i].given->id);
    EXPECT_EQ(results[i].backend, jobs[i].backend->name());
    EXPECT_TRUE(results[i].passed()) << whyFailed(results[i]);
    EXPECT_GE(results[i].checks.size(), 20U);
  }
}

TEST(Backends, AreJudgedTheSameByAnyNumberOfThreads) {
  const Case given = caseOf("merging-spheres");
  const auto backend = voxelBackend();
  const auto run = [&](std::size_t threads) {
    const model::ThreadLimit limit(threads);
    return runCase(given, *backend, true);
  };
  const CaseResult one = run(1);
  const CaseResult many = run(8);
  ASSERT_EQ(one.checks.size(), many.checks.size());
  for (std::size_t i = 0; i < one.checks.size(); ++i) {
    EXPECT_EQ(one.checks[i].name, many.checks[i].name);
    EXPECT_EQ(one.checks[i].actual, many.checks[i].actual);
  }
}

/// A user's own backend: it only has to implement the interface. Wrong ones are detected.
class OwnBackend : public Backend {
 public:
  using Build = std::function<Result<void>(const Case&, const Resolution&, model::Sink&)>;
  OwnBackend(std::unique_ptr<Backend> like, Build build)
      : like_(std::move(like)), build_(std::move(build)) {}

  std::string name() const override { return "own"; }
  bool supports(const Case& given) const override { return like_->supports(given); }
  std::vector<Resolution> resolutions(const Case& given) const override {
    return like_->resolutions(given);
  }
  Result<Expectation> expectation(const Case& given, const Resolution& resolution) const override {
    return like_->expectation(given, resolution);
  }
  Result<void> build(const Case& given, const Resolution& resolution,
                     model::Sink& sink) const override {
    return build_(given, resolution, sink);
  }

 private:
  std::unique_ptr<Backend> like_;
  Build build_;
};

Result<void> sweptBy(const Case& given, const mesh4d::SweepOptions& options, model::Sink& sink) {
  return mesh4d::sweep(given.mesh->mesh, given.mesh->motion, options, sink)
      .map([](const mesh4d::SweepReport&) {});
}

TEST(Backends, WrongSweepsAreCaught) {
  const Case given = caseOf("cube-screw");
  // Three cells per prism instead of fourteen.
  const OwnBackend three(meshBackend(), [](const Case& c, const Resolution&, model::Sink& sink) {
    return sweptBy(c, {.caps = mesh4d::CapMethod::Cone, .prism = mesh4d::PrismSplit::Three}, sink);
  });
  EXPECT_THAT(failedOf(runCase(given, three, false)),
              testing::IsSupersetOf({"vertices between the caps", "tetrahedra between the caps"}));
  // One step fewer.
  const OwnBackend coarse(meshBackend(), [](const Case& c, const Resolution&, model::Sink& sink) {
    return sweptBy(c, {.steps = mesh4d::StepsPerSegment{23}, .caps = mesh4d::CapMethod::Cone},
                   sink);
  });
  EXPECT_THAT(failedOf(runCase(given, coarse, false)),
              testing::IsSupersetOf({"hypervolume", "vertices between the caps"}));
  const OwnBackend none(meshBackend(), [](const Case&, const Resolution&, model::Sink&) {
    return Result<void>(invalid("cannot do it"));
  });
  const CaseResult result = runCase(given, none, false);
  EXPECT_THAT(failedOf(result), testing::ElementsAre("made"));
  EXPECT_EQ(result.checks[0].found, "cannot do it");
}

TEST(Backends, SweepsThatVisitPlacesTwiceOrComeAtTheWrongTimeAreCaught) {
  const auto movedBy = [](std::vector<model::ScrewRun> runs) {
    return OwnBackend(
        meshBackend(), [=](const Case& c, const Resolution&, model::Sink& sink) -> Result<void> {
          const auto motion = model::chainScrews(0, runs);
          if (!motion) return motion.error();
          return mesh4d::sweep(c.mesh->mesh, *motion, {.caps = mesh4d::CapMethod::Cone}, sink)
              .map([](const mesh4d::SweepReport&) {});
        });
  };
  const auto failed = [](const std::string& id, const Backend& backend) {
    return failedOf(runCase(caseOf(id), backend, true));
  };
  const std::string contact = "first contact with the obstacle";
  const model::Screw toAndFro[2] = {{.translation = {0, 1, 0}}, {.translation = {0, -1, 0}}};
  EXPECT_THAT(
      failed("cube-at-rest", movedBy({{5, toAndFro[0], 1}, {5, toAndFro[1], 1}})),
      testing::AllOf(testing::Contains("visits volume"), testing::Contains("mean normal speed"),
                     testing::Not(testing::Contains(contact))));
  const model::Screw half{.translation = {4.5, 2, -3.5}};
  EXPECT_THAT(
      failed("cube-translated", movedBy({{0.5, half, 1}, {1.5, half, 1}})),
      testing::AllOf(testing::Contains(contact), testing::Not(testing::Contains("visits volume"))));
  EXPECT_THAT(failed("cube-about-z", movedBy({{3, {.angleDegrees = -90}, 1}})),
              testing::Contains(contact));
  EXPECT_THAT(failed("cube-translated", movedBy({{2, {.translation = {-9, 4, -7}}, 1}})),
              testing::Contains(contact));
}

TEST(Backends, AnObstacleThatGoesThroughTheWholeSolidLeavesNoWayOut) {
  Case given = caseOf("cube-translated");
  given.obstacle->canGiveWay = true;
  EXPECT_THAT(failedOf(runCase(given, *meshBackend(), true)),
              testing::ElementsAre("gives way to the obstacle"));
}

TEST(Backends, WrongMillsAreCaught) {
  const auto milledBy = [](const std::function<void(Milling&)>& change) {
    return OwnBackend(millBackend(), [=](Case given, const Resolution& at, model::Sink& sink) {
      auto changed = std::make_shared<Milling>(*given.milling);
      change(*changed);
      given.milling = changed;
      return millBackend()->build(given, at, sink);
    });
  };
  const Case given = caseOf("parted-block");
  const auto failed = [&](const std::function<void(Milling&)>& change) {
    return failedOf(runCase(given, milledBy(change), true));
  };
  // A tool that is a tenth too wide, one that does not go through, and one that stops on the way.
  EXPECT_THAT(failed([](Milling& milling) { milling.tool.diameter *= 1.1; }),
              testing::Contains("order of convergence of the hypervolume"));
  EXPECT_THAT(failed([](Milling& milling) { milling.start.z() = 1.1; }),
              testing::Contains("h = 1: slice at 1: surfaces"));
  EXPECT_THAT(failed([](Milling& milling) {
                milling.motion = *model::chainScrews(0, std::vector<model::ScrewRun>{{1, {}, 1}});
              }),
              testing::Contains("h = 1: slice at 1: volume"));
}

/// Woven at the wrong voxel size or the wrong times.
OwnBackend weaver(double sizeFactor, double late) {
  return {voxelBackend(), [=](const Case& given, const Resolution& at, model::Sink& sink) {
            auto times = model::evenTimes(given.time(), at.steps + 1);
            const model::Motion& motion = given.mesh->motion;
            const auto frames = voxel4d::voxelFrames(
                [&](double time) {
                  return voxel4d::movingSolid(given.mesh->mesh, motion)(time - late);
                },
                times, {.voxelSize = at.voxelSize * sizeFactor});
            return voxel4d::weave(*frames, {}, sink).map([](const voxel4d::WeaveReport&) {});
          }};
}

TEST(Backends, WrongVoxelsAreCaught) {
  const Case given = caseOf("cube-about-skew-axis");
  EXPECT_TRUE(runCase(given, weaver(1, 0), true).passed());
  // Voxels four times larger than declared violate the bounds of order h^2.
  EXPECT_THAT(failedOf(runCase(given, weaver(4, 0), true)),
              testing::Contains("h = 1: hypervolume"));
  // A mesh that lags behind its motion.
  EXPECT_THAT(failedOf(runCase(given, weaver(1, 0.2), true)),
              testing::Contains("h = 1: slice at 2: farthest vertex from the true surface"));
}

TEST(Backends, MasksThatJumpHalfwayBetweenFramesAreCaught) {
  const OwnBackend jumps(
      voxelBackend(), [](const Case& c, const Resolution& at, model::Sink& sink) {
        const auto frames = voxel4d::sampledFrames(
            c.field->value, {at.voxelSize, model::Point3::Zero()}, c.field->box,
            model::evenTimes(c.time(), at.steps + 1), {.slope = c.field->slope, .mask = true});
        return voxel4d::weave(*frames, {.between = voxel4d::Between::Midpoint}, sink)
            .map([](const voxel4d::WeaveReport&) {});
      });
  EXPECT_THAT(failedOf(runCase(caseOf("translating-sphere-mask"), jumps, false)),
              testing::Contains("order of convergence of the slices' volumes"));
}

}  // namespace
}  // namespace t4d::conformance
