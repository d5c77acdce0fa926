#include "tools/t4d/collide.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <tuple>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "formats/file_extension.h"
#include "formats/motion/srdf_reader.h"
#include "formats/output_file.h"
#include "formats/t4d/body_details.h"
#include "formats/triangle/triangle_mesh_formats.h"
#include "measure/overlap.h"
#include "model/amount_text.h"
#include "model/parallel.h"
#include "model/progress.h"
#include "tools/report/html_page.h"
#include "tools/report/svg_plot.h"
#include "tools/t4d/clearance_matrix.h"
#include "tools/t4d/collide_page.h"
#include "tools/t4d/commands.h"
#include "tools/t4d/console.h"
#include "tools/t4d/console_observer.h"
#include "tools/t4d/csv_field.h"
#include "tools/t4d/frame_options.h"
#include "tools/t4d/input.h"
#include "tools/t4d/json_option.h"
#include "tools/t4d/json_text.h"
#include "tools/t4d/members.h"
#include "tools/t4d/option_checks.h"
#include "tools/t4d/part_option.h"
#include "tools/t4d/progress_bar.h"
#include "tools/t4d/table_output.h"

namespace t4d::tools {
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

namespace {

using formats::Metadata;
using measure::CollisionVerdict;

constexpr std::uint64_t kMostClearances = 1'000'000;

struct CollideArguments {
  std::vector<std::string> inputs;
  InputOptions only;
  CollideOptions collide;
  std::vector<std::string> ignore;
  FrameOptions frames;
  PartOption part;
  bool failOnContact = false;
  bool noVolume = false;
  std::vector<std::string> outputs;
  std::string html;
  std::string matrix;
  bool all = false;  // pairs, also those that are clear
  bool json = false;
};

std::string text(const Point3& point) {
  return fmt::format("({:.12g}, {:.12g}, {:.12g})", point.x(), point.y(), point.z());
}

bool overlaps(const Collision& collision) {
  return std::any_of(collision.intervals.begin(), collision.intervals.end(),
                     [](const measure::ContactInterval& interval) { return interval.overlaps; });
}

/// A positive number with some significant digits, or as many as keep it on its side of a limit,
/// rounded down or up but for the rounding of the product here.
std::string rounded(bool down, double number, int digits, double limit) {
  constexpr double kRounding = 1e-12;
  for (; digits < 16; ++digits) {
    const double unit = std::pow(10, std::floor(std::log10(number)) + 1 - digits);
    const double units = down ? std::floor(number / unit * (1 + kRounding))
                              : std::ceil(number / unit * (1 - kRounding));
    const std::string text = fmt::format("{:.{}g}", units * unit, digits);
    const double shown = std::stod(text);
    if (down ? shown >= limit : shown < limit) return text;
  }
  return fmt::format("{}", number);
}
std::string atLeast(double bound, int digits, double limit = 0) {
  return bound > 0 ? rounded(true, bound, digits, limit) : "0";
}
std::string atMost(double bound, int digits,
                   double limit = std::numeric_limits<double>::infinity()) {
  return bound > 0 ? rounded(false, bound, digits, limit) : "0";
}

/// The options of sweep that decide what is open, and how many steps they make.
std::string stepsText(const CollidedPair& pair) {
  if (const auto ratio = pair.decidingVolumeRatio()) {
    constexpr double kDigits = 1e9;
    return fmt::format("--rv-min {} ({} a turn)", std::ceil(*ratio * kDigits) / kDigits,
                       counted(*pair.decidingStepsPerTurn(), "step"));
  }
  const double deviation = *pair.decidingDeviation();
  double steps = 0;
  for (const auto& [chords, source] : {std::pair(&pair.verdict.chordsA, pair.a.source),
                                       std::pair(&pair.verdict.chordsB, pair.b.source)}) {
    if (!*chords) continue;
    // The bound of a step falls at least as fast as its duration.
    steps = std::max(
        steps, std::ceil((*chords)->bound / deviation * static_cast<double>(source->slabCount())));
  }
  return fmt::format("--max-deviation {} (some {} steps)", atLeast(deviation, 4), steps);
}

/// A phrase about the meshes where the verdict is open, and by how much.
std::string howNear(const CollidedPair& pair) {
  if (!pair.collision.contact()) {
    return fmt::format("come as near as {:.4g}", pair.collision.clearance->distance);
  }
  return pair.verdict.depth > 0 ? fmt::format("overlap by {:.4g}", pair.verdict.depth) : "touch";
}

/// A sentence about what is certain.
std::string sentenceOf(const CollidedPair& pair, const std::optional<double>& clearance) {
  const CollisionVerdict& verdict = pair.verdict;
  if (!pair.collision.common) return "clear: they never exist at the same time";
  std::string sentence;
  switch (verdict.verdict) {
    case Verdict::Hit:
      sentence = fmt::format("hit: they overlap, {} deep at least", atLeast(verdict.depth, 4));
      break;
    case Verdict::Touch:
      sentence = overlaps(pair.collision)
                     ? "touch: they overlap by no more than the rounding of coordinates"
                     : "touch: they touch and never overlap";
      break;
    case Verdict::Clear:
      sentence = fmt::format(
          "clear by at least {}",
          atLeast(verdict.clearBy, 6, clearance && pair.keepsClearance() ? *clearance : 0));
      break;
    case Verdict::WithinTolerance:
      sentence = fmt::format("cannot be decided with these steps: the meshes {}", howNear(pair));
      break;
  }
  if (!verdict.chordsA && !verdict.chordsB) {
    return sentence +
           "; for the meshes as they are, since nothing is known of the motion between "
           "their layers";
  }
  if (const double bound = verdict.knownBound(); bound > 0) {
    sentence += verdict.chordBound
                    ? fmt::format("; the meshes are within {:.4g} of the motion", bound)
                    : fmt::format("; the mesh of {} is within {:.4g} of the motion",
                                  verdict.chordsA ? pair.a.name : pair.b.name, bound);
  }
  if (!verdict.chordBound) {
    sentence += fmt::format(
        "; {} counts as it is, since nothing is known of its motion between "
        "its layers",
        verdict.chordsA ? pair.b.name : pair.a.name);
  }
  if (verdict.maxDeviation) {
    sentence += fmt::format("; sweep with {} to decide it", stepsText(pair));
  } else if (verdict.verdict == Verdict::WithinTolerance) {
    sentence += "; no finer sweep decides it: change the motion so that they overlap or stay apart";
  }
  return sentence;
}

/// A sentence about what is certain of the clearance.
std::string clearanceSentence(const CollidedPair& pair, double clearance) {
  const ClearanceVerdict& verdict = *pair.clearance;
  using Answer = ClearanceVerdict::Answer;
  std::string sentence = fmt::format("the clearance of {} is ", clearance);
  switch (verdict.answer) {
    case Answer::Kept:
      return sentence + "kept";
    case Answer::NotKept:
      sentence += "not kept";
      if (verdict.most > 0) {
        sentence +=
            fmt::format(": they come within {} of each other", atMost(verdict.most, 6, clearance));
      }
      return sentence;
    case Answer::Unknown:
      break;
  }
  sentence += fmt::format("not kept for certain: they come within {} to {} of each other",
                          atLeast(verdict.least, 6), atMost(verdict.most, 6));
  if (verdict.maxDeviation) {
    return sentence + fmt::format("; sweep with {} to decide it", stepsText(pair));
  }
  return sentence + "; no finer sweep is known to decide it";
}

void printJoints(const std::vector<formats::JointCourse>& joints, double time) {
  if (joints.empty()) return;
  std::string list;
  for (const formats::JointCourse& joint : joints) {
    list += fmt::format("{} {} {:.6g}", list.empty() ? "" : ",", joint.name, joint.at(time));
    if (!joint.unit.empty()) list += " " + joint.unit;
  }
  print("  joints:{}\n", list);
}

void printReport(const CollidedPair& pair, const CollideArguments& options,
                 const std::vector<formats::JointCourse>& joints) {
  const Collision& collision = pair.collision;
  print("{} and {}\n", pair.a.name, pair.b.name);
  print("  {}\n", sentenceOf(pair, options.collide.clearance));
  if (collision.contact()) {
    const Contact& first = collision.intervals.front().first;
    print("  first contact at t = {}, {}\n", first.time, text(first.point));
    printJoints(joints, first.time);
    std::vector<std::vector<std::string>> rows = {
        {"  from", "to", "", "deepest at", "volume of the overlap"}};
    for (const measure::ContactInterval& interval : collision.intervals) {
      const bool measured = interval.overlaps && !options.noVolume;
      rows.push_back({fmt::format("  {}", interval.begin), fmt::format("{}", interval.end),
                      interval.overlaps ? "overlap" : "touch",
                      measured ? fmt::format("{:.12g}", interval.deepestTime) : "",
                      measured ? fmt::format("{:.6g}", interval.overlapVolume) : ""});
    }
    printTable(rows, "l");
  } else if (collision.clearance) {
    const measure::Clearance& nearest = *collision.clearance;
    print("  nearest at t = {:.12g}: {:.9g} apart, {} and {}\n", nearest.time, nearest.distance,
          text(nearest.pointA), text(nearest.pointB));
  }
  if (pair.clearance && collision.common) {
    print("  {}\n", clearanceSentence(pair, *options.collide.clearance));
  }
}

bool isClear(const CollidedPair& pair) { return !pair.mayMeet(); }

/// Pairs that meet, may meet or do not keep the clearance, or all, and how many do.
void printPairs(const CollideReport& found, const CollideArguments& options) {
  const std::vector<CollidedPair>& pairs = found.pairs;
  for (const CollidedPair& pair : pairs) {
    if (options.all || pairs.size() == 1 || !isClear(pair))
      printReport(pair, options, found.joints);
  }
  if (pairs.size() == 1) return;
  const auto count = [&](Verdict verdict) {
    return std::ranges::count(pairs, verdict,
                              [](const CollidedPair& pair) { return pair.verdict.verdict; });
  };
  std::string text = fmt::format("{} of {} pairs hit", count(Verdict::Hit), pairs.size());
  if (const auto touch = count(Verdict::Touch); touch > 0) text += fmt::format(", {} touch", touch);
  if (const auto open = count(Verdict::WithinTolerance); open > 0) {
    text += fmt::format(", {} cannot be decided", open);
  }
  const auto near = std::ranges::count_if(pairs, [](const CollidedPair& pair) {
    return pair.verdict.verdict == Verdict::Clear && !pair.keepsClearance();
  });
  if (near > 0) text += fmt::format(", {} are nearer than the clearance or may be", near);
  const CollidedPair* nearest = nullptr;
  for (const CollidedPair& pair : pairs) {
    if (!isClear(pair) || !pair.collision.common) continue;
    if (nearest == nullptr || pair.verdict.clearBy < nearest->verdict.clearBy) nearest = &pair;
  }
  if (nearest != nullptr) {
    text += fmt::format("; the others are clear by at least {} ({} and {})",
                        atLeast(nearest->verdict.clearBy, 6), nearest->a.name, nearest->b.name);
  }
  print("{}\n", text);
}

void printIgnored(std::span<const BodyNames> ignored) {
  constexpr std::size_t kShown = 8;
  if (ignored.empty()) return;
  std::string list;
  for (const auto& [a, b] : ignored.first(std::min(ignored.size(), kShown))) {
    list += fmt::format("{}{} and {}", list.empty() ? "" : ", ", a, b);
  }
  if (ignored.size() > kShown) list += fmt::format(", and {} more", ignored.size() - kShown);
  print("not tested, because they are joined or left out: {}\n", list);
}

Result<void> writePage(const CollideArguments& options, const std::vector<CollidedPair>& pairs,
                       const Metadata& metadata) {
  std::string title;
  for (const std::string& input : options.inputs) {
    title += (title.empty() ? "" : " and ") + std::filesystem::path(input).filename().string();
  }
  std::vector<CollidePair> made;
  ProgressBar bar("drawing", pairs.size(), "pairs");
  const model::Progress progress = bar.callback();
  for (const CollidedPair& pair : pairs) {
    CollidePair one;
    one.a = pair.a.name;
    one.b = pair.b.name;
    one.verdict = sentenceOf(pair, options.collide.clearance);
    for (const measure::ClearanceSample& sample : pair.samples) {
      one.times.push_back(sample.time);
      one.clearance.push_back(sample.distance);
    }
    if (pair.collision.contact() && !options.noVolume) {
      auto volumes = measure::overlapVolumes(*pair.a.source, *pair.b.source, one.times);
      if (!volumes) return volumes.error();
      one.overlaps = std::move(*volumes);
    }
    auto shown = contactView(pair);
    if (!shown) return shown.error();
    if (*shown) {
      one.time = (*shown)->time;
      one.solidA = std::move((*shown)->a);
      one.solidB = std::move((*shown)->b);
      one.contactA = std::move((*shown)->contactA);
      one.contactB = std::move((*shown)->contactB);
    }
    made.push_back(std::move(one));
    if (auto on = model::report(progress, made.size(), pairs.size()); !on) return on;
  }
  return formats::writeOutputFile(options.html, collidePage(title, metadata, made));
}

/// Tables and plots are of the clearance over time; other outputs are the solids in contact.
CLI::Validator tableOrMesh() {
  std::vector<std::string_view> extensions = formats::writableTriangleMeshes();
  extensions.insert(extensions.begin(), kTablesAndPlots.begin(), kTablesAndPlots.end());
  return outputByExtension(std::move(extensions));
}

/// The clearance of the pairs that come nearest.
std::string clearancePlot(const CollideReport& found, const Metadata& metadata) {
  constexpr const char* kColours[] = {"a", "b", "d"};
  std::vector<const CollidedPair*> pairs;
  for (const CollidedPair& pair : found.pairs) {
    if (!pair.samples.empty()) pairs.push_back(&pair);
  }
  const auto nearest = [](const CollidedPair* pair) {
    return std::ranges::min(pair->samples, {}, &measure::ClearanceSample::distance).distance;
  };
  std::ranges::stable_sort(pairs, {}, nearest);
  std::set<double> times;
  for (const CollidedPair* pair : pairs) {
    for (const auto& sample : pair->samples) times.insert(sample.time);
  }
  const std::size_t shown = std::min(pairs.size(), std::size(kColours));
  const std::string title = shown < found.pairs.size() ? fmt::format("Clearance of {} of {} pairs",
                                                                     shown, found.pairs.size())
                                                       : "Clearance";
  Plot plot{labelled(title, metadata.lengthUnit),
            labelled("time", metadata.timeUnit),
            {times.begin(), times.end()},
            {},
            {0.0}};
  for (std::size_t i = 0; i < shown; ++i) {
    std::map<double, double> distances;
    for (const auto& sample : pairs[i]->samples) distances[sample.time] = sample.distance;
    Curve curve{fmt::format("{} and {}", pairs[i]->a.name, pairs[i]->b.name), kColours[i], {}};
    for (const double time : plot.x) {
      const auto at = distances.find(time);
      curve.values.push_back(at == distances.end() ? std::nan("") : at->second);
    }
    plot.curves.push_back(std::move(curve));
  }
  return svgOf(plot);
}

/// A table or a plot, as the extension says.
Result<std::string> tableOf(const CollideReport& found, const Metadata& metadata,
                            const std::string& path) {
  const std::string extension = formats::lowerCaseExtension(path);
  if (extension == ".csv") return clearanceCsv(found);
  if (extension == ".json") return clearanceJson(found) + "\n";
  return plotFile(path, clearancePlot(found, metadata));
}

/// Links of an SRDF file that no body is a part of.
void noteUnknown(const std::string& file, const formats::DisabledCollisions& listed,
                 const std::multimap<std::string, std::string>& bodiesOf) {
  std::vector<std::string> unknown;
  for (const std::string& link : listed.names()) {
    if (!bodiesOf.contains(link)) unknown.push_back(link);
  }
  if (unknown.empty()) return;
  constexpr std::size_t kShown = 8;
  const std::size_t more = unknown.size() > kShown ? unknown.size() - kShown : 0;
  unknown.resize(unknown.size() - more);
  printNotices(
      {fmt::format("{} names links that have no body here: {}{}", file, fmt::join(unknown, ", "),
                   more > 0 ? fmt::format(", and {} more", more) : "")});
}

/// The pairs of `--ignore`: two names of bodies with a colon between them, or an SRDF file.
Result<std::vector<BodyNames>> ignoredPairs(const CollideArguments& options,
                                            std::span<const Input> inputs) {
  std::set<std::string> names;
  std::multimap<std::string, std::string> bodiesOf;  // links
  for (const Input& input : inputs) {
    for (const formats::BodyInfo& body : input.metadata.bodies) {
      names.insert(body.name);
      bodiesOf.emplace(linkOf(body), body.name);
    }
  }
  std::vector<BodyNames> pairs;
  for (const std::string& text : options.ignore) {
    if (formats::lowerCaseExtension(text) == ".srdf") {
      const auto listed = formats::readDisabledCollisions(text);
      if (!listed) return listed.error();
      noteUnknown(text, *listed, bodiesOf);
      for (const auto& [linkA, a] : bodiesOf) {
        for (const auto& [linkB, b] : bodiesOf) {
          if (linkA <= linkB && listed->contains(linkA, linkB)) pairs.push_back({a, b});
        }
      }
      continue;
    }
    const std::size_t before = pairs.size();
    // Names may have colons of their own.
    for (std::size_t at = text.find(':'); at != text.npos; at = text.find(':', at + 1)) {
      BodyNames pair = {text.substr(0, at), text.substr(at + 1)};
      if (names.contains(pair[0]) && names.contains(pair[1])) pairs.push_back(std::move(pair));
    }
    if (pairs.size() == before) {
      return fail(ErrorCode::Options,
                  fmt::format("--ignore {}: these are not two bodies with a colon between them; "
                              "there are {}",
                              text, fmt::join(names, ", ")));
    }
  }
  return pairs;
}

/// The times of samples: those of the options, in the time that the inputs have in common.
Result<std::vector<double>> sampleTimes(const CollideArguments& options,
                                        std::span<const Input> inputs) {
  model::TimeSpan common = model::timeSpanOf(inputs.front().bodies);
  const model::TimeSpan other = model::timeSpanOf(inputs.back().bodies);
  common.begin = std::max(common.begin, other.begin);
  common.end = std::min(common.end, other.end);
  if (!(common.begin <= common.end)) return std::vector<double>();
  auto times = options.frames.of(common, kMostClearances);
  if (times) std::ranges::sort(*times);  // as plots need them
  return times;
}

/// Why these options cannot be.
std::optional<std::string> misuseOf(const CollideArguments& options,
                                    std::span<const std::string> outputs) {
  if (std::ranges::count_if(options.outputs,
                            [](const auto& path) { return !isTableOrPlot(path); }) > 1) {
    return "-o: one file of the solids in contact is enough; further ones are .csv, .json, .svg or "
           ".png";
  }
  if (options.part.isGiven() && !outputs.empty()) {
    return "--part and outputs exclude each other: only the reports (--json) of parts are joined";
  }
  return std::nullopt;
}

/// The report, with the member that `t4d join` needs of a part.
std::string jsonOf(const CollideArguments& options, const CollideReport& found,
                   std::span<const Input> inputs) {
  return options.part.inReport(Members::valueOf(found), [&] {
    auto files = nlohmann::ordered_json::object();
    for (const Input& input : inputs) {
      files[fmt::format("file {}", files.size() + 1)] = identityOf(input);
    }
    return files;
  });
}

int run(const CollideArguments& options) {
  std::vector<std::string> outputs = options.outputs;
  if (!options.html.empty()) outputs.push_back(options.html);
  if (!options.matrix.empty()) outputs.push_back(options.matrix);
  if (const auto misuse = misuseOf(options, outputs)) return wrongUsage(*misuse);
  if (auto good = checkOutputs(outputs, options.inputs); !good) return report(good.error());
  std::vector<Input> inputs;
  for (const std::string& path : options.inputs) {
    auto opened = openInput(path, options.only);
    if (!opened) return report(opened.error());
    inputs.push_back(std::move(*opened));
  }
  CollideOptions how = options.collide;
  how.overlapVolumes = !options.noVolume;
  auto ignored = ignoredPairs(options, inputs);
  if (!ignored) return report(ignored.error());
  how.ignore = std::move(*ignored);
  if (options.part.isAsked()) {
    if (const auto done = options.part.settle(pairCount(inputs, how), "pairs of bodies")) {
      return *done;
    }
    how.part = options.part.chosen();
  }
  if (!options.html.empty() || std::ranges::any_of(options.outputs, isTableOrPlot)) {
    auto times = sampleTimes(options, inputs);
    if (!times) return report(times.error());
    how.times = std::move(*times);
  }
  ConsoleObserver observer;
  const auto found = collide(inputs, how, observer);
  if (!found) return report(found.error());
  if (!found->mended.empty()) printNotices({noticeOf(found->mended)});
  const Metadata& metadata = inputs.front().metadata;
  std::vector<std::string> losses;
  for (const std::string& output : options.outputs) {
    if (isTableOrPlot(output)) {
      const auto done = tableOf(*found, metadata, output).and_then([&](const std::string& text) {
        return formats::writeOutputFile(output, text);
      });
      if (!done) return report(done.error());
      continue;
    }
    auto done = writeContacts(*found, metadata, output, observer);
    if (!done) return report(done.error());
    losses = std::move(*done);
  }
  if (!options.html.empty()) {
    if (auto written = writePage(options, found->pairs, metadata); !written) {
      return report(written.error());
    }
  }
  if (!options.matrix.empty()) {
    auto drawn = plotFile(options.matrix, clearanceMatrix(*found, metadata.lengthUnit));
    const auto done = drawn.and_then([&](const std::string& picture) {
      return formats::writeOutputFile(options.matrix, picture);
    });
    if (!done) return report(done.error());
  }
  if (options.json) {
    tools::printText(jsonOf(options, *found, inputs) + "\n");
  } else {
    printPairs(*found, options);
    printIgnored(found->ignored);
    for (const std::string& output : outputs) {
      std::error_code unknown;
      const std::uintmax_t size = std::filesystem::file_size(output, unknown);
      if (!unknown) print("{}: {}\n", output, sizeText(size));
    }
  }
  const int done = reportLosses(losses);
  return options.failOnContact && found->mayMeet() ? kFailed : done;
}

}  // namespace

void addCollide(CLI::App& app, int& exitCode) {
  auto* command = app.add_subcommand(
      "collide", "Find when moving solids touch or overlap, or their smallest distance");
  auto options = std::make_shared<CollideArguments>();
  command
      ->add_option("FILE", options->inputs,
                   "One .t4d file with several bodies, or two to test against each other")
      ->required()
      ->expected(1, 2);
  command
      ->add_option("--clearance", options->collide.clearance,
                   "Check that at least this distance is kept, in length units")
      ->check(numberFromZero());
  command->add_flag("--fail-on-contact", options->failOnContact,
                    "Exit with 1 if bodies meet, may meet or do not keep --clearance");
  command->add_flag("--ignore-units", options->collide.ignoreUnits,
                    "Ignore differences in units and up axes");
  command
      ->add_option(
          "--ignore", options->ignore,
          "Do not test bodies A and B, or the pairs that an .srdf file disables; repeatable")
      ->allow_extra_args(false)
      ->check(CLI::Validator(
          [](std::string& text) {
            return text.find(':') != text.npos || formats::lowerCaseExtension(text) == ".srdf"
                       ? std::string()
                       : fmt::format("'{}' is not A:B or the name of an .srdf file", text);
          },
          "A:B|SRDF"));
  command->add_flag("--adjacent", options->collide.adjacent,
                    "Also test each body with its parent, the link that it is joined to");
  command->add_flag("--no-volume", options->noVolume,
                    "Leave out the volumes of overlaps, where a verdict is enough");
  command
      ->add_option("-o,--output", options->outputs,
                   "Output file: both solids at the first contact, contacts in red (.glb), or the "
                   "clearance over time (.csv, .json, .svg, .png); repeatable")
      ->allow_extra_args(false)
      ->check(someName())
      ->check(tableOrMesh())
      ->type_name("FILE");
  options->frames.addTo(*command, kMostClearances);
  command
      ->add_option("--html", options->html,
                   "Write a page with clearance and overlap over time, and pictures")
      ->check(htmlFile());
  command
      ->add_option("--matrix", options->matrix,
                   "Write a picture of the clearances of all pairs of bodies")
      ->check(someName())
      ->check(outputByExtension({".svg", ".png"}))
      ->type_name("FILE");
  command->add_flag("--all", options->all, "Print all pairs, also those that are clear");
  options->only.addTo(*command);
  options->part.addTo(*command,
                      "Test only part K of N of the pairs of bodies; `t4d join` joins the reports");
  addJsonOption<CollideReport>(*command, options->json,
                               "When moving solids touch or overlap, and how near they come.");
  command->footer("Example:\n  t4d collide bolt.t4d nut.t4d --clearance 0.05 -o contacts.glb");
  command->callback([=, &exitCode] { exitCode = run(*options); });
}

}  // namespace t4d::tools
