#include "tools/verbs/resolve.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <fmt/format.h>

#include "edit/contact_times.h"
#include "measure/chord_bound.h"
#include "t4d/file.h"
#include "tools/verbs/members.h"

namespace t4d::verbs {
namespace {

/// Passes slabs on without directions and places that were those of the surface before it gave way.
class WithoutStale : public model::Sink {
 public:
  WithoutStale(model::Sink& next, const model::AttributeMeanings& meanings,
               std::set<std::string>& dropped)
      : next_(next), meanings_(meanings), dropped_(dropped) {}

  Result<void> put(const model::Slab& slab) override {
    model::Slab kept = slab;
    drop(kept.attributes);
    if (slab.connectivity != given_) {
      auto connectivity = std::make_shared<model::Connectivity>(*slab.connectivity);
      given_ = slab.connectivity;
      kept_ = given_;
      if (drop(connectivity->cellAttributes)) kept_ = std::move(connectivity);
    }
    kept.connectivity = kept_;
    return next_.put(kept);
  }

 private:
  bool drop(std::vector<model::Attribute>& attributes) {
    return std::erase_if(attributes, [&](const model::Attribute& attribute) {
             const bool stale = attribute.name != "displacement" &&
                                model::isSpatial(model::meaningOf(attribute, meanings_));
             if (stale) dropped_.insert(attribute.name);
             return stale;
           }) > 0;
  }

  model::Sink& next_;
  const model::AttributeMeanings& meanings_;
  std::set<std::string>& dropped_;
  std::shared_ptr<const model::Connectivity> given_;
  std::shared_ptr<const model::Connectivity> kept_;
};

/// Writes all bodies of the input, of which some are changed.
Result<void> writeResolved(const Input& input, const std::vector<edit::ResolvedBody>& resolved,
                           const ResolveOptions& options, ResolveReport& report,
                           Observer& observer) {
  auto writer = formats::T4dWriter::create(options.output, metadataOf(input, options.generator),
                                           {.compression = options.compression});
  if (!writer) return writer.error();
  std::uint64_t slabs = 0;
  for (const edit::ResolvedBody& body : resolved) slabs += body.source->slabCount();
  const auto stage = observer.stage("writing " + options.output, slabs, "slabs");
  std::set<std::string> dropped;
  for (std::size_t i = 0; i < resolved.size(); ++i) {
    const model::Source& source = *resolved[i].source;
    WithoutStale current(writer->body(i), input.metadata.attributes, dropped);
    model::Sink& sink = resolved[i].report.changed ? current : writer->body(i);
    if (auto put = model::pump(source, sink, stage->part(source.slabCount())); !put) {
      return put.error();
    }
  }
  for (const std::string& name : dropped) {
    report.losses.push_back(
        fmt::format("attribute '{}': the surface that it was of has given way", name));
  }
  const auto bytes = finishEdited(*writer, input);
  if (!bytes) return bytes.error();
  report.bytes = *bytes;
  for (std::string& line : writer->losses()) report.losses.push_back(std::move(line));
  return {};
}

/// The clearance that the true motions need.
struct DecidingClearance {
  double chordBound = 0;  ///< the largest of a body and an obstacle together
  bool known = true;      ///< whether that is known of all
  /// The clearance that makes it certain that no body meets an obstacle; nothing if it is already.
  std::optional<double> clearance = {};
};

/// Looks whether a resolved body is clear of the obstacles by more than the bounds of chords: that
/// of the body is the one it had before, since what is known of its motion was known then.
Result<void> decideMotions(const Input& obstacles, const Input& input, double kept,
                           const model::Body& before, const edit::ResolvedBody& resolved,
                           DecidingClearance& deciding, const model::Progress& progress) {
  const model::TimeSpan span = model::timeSpanOf(*before.source);
  const auto own = measure::chordBound(*before.source, span, motionOf(input, before.name));
  if (!own) return own.error();
  for (const model::Body& obstacle : obstacles.bodies) {
    const auto other =
        measure::chordBound(*obstacle.source, span, motionOf(obstacles, obstacle.name));
    if (!other) return other.error();
    deciding.known = deciding.known && *own && *other;
    const double bound = (*own ? (*own)->bound : 0) + (*other ? (*other)->bound : 0);
    deciding.chordBound = std::max(deciding.chordBound, bound);
    if (bound == 0 || bound < kept) continue;
    // The number is rounded up to some digits.
    constexpr double kDigits = 1e3;
    const double unit = std::pow(10, std::floor(std::log10(bound))) / kDigits;
    const double enough = std::stod(fmt::format("{:.4g}", std::ceil(bound / unit + 0.5) * unit));
    if (deciding.clearance && *deciding.clearance >= enough) continue;
    const auto contacts =
        edit::contactTimes({&obstacle, 1}, {before.name, resolved.source.get()}, enough, progress);
    if (!contacts) return contacts.error();
    if (!contacts->empty()) deciding.clearance = enough;
  }
  return {};
}

void addResolved(const edit::ResolveReport& body, edit::ResolveReport& all) {
  all.changed = all.changed || body.changed;
  all.maxDisplacement = std::max(all.maxDisplacement, body.maxDisplacement);
  if (std::abs(body.volumeChangeMax) > std::abs(all.volumeChangeMax)) {
    all.volumeChangeMax = body.volumeChangeMax;
  }
  all.hypervolumeChange += body.hypervolumeChange;
  all.rounds = std::max(all.rounds, body.rounds);
  all.movedVertices += body.movedVertices;
}

/// Moves a body out of the way, and looks whether its motion is out of it, too.
Result<edit::ResolvedBody> resolveBody(const Input& obstacles, const Input& input,
                                       const model::Body& body, const edit::ResolveOptions& options,
                                       DecidingClearance& deciding, Observer& observer) {
  const auto stage = observer.stage("resolving " + body.name);
  auto resolved = edit::resolve(obstacles.bodies, body, options, stage->callback());
  if (!resolved) return resolved;
  const auto check = observer.stage("checking " + body.name);
  const auto done = decideMotions(obstacles, input, options.clearance, body, *resolved, deciding,
                                  check->callback());
  if (!done) return done.error();
  return resolved;
}

Result<ResolveReport> resolveAll(const Input& obstacles, const Input& input,
                                 const ResolveOptions& options, Observer& observer) {
  const model::TimeSpan timeOfObstacles = model::timeSpanOf(obstacles.bodies);
  ResolveReport report;
  std::vector<edit::ResolvedBody> all;
  DecidingClearance deciding;
  for (const model::Body& body : input.bodies) {
    if (!options.change.empty() && std::ranges::count(options.change, body.name) == 0) {
      all.push_back(
          {std::shared_ptr<const model::Source>(std::shared_ptr<void>(), body.source), {}});
      continue;
    }
    const model::TimeSpan time = model::timeSpanOf(*body.source);
    if (time.begin > timeOfObstacles.end || time.end < timeOfObstacles.begin) {
      report.notices.push_back(
          fmt::format("body '{}' exists from {} to {}, the obstacles from {} to {}: never together",
                      body.name, time.begin, time.end, timeOfObstacles.begin, timeOfObstacles.end));
    }
    auto one = resolveBody(obstacles, input, body, options.mesh, deciding, observer);
    if (!one) return one.error();
    addResolved(one->report, report.all);
    all.push_back(*one);
    report.bodies.push_back({std::move(*one), body.name});
  }
  if (deciding.known) report.chordBound = deciding.chordBound;
  report.decidingClearance = deciding.clearance;
  if (options.output.empty()) return report;
  if (auto done = writeResolved(input, all, options, report, observer); !done) return done.error();
  return report;
}

void describeResolvedBody(Members& members, const NamedResolvedBody& body) {
  const edit::ResolveReport& report = body.report;
  members("name", body.name, "Name of the body.");
  members("changed", report.changed, "False if it was clear already.");
  members("max_displacement", report.maxDisplacement,
          "The largest displacement of a vertex, in length units.")
      .atLeast(0);
  members("max_displacement_time", report.maxDisplacementTime, "Time of the largest displacement.");
  members("max_displacement_point", report.maxDisplacementPlace,
          "Position of the largest displacement, before it.");
  members("volume_change_max", report.volumeChangeMax,
          "The largest change of the volume at a layer, with its sign, in length^3.");
  members("hypervolume_change", report.hypervolumeChange,
          "Change of the hypervolume of the body, in length^3 * time.");
  members("rounds", report.rounds, "Tests for contact after a change.");
  members("moved_vertices", report.movedVertices, "Vertices of layers that have moved.");
  members("added_layers", report.addedLayers, "Layers within steps, where steps were divided.");
  members("smooth_space", report.smoothSpace,
          "How far around a contact the surface gives way, in length units.")
      .atLeast(0);
  members("smooth_time", report.smoothTime,
          "How long before and after a contact the surface gives way, in time units.")
      .atLeast(0);
  members(
      "layers", report.layers, "The layers, in time order; none if nothing has changed.",
      [](Members& own, const edit::ResolvedLayer& layer) {
        own("time", layer.time, "Time of the layer.");
        own("displacement", layer.displacement, "The largest displacement of a vertex.").atLeast(0);
        own("volume_before", layer.volumeBefore, "Volume of the solid before, in length^3.");
        own("volume_after", layer.volumeAfter, "Volume of the solid after, in length^3.");
      });
}

}  // namespace

Result<ResolveReport> resolve(const Input& obstacles, const Input& input,
                              const ResolveOptions& options, Observer& observer) {
  if (!options.ignoreUnits) {
    if (auto same = checkSameUnits(obstacles, input); !same) return same.error();
  }
  auto report = resolveAll(obstacles, input, options, observer);
  if (!report) return inInput(report.error(), input);
  return report;
}

void describe(Members& members, const ResolveReport& report) {
  const edit::ResolveReport& all = report.all;
  members("clear", true, "The bodies written do not meet any obstacle.");
  members("chord_bound", report.chordBound,
          "How far the meshes of a body and an obstacle together can be from the motions that they "
          "were swept from, the largest of any pair, in length units; null if unknown.")
      .atLeast(0);
  members(
      "deciding_clearance", report.decidingClearance,
      "The --clearance with which the true motions are certain not to meet; null if they already "
      "are.")
      .above(0);
  members("changed", all.changed, "Whether any body has changed.");
  members("max_displacement", all.maxDisplacement,
          "The largest displacement of a vertex of any body, in length units.")
      .atLeast(0);
  members("volume_change_max", all.volumeChangeMax,
          "The largest change of the volume of a body at a layer, with its sign, in length^3.");
  members("hypervolume_change", all.hypervolumeChange,
          "Change of the hypervolume of all bodies, in length^3 * time.");
  members("rounds", all.rounds,
          "Tests for contact after a change, the largest number of any body.");
  members("moved_vertices", all.movedVertices, "Vertices of layers that have moved.");
  members("bodies", report.bodies, "The bodies that were to give way.", describeResolvedBody);
  members("bytes", report.bytes, "Size of the file.");
}

}  // namespace t4d::verbs
