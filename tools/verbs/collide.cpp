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
#include "tools/verbs/members.h"

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

void describeCell(Members& members, const measure::CellNumber& cell) {
  members("slab", cell.slab, "Slab of the body, counted from 0.");
  members("cell", cell.cell, "Cell of the slab, counted from 0.");
}

void describeInterval(Members& members, const measure::ContactInterval& interval, bool measured) {
  const auto ofOverlap = [&](double number) {
    return measured ? std::optional(number) : std::nullopt;
  };
  members("begin", interval.begin, "First time.");
  members("end", interval.end, "Last time.");
  members("overlaps", interval.overlaps,
          "Whether their interiors have common points; if not, they touch.");
  members("deepest_time", ofOverlap(interval.deepestTime),
          "When the overlap is largest; null with --no-volume.");
  members("overlap_volume", ofOverlap(interval.overlapVolume),
          "Volume of the overlap then; null with --no-volume.")
      .atLeast(0);
  members("overlap_volume_error", ofOverlap(interval.volumeError),
          "Estimate of its error; null with --no-volume.")
      .atLeast(0);
}

void describePair(Members& members, const CollidedPair& pair, const CollideReport& report) {
  const Collision& collision = pair.collision;
  const bool meets = collision.contact();
  const std::optional<Contact> first =
      meets ? std::optional(collision.intervals.front().first) : std::nullopt;
  measure::Clearance nearest = collision.clearance.value_or(measure::Clearance());
  if (meets) {
    nearest.distance = nearest.lowerBound = 0;
    nearest.time = first->time;
    nearest.pointA = nearest.pointB = first->point;
  }
  const auto ofNearest = [&](auto value) {
    return meets || collision.clearance ? std::optional(value) : std::nullopt;
  };
  const auto ofCommon = [&](auto value) {
    return collision.common ? std::optional(value) : std::nullopt;
  };
  const auto ofClearance = [&](bool value) {
    return pair.clearance ? std::optional(value) : std::nullopt;
  };
  const model::TimeSpan common = collision.common.value_or(model::TimeSpan());
  members("a", pair.a.name, "Name of a body.");
  members("b", pair.b.name, "Name of the other body.");
  members("common", ofCommon(std::array{common.begin, common.end}),
          "First and last time when both exist; null if there is none.");
  members("contact", collision.contact(), "Whether the meshes meet.");
  members("verdict", nameOf(pair.verdict.verdict), "What is certain of the motions.")
      .oneOf({"hit", "touch", "clear", "within-tolerance"});
  members("first_contact", first, "The first contact; null without one.",
          [&](Members& own, const Contact& contact) {
            own("time", contact.time, "When.");
            own("point", contact.point, "Where: x, y, z.");
            own("cell_a", contact.a, "The cell of a that meets one of b; null if only b has one.",
                describeCell);
            own("cell_b", contact.b, "The cell of b; null if only a has one.", describeCell);
            own("joints", report.joints,
                "Values of all joints at this time; absent if no file has joints.",
                [&](Members& ofJoint, const formats::JointCourse& joint) {
                  ofJoint("name", joint.name, "Name of the joint.");
                  ofJoint("value", joint.values.empty() ? 0 : joint.at(contact.time),
                          "Its value, in its unit.");
                  ofJoint("unit", joint.unit, "Unit of the value; empty if unknown.");
                })
                .onlyIf(!report.joints.empty());
          });
  members("intervals", collision.intervals, "When they are in contact, in time order.",
          [&](Members& own, const measure::ContactInterval& interval) {
            describeInterval(own, interval, report.overlapVolumes);
          });
  members("min_clearance", ofNearest(nearest.distance),
          "Smallest distance at equal times; 0 with contact, null without a common time.");
  members("min_clearance_bound", ofNearest(nearest.lowerBound), "A proven lower bound of it.");
  members("min_clearance_time", ofNearest(nearest.time), "When they are nearest.");
  members("min_clearance_points", ofNearest(std::array{nearest.pointA, nearest.pointB}),
          "The two points that are nearest.");
  members("chord_bound", pair.verdict.chordBound,
          "How far the two meshes together can be from the motions; null if unknown.");
  members("depth", pair.verdict.depth, "Lower bound of how deep the solids overlap.").atLeast(0);
  members("clear_by", ofCommon(pair.verdict.clearBy),
          "The distance that is certain; null for bodies that never exist together.")
      .atLeast(0);
  members("rv_min", pair.decidingVolumeRatio(),
          "The --rv-min of sweep that would decide a verdict within-tolerance, or a clearance that "
          "is neither kept nor broken for certain; null if there is none.");
  members("steps_per_turn", pair.decidingStepsPerTurn(),
          "The steps in a turn that rv_min makes; null where it is null.")
      .atLeast(1);
  members("max_deviation", pair.decidingDeviation(),
          "The --max-deviation of sweep that would decide the same, for the motions of mechanisms "
          "too, in length units; null if there is none.")
      .above(0);
  members("keeps_clearance", ofClearance(pair.keepsClearance()),
          "Whether --clearance is kept for certain; null without it.");
  members(
      "breaks_clearance",
      ofClearance(pair.clearance && pair.clearance->answer == ClearanceVerdict::Answer::NotKept),
      "Whether --clearance is certainly not kept; null without it.");
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

void describe(Members& members, const CollideReport& report) {
  members("pairs", report.pairs, "Each two bodies that were tested.",
          [&](Members& own, const CollidedPair& pair) { describePair(own, pair, report); })
      .joined(Joined::Appended);
  members("ignored", report.ignored,
          "Pairs that were not tested: those of --ignore, and bodies joined to each other.",
          [](Members& own, const BodyNames& names) {
            own("a", names[0], "Name of a body.");
            own("b", names[1], "Name of the other body.");
          })
      .joined(Joined::First);
  members("mended", report.mended,
          "Bodies that mending reshaped before they were swept: what is found is about the mended "
          "solids. Absent if there are none.",
          [](Members& own, const MendedOfFile& mended) {
            const formats::MendedInfo& info = mended.info;
            own("file", mended.file, "Input with the body.");
            own("body", mended.body, "Name of the body.");
            own("volume_before", info.volumeBefore,
                "Volume that the given surface enclosed; null if it was open.");
            own("volume_after", info.volumeAfter, "Volume that the mended surface encloses.");
            own("hausdorff", info.hausdorff,
                "Hausdorff distance between the surfaces before and after, in length units.")
                .atLeast(0);
            own("lost_triangles", info.lostTriangles,
                "Given triangles with points outside of the mended solid, which were dropped.");
            own("lost_distance", info.lostDistance,
                "Distance that these reach out of the mended solid, in length units.")
                .atLeast(0);
            own("hull", info.hull, "Whether the body became its convex hull.");
          })
      .onlyIf(!report.mended.empty())
      .joined(Joined::First);
}

}  // namespace t4d::verbs
