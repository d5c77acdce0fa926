#include "tools/t4d/track_parts.h"

#include <algorithm>
#include <optional>
#include <string_view>
#include <utility>

#include "tools/t4d/json_text.h"

namespace t4d::tools {
namespace {

using measure::PartOfTracks;
using measure::SurfaceAtSeam;
using nlohmann::ordered_json;

constexpr auto kKinds = static_cast<std::size_t>(measure::TrackEventKind::CavitiesMerge) + 1;

ordered_json seamJson(const std::vector<SurfaceAtSeam>& surfaces) {
  ordered_json list = ordered_json::array();
  for (const SurfaceAtSeam& one : surfaces) {
    list.push_back({one.track, orNull(one.appears), orNull(one.atFirst), one.largestVolume});
  }
  return list;
}

template <class T>
std::optional<T> numberIn(const ordered_json& value) {
  if (value.is_null()) return std::nullopt;
  return value.get<T>();
}

std::vector<SurfaceAtSeam> seamOf(const ordered_json& list) {
  std::vector<SurfaceAtSeam> surfaces;
  for (const ordered_json& one : list) {
    surfaces.push_back({one.at(0), numberIn<std::size_t>(one.at(1)),
                        numberIn<std::uint32_t>(one.at(2)), one.at(3)});
  }
  return surfaces;
}

model::Point3 pointOf(const ordered_json& value) {
  return {value.at(0).get<double>(), value.at(1).get<double>(), value.at(2).get<double>()};
}

/// Numbers of tracks of a body from their ids.
std::vector<std::uint32_t> numbersOf(const ordered_json& ids, std::uint64_t firstId) {
  std::vector<std::uint32_t> numbers;
  for (const ordered_json& id : ids) {
    numbers.push_back(static_cast<std::uint32_t>(id.get<std::uint64_t>() - firstId));
  }
  return numbers;
}

measure::Track trackIn(const ordered_json& value, std::uint64_t firstId) {
  measure::Track track;
  track.begin = value.at("begin");
  track.end = value.at("end");
  track.beginsWithMesh = value.at("begins") == "mesh";
  track.endsWithMesh = value.at("ends") == "mesh";
  track.beginsBefore = value.at("begins") == "part";
  track.endsAfter = value.at("ends") == "part";
  track.cavity = value.at("kind") == "cavity";
  track.from = numbersOf(value.at("from"), firstId);
  track.into = numbersOf(value.at("into"), firstId);
  track.largestVolume = value.at("largest_volume");
  for (const ordered_json& sample : value.at("samples")) {
    measure::SolidMeasures& one = track.samples.emplace_back().measures;
    one.time = sample.at("time");
    one.volume = sample.at("volume");
    one.area = sample.at("area");
    one.centroid = pointOf(sample.at("centroid"));
    one.components = track.cavity ? 0 : 1;
    one.cavities = sample.at("cavities");
    one.genus = sample.at("genus");
    one.bounds.min = pointOf(sample.at("min"));
    one.bounds.max = pointOf(sample.at("max"));
  }
  return track;
}

measure::TrackEvent eventIn(const ordered_json& value, std::uint64_t firstId) {
  measure::TrackEvent event;
  event.time = value.at("time");
  const std::string name = value.at("event");
  std::size_t kind = 0;
  while (kind < kKinds && nameOf(static_cast<measure::TrackEventKind>(kind)) != name) ++kind;
  if (kind == kKinds) throw ordered_json::other_error::create(600, "an unknown event", &value);
  event.kind = static_cast<measure::TrackEventKind>(kind);
  event.place = pointOf(value.at("place"));
  event.before = numbersOf(value.at("before"), firstId);
  event.after = numbersOf(value.at("after"), firstId);
  event.count = value.at("count");
  event.euler = value.at("euler");
  return event;
}

/// Each body of a part: `from` counts the tracks and events of those before it.
struct Position {
  std::size_t track = 0;
  std::size_t event = 0;
};

PartOfTracks partIn(const ordered_json& report, const ordered_json& body, Position& from) {
  PartOfTracks part;
  part.tracks.time = {body.at("time").at(0), body.at("time").at(1)};
  const std::uint64_t firstId = from.track + 1;
  for (std::size_t end = from.track + body.at("tracks").get<std::size_t>(); from.track < end;) {
    part.tracks.tracks.push_back(trackIn(report.at("tracks").at(from.track++), firstId));
  }
  for (std::size_t end = from.event + body.at("events").get<std::size_t>(); from.event < end;) {
    part.tracks.events.push_back(eventIn(report.at("events").at(from.event++), firstId));
  }
  for (const ordered_json& one : body.at("brief_cavities")) {
    part.tracks.briefCavities.push_back({one.at(0), one.at(1), one.at(2)});
  }
  for (const ordered_json& one : body.at("carried_cavities")) {
    part.carriedCavities.push_back({one.at(0), one.at(1), one.at(2)});
  }
  part.first = seamOf(body.at("first"));
  part.last = seamOf(body.at("last"));
  return part;
}

/// Throws if a number in a part is not that of one of its tracks, events or surfaces.
void checkNumbers(const PartOfTracks& part, std::size_t surfacesBefore, const ordered_json& where) {
  const auto check = [&](std::size_t number, std::size_t count) {
    if (number >= count) {
      throw ordered_json::other_error::create(600, "a number that there is not", &where);
    }
  };
  const std::size_t tracks = part.tracks.tracks.size();
  const std::size_t events = part.tracks.events.size();
  const auto checkTracks = [&](const std::vector<std::uint32_t>& numbers) {
    for (const std::uint32_t number : numbers) check(number, tracks);
  };
  for (const measure::Track& track : part.tracks.tracks) {
    checkTracks(track.from);
    checkTracks(track.into);
  }
  for (const measure::TrackEvent& event : part.tracks.events) {
    checkTracks(event.before);
    checkTracks(event.after);
  }
  for (const auto* seam : {&part.first, &part.last}) {
    for (const SurfaceAtSeam& one : *seam) {
      check(one.track, tracks);
      if (one.appears) check(*one.appears, events);
      if (one.atFirst) check(*one.atFirst, surfacesBefore);
    }
  }
  for (const measure::BriefCavity& one : part.tracks.briefCavities) {
    check(one.appears, events);
    check(one.vanishes, events);
  }
  for (const measure::CarriedCavity& one : part.carriedCavities) {
    check(one.atFirst, surfacesBefore);
    check(one.vanishes, events);
  }
}

}  // namespace

Result<TrackedPart> trackPart(const Input& input, const measure::TrackOptions& options,
                              const model::Part& part, Observer& observer) {
  TrackedPart tracked{{{}, {}, input.metadata.lengthUnit, input.metadata.timeUnit}};
  std::uint64_t slabs = 0;
  for (const model::Body& body : input.bodies) slabs += part.of(body.source->slabCount()).size();
  const auto stage = observer.stage("tracking", slabs, "slabs");
  std::uint64_t next = 1;
  for (const model::Body& body : input.bodies) {
    measure::TrackOptions own = options;
    std::erase_if(own.times, [&](double time) { return !model::timeWithin(*body.source, time); });
    const model::PartRange range = part.of(body.source->slabCount());
    auto found = measure::tracksOfPart(*body.source, own, range, stage->part(range.size()));
    if (!found) return inInput(found.error(), input);
    const std::uint64_t count = found->tracks.tracks.size();
    tracked.report.bodies.push_back({body.name, next, std::exchange(found->tracks, {})});
    tracked.seams.push_back(std::move(*found));
    next += count;
  }
  return tracked;
}

ordered_json stateOf(const TrackedPart& part, const measure::TrackOptions& options) {
  ordered_json bodies = ordered_json::array();
  for (std::size_t b = 0; b < part.seams.size(); ++b) {
    const auto& [name, firstId, tracks] = part.report.bodies[b];
    const PartOfTracks& seams = part.seams[b];
    ordered_json brief = ordered_json::array();
    for (const auto& [appears, vanishes, volume] : tracks.briefCavities) {
      brief.push_back({appears, vanishes, volume});
    }
    ordered_json carried = ordered_json::array();
    for (const auto& [atFirst, vanishes, volume] : seams.carriedCavities) {
      carried.push_back({atFirst, vanishes, volume});
    }
    bodies.push_back({{"name", name},
                      {"time", {tracks.time.begin, tracks.time.end}},
                      {"tracks", tracks.tracks.size()},
                      {"events", tracks.events.size()},
                      {"first", seamJson(seams.first)},
                      {"last", seamJson(seams.last)},
                      {"brief_cavities", std::move(brief)},
                      {"carried_cavities", std::move(carried)}});
  }
  ordered_json contacts = ordered_json::array();
  for (const measure::BodyContact& one : part.report.contacts) {
    contacts.push_back({one.body, one.other});
  }
  return {{"bodies", std::move(bodies)},
          {"contacts", std::move(contacts)},
          {"min_volume", options.minVolume},
          {"min_duration", options.minDuration}};
}

Result<TrackReport> joinedTracking(const std::vector<ordered_json>& reports) {
  const ordered_json& state = reports.front().at("part").at("state");
  measure::TrackOptions options;
  options.minVolume = state.at("min_volume");
  options.minDuration = state.at("min_duration");
  TrackReport all{{}, {}, reports.front().at("length_unit"), reports.front().at("time_unit")};
  std::vector<Position> from(reports.size());
  std::uint64_t next = 1;
  for (std::size_t b = 0; b < state.at("bodies").size(); ++b) {
    std::vector<PartOfTracks> parts;
    for (std::size_t i = 0; i < reports.size(); ++i) {
      const ordered_json& body = reports[i].at("part").at("state").at("bodies").at(b);
      parts.push_back(partIn(reports[i], body, from[i]));
      checkNumbers(parts.back(), i == 0 ? 0 : parts[i - 1].last.size(), body);
    }
    auto tracks = measure::joinedTracks(std::move(parts), options);
    if (!tracks) return tracks.error();
    const std::uint64_t count = tracks->tracks.size();
    all.prunedTracks += tracks->prunedTracks;
    all.prunedEvents += tracks->prunedEvents;
    all.bodies.push_back({state.at("bodies").at(b).at("name"), next, std::move(*tracks)});
    next += count;
  }
  for (const ordered_json& report : reports) {
    const ordered_json& pairs = report.at("part").at("state").at("contacts");
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      const ordered_json& value = report.at("contacts").at(i);
      measure::BodyContact one{pairs[i].at(0), pairs[i].at(1), value.at("begin"), value.at("end"),
                               value.at("largest_area")};
      if (std::max(one.body, one.other) >= all.bodies.size()) {
        throw ordered_json::other_error::create(600, "a body that there is not", &value);
      }
      for (const ordered_json& sample : value.at("samples")) {
        one.samples.push_back({sample.at("time"), sample.at("area")});
      }
      all.contacts.push_back(std::move(one));
    }
  }
  all.contacts = measure::joinedContacts(std::move(all.contacts));
  return all;
}

}  // namespace t4d::tools
