#include "tools/verbs/collide.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <tuple>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "formats/t4d/body_details.h"
#include "measure/overlap.h"
#include "model/amount_text.h"
#include "model/parallel.h"
#include "tools/verbs/csv_field.h"
#include "tools/verbs/json_text.h"

namespace t4d::verbs {
namespace {

using measure::ClearanceVerdict;
using measure::Collision;
using measure::Contact;
using measure::Verdict;
using model::Point3;
using nlohmann::ordered_json;

/// The links that bodies of an input are parts of, and those that these are joined to.
class Links {
 public:
  explicit Links(const formats::Metadata& metadata) {
    for (const formats::BodyInfo& body : metadata.bodies) links_[body.name] = linkOf(body);
    for (const formats::BodyInfo& body : metadata.bodies) {
      // The parent of a further body of a link is a body of this link.
      if (!body.parent.empty() && of(body.parent) != of(body.name)) {
        parents_[of(body.name)] = of(body.parent);
      }
    }
  }
  bool areAdjacent(const BodyNames& names) const {
    const std::string a = of(names[0]);
    const std::string b = of(names[1]);
    return a == b || isParent(a, b) || isParent(b, a);
  }

 private:
  std::string of(const std::string& body) const {
    const auto found = links_.find(body);
    return found == links_.end() ? body : found->second;
  }
  bool isParent(const std::string& parent, const std::string& child) const {
    const auto found = parents_.find(child);
    return found != parents_.end() && found->second == parent;
  }

  std::map<std::string, std::string> links_;    // of bodies
  std::map<std::string, std::string> parents_;  // of links
};

/// Which bodies are tested: those of one file with those of the other, or all of one file.
CollideReport pairsOf(const std::span<const Input> inputs, const CollideOptions& options) {
  CollideReport report{{}, {}, options.overlapVolumes};
  const Links links(inputs.front().metadata);
  const auto isIgnored = [&](const BodyNames& names) {
    const BodyNames turned = {names[1], names[0]};
    return std::ranges::any_of(
               options.ignore,
               [&](const BodyNames& pair) { return pair == names || pair == turned; }) ||
           (inputs.size() == 1 && !options.adjacent && links.areAdjacent(names));
  };
  const std::vector<model::Body>& first = inputs.front().bodies;
  const std::vector<model::Body>& last = inputs.back().bodies;
  for (std::size_t i = 0; i < first.size(); ++i) {
    for (std::size_t j = inputs.size() == 1 ? i + 1 : 0; j < last.size(); ++j) {
      const BodyNames names = {first[i].name, last[j].name};
      if (isIgnored(names)) {
        report.ignored.push_back(names);
      } else {
        report.pairs.push_back(
            {first[i],
             last[j],
             {motionOf(inputs.front(), names[0]), motionOf(inputs.back(), names[1])}});
      }
    }
  }
  return report;
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

ordered_json jsonOf(const CollidedPair& pair, const CollideReport& report) {
  const Collision& collision = pair.collision;
  const bool overlapVolumes = report.overlapVolumes;
  ordered_json value = {{"a", pair.a.name},
                        {"b", pair.b.name},
                        {"common", nullptr},
                        {"contact", collision.contact()},
                        {"verdict", nameOf(pair.verdict.verdict)},
                        {"first_contact", nullptr},
                        {"intervals", ordered_json::array()}};
  if (collision.common) value["common"] = {collision.common->begin, collision.common->end};
  const auto measured = [&](double number) {
    return overlapVolumes ? std::optional(number) : std::nullopt;
  };
  for (const measure::ContactInterval& interval : collision.intervals) {
    value["intervals"].push_back(
        {{"begin", interval.begin},
         {"end", interval.end},
         {"overlaps", interval.overlaps},
         {"deepest_time", orNull(measured(interval.deepestTime))},
         {"overlap_volume", orNull(measured(interval.overlapVolume))},
         {"overlap_volume_error", orNull(measured(interval.volumeError))}});
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
    if (!report.joints.empty()) {
      ordered_json& joints = value["first_contact"]["joints"] = ordered_json::array();
      for (const formats::JointCourse& joint : report.joints) {
        joints.push_back(
            {{"name", joint.name}, {"value", joint.at(first.time)}, {"unit", joint.unit}});
      }
    }
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
  value["steps_per_turn"] = orNull(pair.decidingStepsPerTurn());
  value["max_deviation"] = orNull(pair.decidingDeviation());
  value["keeps_clearance"] = pair.clearance ? ordered_json(pair.keepsClearance()) : ordered_json();
  value["breaks_clearance"] =
      pair.clearance ? ordered_json(pair.clearance->answer == ClearanceVerdict::Answer::NotKept)
                     : ordered_json();
  return value;
}

/// The bodies of the pairs that were reshaped, each once.
std::vector<MendedOfFile> mendedIn(std::span<const Input> inputs,
                                   const std::vector<CollidedPair>& pairs) {
  std::vector<MendedOfFile> mended;
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    for (const formats::BodyInfo& body : inputs[i].metadata.bodies) {
      const auto info = mendedInfoOf(body);
      if (!info) continue;
      const bool tested = std::ranges::any_of(pairs, [&](const CollidedPair& pair) {
        return (inputs.size() == 1 && (pair.a.name == body.name || pair.b.name == body.name)) ||
               (inputs.size() == 2 && (i == 0 ? pair.a.name : pair.b.name) == body.name);
      });
      if (tested) mended.push_back({inputs[i].name, body.name, *info});
    }
  }
  return mended;
}

/// How far the chords of each body are from its motion, which all of its pairs share that exist
/// for the same time.
class BodyBounds {
 public:
  /// Finds the bounds that these pairs need.
  Result<void> find(std::span<const CollidedPair> pairs) {
    std::vector<const measure::MotionBetweenLayers*> motions;
    for (const CollidedPair& pair : pairs) {
      if (!pair.collision.common) continue;
      for (const int side : {0, 1}) {
        if (!numbers_.emplace(keyOf(pair, side), motions.size()).second) continue;
        motions.push_back(&pair.motions[static_cast<std::size_t>(side)]);
      }
    }
    bounds_.resize(motions.size());
    std::vector<const Key*> keys(motions.size());
    for (const auto& [key, number] : numbers_) keys[number] = &key;
    std::vector<Result<void>> done(motions.size());
    model::forEach(motions.size(), [&](std::size_t i) {
      const auto& [source, begin, end] = *keys[i];
      auto bound = measure::chordBound(*source, {begin, end}, *motions[i]);
      if (bound) bounds_[i] = *bound;
      if (!bound) done[i] = bound.error();
    });
    for (const Result<void>& one : done) {
      if (!one) return one;
    }
    return {};
  }

  measure::ChordBounds of(const CollidedPair& pair) const {
    if (!pair.collision.common) return {};
    return {bounds_[numbers_.at(keyOf(pair, 0))], bounds_[numbers_.at(keyOf(pair, 1))]};
  }

 private:
  using Key = std::tuple<const model::Source*, double, double>;
  static Key keyOf(const CollidedPair& pair, int side) {
    const model::TimeSpan& span = *pair.collision.common;
    return {side == 0 ? pair.a.source : pair.b.source, span.begin, span.end};
  }

  std::map<Key, std::size_t> numbers_;
  std::vector<std::optional<measure::ChordBound>> bounds_;
};

/// Computes everything asked for about a pair whose contacts are known.
Result<void> judgePair(CollidedPair& pair, const measure::ChordBounds& bounds,
                       const CollideOptions& options) {
  const auto judge = [&] {
    return measure::verdictWith(bounds, pair.collision, *pair.a.source, *pair.b.source);
  };
  auto verdict = judge();
  if (!verdict) return verdict.error();
  if (pair.collision.contact() && !options.overlapVolumes && verdict->verdict != Verdict::Hit) {
    // The middle of an interval is not enough, nor are faces in common, which do not cross.
    auto done = measure::measureOverlaps(*pair.a.source, *pair.b.source, pair.collision.intervals);
    if (!done) return done.error();
    verdict = judge();
    if (!verdict) return verdict.error();
  }
  pair.verdict = *verdict;
  if (options.clearance) {
    pair.clearance = measure::clearanceVerdict(pair.collision, pair.verdict, *options.clearance);
  }
  auto samples = measure::clearanceOverTime(*pair.a.source, *pair.b.source, pair.collision,
                                            pair.verdict, options.times);
  if (!samples) return samples.error();
  pair.samples = std::move(*samples);
  return {};
}

}  // namespace

std::string noticeOf(std::span<const MendedOfFile> mended) {
  constexpr std::size_t kShown = 8;
  std::string text = fmt::format(
      "the answer is about {} as the file has {}:", model::counted(mended.size(), "body", "bodies"),
      mended.size() == 1 ? "it" : "them");
  for (const auto& [file, body, info] : mended.first(std::min(mended.size(), kShown))) {
    text += fmt::format(
        " '{}' of {} {} (volume {:.6g}, {}; surface moved by up to {:.6g}", body, file,
        info.hull ? "is a convex hull" : "was mended", info.volumeAfter,
        info.volumeBefore ? fmt::format("{:.6g} before", *info.volumeBefore) : "open before",
        info.hausdorff);
    if (info.lostTriangles > 0) {
      text += fmt::format("; parts up to {:.6g} outside of it were dropped", info.lostDistance);
    }
    text += "),";
  }
  text.pop_back();
  if (mended.size() > kShown) text += fmt::format(", and {} more", mended.size() - kShown);
  return text;
}

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

std::optional<std::uint64_t> CollidedPair::decidingStepsPerTurn() const {
  const auto ratio = decidingVolumeRatio();
  if (!ratio) return std::nullopt;
  // A step of the angle theta keeps (1 + cos(theta)) / 2 of the volume (mesh4d/sweep.h).
  const double angle = std::acos(std::clamp(2 * *ratio - 1, -1.0, 1.0));
  return static_cast<std::uint64_t>(std::ceil(2 * std::acos(-1) / angle));
}

std::optional<double> CollidedPair::decidingDeviation() const {
  const auto& ofClearance = clearance ? clearance->maxDeviation : std::nullopt;
  if (!ofClearance || !verdict.maxDeviation)
    return ofClearance ? ofClearance : verdict.maxDeviation;
  return std::min(*ofClearance, *verdict.maxDeviation);
}

bool CollideReport::mayMeet() const { return std::ranges::any_of(pairs, &CollidedPair::mayMeet); }

Result<CollideReport> collide(std::span<const Input> inputs, const CollideOptions& options,
                              Observer& observer) {
  if (inputs.size() == 2 && !options.ignoreUnits) {
    if (auto checked = checkSameUnits(inputs[0], inputs[1]); !checked) return checked.error();
  }
  CollideReport report = pairsOf(inputs, options);
  if (report.pairs.empty() && !report.ignored.empty()) {
    return fail(ErrorCode::Options, "all pairs of bodies are left out", inputs.front().name);
  }
  if (report.pairs.empty()) {
    return invalid("has one body only, which cannot collide with itself; name a second file",
                   inputs.front().name);
  }
  const model::PartRange share = options.part.of(report.pairs.size());
  report.pairs = {std::make_move_iterator(report.pairs.begin() + std::ptrdiff_t(share.begin)),
                  std::make_move_iterator(report.pairs.begin() + std::ptrdiff_t(share.end))};
  const auto stage = observer.stage("looking for contacts", report.pairs.size(), "pairs");
  std::vector<measure::SourcePair> sources;
  for (const CollidedPair& pair : report.pairs) {
    sources.push_back({pair.a.source, pair.b.source});
  }
  report.mended = mendedIn(inputs, report.pairs);
  for (const Input& input : inputs) {
    for (auto& joint : formats::jointsOf(input.metadata.detailsJson)) {
      report.joints.push_back(std::move(joint));
    }
  }
  auto collisions = measure::collideAll(sources, {.overlapVolumes = options.overlapVolumes},
                                        stage->part(report.pairs.size()));
  if (!collisions) return inInput(collisions.error(), inputs.front());
  for (std::size_t i = 0; i < report.pairs.size(); ++i) {
    report.pairs[i].collision = std::move((*collisions)[i]);
  }
  BodyBounds bounds;
  if (auto found = bounds.find(report.pairs); !found) {
    return inInput(found.error(), inputs.front());
  }
  std::vector<Result<void>> judged(report.pairs.size());
  model::forEach(judged.size(), [&](std::size_t i) {
    judged[i] = judgePair(report.pairs[i], bounds.of(report.pairs[i]), options);
  });
  for (const Result<void>& one : judged) {
    if (!one) return inInput(one.error(), inputs.front());
  }
  return report;
}

std::uint64_t pairCount(std::span<const Input> inputs, const CollideOptions& options) {
  return pairsOf(inputs, options).pairs.size();
}

std::string clearanceCsv(const CollideReport& report) {
  struct Row {
    const CollidedPair* pair;
    const measure::ClearanceSample* sample;
  };
  std::vector<Row> rows;
  for (const CollidedPair& pair : report.pairs) {
    for (const measure::ClearanceSample& sample : pair.samples) rows.push_back({&pair, &sample});
  }
  std::ranges::stable_sort(rows, {}, [](const Row& row) { return row.sample->time; });
  std::string csv = "time,a,b,distance,lower_bound,overlap_depth\n";
  for (const auto& [pair, sample] : rows) {
    csv += fmt::format("{},{},{},{},{},{}\n", sample->time, csvField(pair->a.name),
                       csvField(pair->b.name), sample->distance, sample->lowerBound,
                       sample->overlapDepth);
  }
  return csv;
}

std::string clearanceJson(const CollideReport& report) {
  ordered_json value = {{"pairs", ordered_json::array()}};
  for (const CollidedPair& pair : report.pairs) {
    ordered_json samples = ordered_json::array();
    for (const measure::ClearanceSample& sample : pair.samples) {
      samples.push_back({{"time", sample.time},
                         {"distance", sample.distance},
                         {"lower_bound", sample.lowerBound},
                         {"overlap_depth", sample.overlapDepth}});
    }
    value["pairs"].push_back(
        {{"a", pair.a.name}, {"b", pair.b.name}, {"samples", std::move(samples)}});
  }
  return jsonText(value);
}

std::string jsonOf(const CollideReport& report) {
  ordered_json value = {{"pairs", ordered_json::array()}};
  for (const CollidedPair& pair : report.pairs) {
    value["pairs"].push_back(jsonOf(pair, report));
  }
  value["ignored"] = ordered_json::array();
  for (const auto& [a, b] : report.ignored) value["ignored"].push_back({{"a", a}, {"b", b}});
  if (!report.mended.empty()) value["mended"] = ordered_json::array();
  for (const MendedOfFile& mended : report.mended) {
    value["mended"].push_back({{"file", mended.file},
                               {"body", mended.body},
                               {"volume_before", orNull(mended.info.volumeBefore)},
                               {"volume_after", mended.info.volumeAfter},
                               {"hausdorff", mended.info.hausdorff},
                               {"lost_triangles", mended.info.lostTriangles},
                               {"lost_distance", mended.info.lostDistance},
                               {"hull", mended.info.hull}});
  }
  return jsonText(value);
}

}  // namespace t4d::verbs
