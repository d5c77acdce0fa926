#include "t4d/verbs/collide.h"

#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "t4d/verbs/json_text.h"

namespace t4d::verbs {
namespace {

using measure::ClearanceVerdict;
using measure::Collision;
using measure::Contact;
using measure::Verdict;
using model::Point3;
using nlohmann::ordered_json;

/// Which bodies are tested: those of one file with those of the other, or all of one file.
std::vector<CollidedPair> pairsOf(const std::span<const Input> inputs) {
  std::vector<CollidedPair> pairs;
  const std::vector<model::Body>& first = inputs.front().bodies;
  const std::vector<model::Body>& last = inputs.back().bodies;
  const std::array follow = {followsPoses(inputs.front()), followsPoses(inputs.back())};
  for (std::size_t i = 0; i < first.size(); ++i) {
    for (std::size_t j = inputs.size() == 1 ? i + 1 : 0; j < last.size(); ++j) {
      pairs.push_back({first[i], last[j], follow, {}, {}, {}});
    }
  }
  return pairs;
}

std::string_view nameOf(Verdict verdict) {
  switch (verdict) {
    case Verdict::Hit:
      return "hit";
    case Verdict::Touch:
      return "touch";
    case Verdict::Clear:
      return "clear";
    case Verdict::WithinTolerance:
      return "within-tolerance";
  }
  return "";
}

ordered_json jsonOf(const Point3& point) { return {point.x(), point.y(), point.z()}; }

ordered_json jsonOf(const std::optional<measure::CellNumber>& cell) {
  if (!cell) return {};
  return {{"slab", cell->slab}, {"cell", cell->cell}};
}

ordered_json jsonOf(const CollidedPair& pair) {
  const Collision& collision = pair.collision;
  ordered_json value = {{"a", pair.a.name},
                        {"b", pair.b.name},
                        {"common", nullptr},
                        {"contact", collision.contact()},
                        {"verdict", nameOf(pair.verdict.verdict)},
                        {"first_contact", nullptr},
                        {"intervals", ordered_json::array()}};
  if (collision.common) value["common"] = {collision.common->begin, collision.common->end};
  for (const measure::ContactInterval& interval : collision.intervals) {
    value["intervals"].push_back({{"begin", interval.begin},
                                  {"end", interval.end},
                                  {"overlaps", interval.overlaps},
                                  {"deepest_time", interval.deepestTime},
                                  {"overlap_volume", interval.overlapVolume},
                                  {"overlap_volume_error", interval.volumeError}});
  }
  std::optional<double> distance;
  std::optional<double> bound;
  std::optional<double> time;
  ordered_json points;
  if (collision.contact()) {
    const Contact& first = collision.intervals.front().first;
    value["first_contact"] = {{"time", first.time},
                              {"point", jsonOf(first.point)},
                              {"cell_a", jsonOf(first.a)},
                              {"cell_b", jsonOf(first.b)}};
    distance = bound = 0;
    time = first.time;
    points = {jsonOf(first.point), jsonOf(first.point)};
  } else if (collision.clearance) {
    const measure::Clearance& nearest = *collision.clearance;
    distance = nearest.distance;
    bound = nearest.lowerBound;
    time = nearest.time;
    points = {jsonOf(nearest.pointA), jsonOf(nearest.pointB)};
  }
  value["min_clearance"] = orNull(distance);
  value["min_clearance_bound"] = orNull(bound);
  value["min_clearance_time"] = orNull(time);
  value["min_clearance_points"] = points;
  value["chord_bound"] = orNull(pair.verdict.chordBound);
  value["depth"] = pair.verdict.depth;
  value["clear_by"] = collision.common ? ordered_json(pair.verdict.clearBy) : ordered_json();
  value["rv_min"] = orNull(pair.decidingVolumeRatio());
  value["keeps_clearance"] = pair.clearance ? ordered_json(pair.keepsClearance()) : ordered_json();
  value["breaks_clearance"] =
      pair.clearance ? ordered_json(pair.clearance->answer == ClearanceVerdict::Answer::NotKept)
                     : ordered_json();
  return value;
}

Result<void> measurePair(CollidedPair& pair, const CollideOptions& options,
                         const model::Progress& progress) {
  auto collision = measure::collide(*pair.a.source, *pair.b.source, {}, progress);
  if (!collision) return pass(collision.error());
  pair.collision = std::move(*collision);
  auto verdict =
      measure::verdictOn(pair.collision, *pair.a.source, *pair.b.source, pair.followPoses);
  if (!verdict) return pass(verdict.error());
  pair.verdict = *verdict;
  if (options.clearance) {
    pair.clearance = measure::clearanceVerdict(pair.collision, pair.verdict, *options.clearance);
  }
  return {};
}

}  // namespace

bool CollidedPair::keepsClearance() const {
  return !clearance || clearance->answer == ClearanceVerdict::Answer::Kept;
}

bool CollidedPair::mayMeet() const {
  return collision.contact() || verdict.verdict == Verdict::WithinTolerance || !keepsClearance();
}

std::optional<double> CollidedPair::decidingVolumeRatio() const {
  const auto& ofClearance = clearance ? clearance->minVolumeRatio : std::nullopt;
  return std::max(verdict.minVolumeRatio, ofClearance);
}

bool CollideReport::mayMeet() const { return std::ranges::any_of(pairs, &CollidedPair::mayMeet); }

Result<CollideReport> collide(std::span<const Input> inputs, const CollideOptions& options,
                              Observer& observer) {
  if (inputs.size() == 2 && !options.ignoreUnits) {
    if (auto checked = checkSameUnits(inputs[0], inputs[1]); !checked) return pass(checked.error());
  }
  CollideReport report{pairsOf(inputs)};
  if (report.pairs.empty()) {
    return invalid("has one body only, which cannot collide with itself; name a second file",
                   inputs.front().name);
  }
  const auto stage = observer.stage("looking for contacts", report.pairs.size(), "pairs");
  for (CollidedPair& pair : report.pairs) {
    if (auto done = measurePair(pair, options, stage->part(1)); !done) {
      return pass(inInput(done.error(), inputs.front()));
    }
  }
  return report;
}

std::string jsonOf(const CollideReport& report) {
  ordered_json value = {{"pairs", ordered_json::array()}};
  for (const CollidedPair& pair : report.pairs) value["pairs"].push_back(jsonOf(pair));
  return jsonText(value);
}

}  // namespace t4d::verbs
