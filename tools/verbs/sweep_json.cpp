#include <algorithm>

#include <nlohmann/json.hpp>

#include "tools/verbs/json_text.h"
#include "tools/verbs/mending.h"
#include "tools/verbs/sweep.h"

namespace t4d::verbs {
namespace {

using nlohmann::ordered_json;

ordered_json jsonOf(const std::vector<SweptBody>& bodies) {
  ordered_json all = ordered_json::array();
  for (const SweptBody& body : bodies) {
    all.push_back({{"name", body.name},
                   {"vertices", body.vertices},
                   {"tetrahedra", body.tetrahedra},
                   {"steps", body.steps},
                   {"runs", body.runs}});
    if (body.tolerance) all.back()["tolerance"] = *body.tolerance;
  }
  return all;
}

ordered_json jsonOf(const std::vector<model::HalfTurn>& turns) {
  constexpr std::size_t kMost = 100;
  ordered_json first = ordered_json::array();
  for (const model::HalfTurn& turn : turns) {
    if (first.size() == kMost) break;
    first.push_back({{"time", {turn.time.begin, turn.time.end}},
                     {"between", turn.between},
                     {"axis", {turn.axis.x(), turn.axis.y(), turn.axis.z()}}});
  }
  return {{"count", turns.size()}, {"first", first}};
}

/// What was found of one kind; `membersOf` gives the members that the kinds do not share.
template <class Found, class MembersOf>
ordered_json firstOf(const std::vector<FoundInBody<Found>>& all, MembersOf membersOf) {
  ordered_json first = ordered_json::array();
  for (const auto& [body, found] : all) {
    ordered_json entry{{"time", {found.time.begin, found.time.end}}};
    entry.update(membersOf(found));
    entry["place"] = {found.place.x(), found.place.y(), found.place.z()};
    if (!body.empty()) entry["body"] = body;
    first.push_back(std::move(entry));
  }
  return first;
}

ordered_json jsonOf(const SweepFolds& folds) {
  const auto first = firstOf(folds.first, [](const mesh4d::Fold& fold) {
    return ordered_json{{"prisms", fold.prisms}, {"triangle", fold.triangle}};
  });
  return {{"prisms", folds.prisms}, {"steps", folds.steps}, {"first", first}};
}

ordered_json jsonOf(const SweepCrossings& crossings) {
  const auto first = firstOf(crossings.first, [](const mesh4d::StepCrossing& crossing) {
    return ordered_json{
        {"pairs", crossing.pairs}, {"at", crossing.at}, {"triangles", crossing.triangles}};
  });
  return {{"pairs", crossings.pairs},
          {"steps", crossings.steps},
          {"unfinished_steps", crossings.unfinishedSteps},
          {"first", first}};
}

}  // namespace

std::string jsonOf(const SweepReport& report, std::uint64_t peakBytes) {
  ordered_json result{{"vertices", report.vertices},
                      {"tetrahedra", report.tetrahedra},
                      {"steps", report.steps},
                      {"cap_tetrahedra", report.capTetrahedra}};
  if (report.chordBound) result["chord_bound"] = *report.chordBound;
  if (report.tolerance) result["tolerance"] = *report.tolerance;
  if (report.voxelSize) result["voxel_size"] = *report.voxelSize;
  if (!report.bodies.empty()) result["bodies"] = jsonOf(report.bodies);
  if (!report.halfTurns.empty()) result["half_turns"] = jsonOf(report.halfTurns);
  if (report.folds) {
    result["folds"] = jsonOf(*report.folds);
    result["crossings"] = report.crossings ? jsonOf(*report.crossings) : ordered_json();
  }
  if (!report.mended.empty()) result["mend"] = mendJson(report.mended);
  result["seconds"] = report.seconds;
  result["peak_bytes"] = peakBytes;
  result["bytes"] = report.bytes;
  return jsonText(result);
}

}  // namespace t4d::verbs
