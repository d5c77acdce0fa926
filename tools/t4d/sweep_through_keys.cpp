#include <algorithm>
#include <set>

#include <fmt/format.h>

#include "tools/t4d/sweep_parts.h"

namespace t4d::tools {
namespace {

/// Says which body an error is about.
Error inSweptBody(Error error, const std::string& file, const std::string& body) {
  if (!error.where.empty() && !error.where.key) return error;
  error.where = placeIn(placeIn(file, fmt::format("body '{}'", body)), error.where.part);
  return error;
}

/// Says which file of a deformation an error is about. Where it names a key, this is a point cache,
/// or one mesh of a series.
Error inDeformation(Error error, const DeformationSweep& what,
                    const std::vector<std::filesystem::path>& keyFiles) {
  if (error.where.empty()) {
    const bool motions = error.remedy == Remedy::Motion || error.remedy == Remedy::StepRule;
    error.where = motions ? what.files.back() : what.files.front();
  } else if (const auto key = error.where.key) {
    error.where.file = keyFiles.empty()
                           ? what.files.back()
                           : keyFiles[std::min<std::uint64_t>(*key, keyFiles.size() - 1)].string();
  }
  return error;
}

template <class Found>
void addFirst(const std::vector<Found>& found, const std::string& body,
              std::vector<FoundInBody<Found>>& first) {
  for (const Found& one : found) {
    if (first.size() == mesh4d::kMostFolds) return;
    first.push_back({body, one});
  }
}

/// Adds what a run of a body became; `name` is "" if there is but one body.
void addRun(const mesh4d::SweepReport& run, const std::string& name, SweptBody& body,
            SweepReport& all) {
  body.vertices += run.vertices;
  body.tetrahedra += run.tetrahedra;
  body.steps += run.steps;
  for (const int end : {0, 1}) all.capTetrahedra[end] += run.capTetrahedra[end];
  all.folds->prisms += run.foldedPrisms;
  all.folds->steps += run.foldedSteps;
  addFirst(run.folds, name, all.folds->first);
  if (!run.soughtCrossings) return;
  if (!all.crossings) all.crossings.emplace();
  all.crossings->pairs += run.crossingPairs;
  all.crossings->steps += run.crossingSteps;
  all.crossings->unfinishedSteps += run.unfinishedSteps;
  addFirst(run.crossings, name, all.crossings->first);
}

/// Notices of runs, each once, and of which bodies.
class Noticed {
 public:
  void add(const std::vector<std::string>& notices, const std::string& body) {
    for (const std::string& notice : notices) {
      auto known = std::ranges::find(all_, notice, &Notice::text);
      if (known == all_.end()) known = all_.insert(all_.end(), {notice, {}});
      known->bodies.insert(body);
    }
  }

  std::vector<std::string> sentences() const {
    std::vector<std::string> sentences;
    for (const auto& [text, bodies] : all_) {
      const std::string whose = bodies.size() > 1 ? fmt::format("{} bodies: ", bodies.size())
                                : bodies.begin()->empty()
                                    ? ""
                                    : fmt::format("body '{}': ", *bodies.begin());
      sentences.push_back(whose + text);
    }
    return sentences;
  }

 private:
  struct Notice {
    std::string text;
    std::set<std::string> bodies;
  };
  std::vector<Notice> all_;
};

}  // namespace

Result<SweepReport> sweepThroughKeys(const SweepOptions& options, const SweepInput& input,
                                     T4dFile& file, Observer& observer) {
  const auto& moving = std::get<BodiesWithKeys>(input.moving);
  const auto* deformation = std::get_if<DeformationSweep>(&options.what);
  std::uint64_t keys = 0;
  for (const auto& body : moving.bodies) {
    for (const auto& run : body.runs) keys += run->count();
  }
  const auto stage = observer.stage("sweeping", keys, "keys");
  SweepReport all;
  Noticed noticed;
  all.folds.emplace();
  for (std::size_t i = 0; i < moving.bodies.size(); ++i) {
    const formats::AnimatedBody& body = moving.bodies[i];
    file.setBody(i);
    SweptBody ofBody{.name = body.name, .runs = body.runs.size(), .tolerance = body.tolerance};
    all.tolerance = std::max(all.tolerance, body.tolerance);
    for (const auto& run : body.runs) {
      const auto done =
          mesh4d::sweep(body.mesh, *run, meshMethodOf(options), file, stage->part(run->count()));
      if (!done && deformation != nullptr) {
        return inDeformation(done.error(), *deformation, moving.keyFiles);
      }
      if (!done) {
        Error error = inSweptBody(done.error(), modelOf(options), body.name);
        for (std::size_t k = i + 1; k < moving.bodies.size(); ++k) {
          const formats::AnimatedBody& next = moving.bodies[k];
          auto other = faultOf(next.mesh, options,
                               placeIn(modelOf(options), fmt::format("body '{}'", next.name)));
          if (other) error.others.push_back(std::move(*other));
        }
        return error;
      }
      const std::string name = input.infos.empty() ? "" : body.name;
      addRun(*done, name, ofBody, all);
      noticed.add(done->notices, name);
    }
    all.vertices += ofBody.vertices;
    all.tetrahedra += ofBody.tetrahedra;
    all.steps += ofBody.steps;
    if (!input.infos.empty()) all.bodies.push_back(std::move(ofBody));
  }
  all.notices = noticed.sentences();
  return all;
}

}  // namespace t4d::tools
