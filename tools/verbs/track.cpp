#include "tools/verbs/track.h"

#include <algorithm>
#include <array>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "formats/text/xml_text.h"
#include "measure/derived_track.h"
#include "tools/verbs/csv_field.h"
#include "tools/verbs/members.h"

namespace t4d::verbs {
namespace {

using measure::Track;
using measure::TrackEvent;
using measure::TrackEventKind;
using measure::Tracks;
using nlohmann::ordered_json;

constexpr std::string_view kMesh = "mesh";
constexpr std::string_view kPartOfMesh = "part";

std::string_view kindOf(const Track& track) { return track.cavity ? "cavity" : "solid"; }

std::vector<std::uint64_t> idsOf(const BodyTracks& body, const std::vector<std::uint32_t>& tracks) {
  std::vector<std::uint64_t> ids;
  for (const std::uint32_t track : tracks) ids.push_back(body.firstId + track);
  return ids;
}

std::string unitsOf(const TrackReport& report) {
  return fmt::format(",{},{}\n", csvField(report.lengthUnit), csvField(report.timeUnit));
}

std::string placeText(const model::Point3& point) {
  return fmt::format("{},{},{}", point.x(), point.y(), point.z());
}

/// Calls `work` with each body, the number of a track in it and the track.
template <class Work>
void forTracks(const TrackReport& report, Work work) {
  for (const BodyTracks& body : report.bodies) {
    for (std::uint32_t i = 0; i < body.tracks.tracks.size(); ++i) {
      work(body, i, body.tracks.tracks[i]);
    }
  }
}

std::string dotText(std::string_view text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    if (static_cast<unsigned char>(c) >= 0x20) quoted += c;
  }
  return quoted + "\"";
}

}  // namespace

std::string_view nameOf(TrackEventKind kind) {
  constexpr std::array<std::string_view, 13> kNames = {
      "appears",       "vanishes",       "splits",         "merges",          "rearranges",
      "hole-opens",    "hole-closes",    "cavity-appears", "cavity-vanishes", "cavity-opens",
      "cavity-closes", "cavities-split", "cavities-merge"};
  return kNames[static_cast<std::size_t>(kind)];
}

std::string idText(const BodyTracks& body, const std::vector<std::uint32_t>& tracks) {
  std::string text;
  for (const std::uint32_t track : tracks) {
    text += fmt::format("{}{}", text.empty() ? "" : " ", body.firstId + track);
  }
  return text;
}

std::string_view beginOf(const Tracks& tracks, const Track& track) {
  if (track.beginsWithMesh) return kMesh;
  if (track.beginsBefore) return kPartOfMesh;
  if (track.from.empty()) return nameOf(TrackEventKind::Appears);
  return nameOf(measure::trackKindOf(track.from.size(), tracks.tracks[track.from[0]].into.size()));
}

std::string_view endOf(const Tracks& tracks, const Track& track) {
  if (track.endsWithMesh) return kMesh;
  if (track.endsAfter) return kPartOfMesh;
  if (track.into.empty()) return nameOf(TrackEventKind::Vanishes);
  return nameOf(measure::trackKindOf(tracks.tracks[track.into[0]].from.size(), track.into.size()));
}

Result<TrackReport> track(const Input& input, const measure::TrackOptions& options,
                          Observer& observer) {
  TrackReport report{{}, {}, input.metadata.lengthUnit, input.metadata.timeUnit};
  // A body need not exist at all times, but some body must.
  const model::TimeSpan span = model::timeSpanOf(input.bodies);
  for (const double time : options.times) {
    if (model::timeWithin(span, time)) continue;
    return inInput(invalid(fmt::format("time {} is outside the mesh, which lasts from {} to {}",
                                       time, span.begin, span.end)),
                   input);
  }
  const auto stage = observer.stage("tracking", slabCountOf(input.bodies), "slabs");
  std::uint64_t next = 1;
  for (const model::Body& body : input.bodies) {
    measure::TrackOptions own = options;
    std::erase_if(own.times, [&](double time) { return !model::timeWithin(*body.source, time); });
    auto tracks = measure::tracksOf(*body.source, own, stage->part(body.source->slabCount()));
    if (!tracks) return inInput(tracks.error(), input);
    const std::uint64_t count = tracks->tracks.size();
    report.prunedTracks += tracks->prunedTracks;
    report.prunedEvents += tracks->prunedEvents;
    report.bodies.push_back({body.name, next, std::move(*tracks)});
    next += count;
  }
  return report;
}

Result<void> addContacts(const Input& input, const measure::TrackOptions& options,
                         TrackReport& report, Observer& observer, const model::Part& part) {
  const model::PartRange spans = part.of(measure::contactSpanCount(input.bodies));
  const auto stage = observer.stage("finding contacts", spans.size(), "slabs");
  auto contacts = measure::contactsOf(input.bodies, options, spans, stage->callback());
  if (!contacts) return inInput(contacts.error(), input);
  report.contacts = std::move(*contacts);
  return {};
}

std::string tracksCsv(const TrackReport& report) {
  std::string csv =
      "track,body,kind,begin,end,begins,ends,from,into,largest_volume,length_unit,time_unit\n";
  const std::string units = unitsOf(report);
  forTracks(report, [&](const BodyTracks& body, std::uint32_t i, const Track& track) {
    csv += fmt::format("{},{},{},{},{},{},{},{},{},{}", body.firstId + i, csvField(body.name),
                       kindOf(track), track.begin, track.end, beginOf(body.tracks, track),
                       endOf(body.tracks, track), idText(body, track.from),
                       idText(body, track.into), track.largestVolume) +
           units;
  });
  return csv;
}

std::string eventsCsv(const TrackReport& report) {
  std::string csv = "time,event,body,x,y,z,before,after,count,euler,length_unit,time_unit\n";
  const std::string units = unitsOf(report);
  for (const BodyTracks& body : report.bodies) {
    for (const TrackEvent& event : body.tracks.events) {
      csv += fmt::format("{},{},{},{},{},{},{},{}", event.time, nameOf(event.kind),
                         csvField(body.name), placeText(event.place), idText(body, event.before),
                         idText(body, event.after), event.count, event.euler) +
             units;
    }
  }
  return csv;
}

std::string samplesCsv(const TrackReport& report) {
  std::string csv =
      "track,body,time,volume,area,cx,cy,cz,speed,genus,cavities,min_x,min_y,min_z,max_x,max_y,"
      "max_z,length_unit,time_unit\n";
  const std::string units = unitsOf(report);
  forTracks(report, [&](const BodyTracks& body, std::uint32_t i, const Track& track) {
    for (const measure::TrackSample& sample : track.samples) {
      const measure::SolidMeasures& one = sample.measures;
      csv += fmt::format("{},{},{},{},{},{},{},{},{},{},{}", body.firstId + i, csvField(body.name),
                         one.time, one.volume, one.area, placeText(one.centroid),
                         sample.speed ? fmt::format("{}", *sample.speed) : "", one.genus,
                         one.cavities, placeText(one.bounds.min), placeText(one.bounds.max)) +
             units;
    }
  });
  return csv;
}

std::string contactsCsv(const TrackReport& report) {
  std::string csv = "contact,body,other,begin,end,largest_area,time,area,length_unit,time_unit\n";
  const std::string units = unitsOf(report);
  for (std::size_t i = 0; i < report.contacts.size(); ++i) {
    const measure::BodyContact& one = report.contacts[i];
    const std::string row =
        fmt::format("{},{},{},{},{},{}", i + 1, csvField(report.bodies[one.body].name),
                    csvField(report.bodies[one.other].name), one.begin, one.end, one.largestArea);
    if (one.samples.empty()) csv += row + ",," + units;
    for (const measure::ContactSample& sample : one.samples) {
      csv += fmt::format("{},{},{}", row, sample.time, sample.area) + units;
    }
  }
  return csv;
}

std::string graphMl(const TrackReport& report) {
  std::string text =
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
      "<graphml xmlns=\"http://graphml.graphdrawing.org/xmlns\">\n"
      "<key id=\"body\" for=\"node\" attr.name=\"body\" attr.type=\"string\"/>\n"
      "<key id=\"kind\" for=\"node\" attr.name=\"kind\" attr.type=\"string\"/>\n"
      "<key id=\"begin\" for=\"node\" attr.name=\"begin\" attr.type=\"double\"/>\n"
      "<key id=\"end\" for=\"node\" attr.name=\"end\" attr.type=\"double\"/>\n"
      "<key id=\"begins\" for=\"node\" attr.name=\"begins\" attr.type=\"string\"/>\n"
      "<key id=\"ends\" for=\"node\" attr.name=\"ends\" attr.type=\"string\"/>\n"
      "<key id=\"volume\" for=\"node\" attr.name=\"largest_volume\" attr.type=\"double\"/>\n"
      "<key id=\"time\" for=\"edge\" attr.name=\"time\" attr.type=\"double\"/>\n"
      "<key id=\"event\" for=\"edge\" attr.name=\"event\" attr.type=\"string\"/>\n"
      "<graph edgedefault=\"directed\">\n";
  forTracks(report, [&](const BodyTracks& body, std::uint32_t i, const Track& track) {
    text += fmt::format(
        "<node id=\"{}\"><data key=\"body\">{}</data><data key=\"kind\">{}</data>"
        "<data key=\"begin\">{}</data><data key=\"end\">{}</data><data key=\"begins\">{}</data>"
        "<data key=\"ends\">{}</data><data key=\"volume\">{}</data></node>\n",
        body.firstId + i, formats::xmlEscaped(body.name), kindOf(track), track.begin, track.end,
        beginOf(body.tracks, track), endOf(body.tracks, track), track.largestVolume);
  });
  forTracks(report, [&](const BodyTracks& body, std::uint32_t i, const Track& track) {
    for (const std::uint32_t into : track.into) {
      text += fmt::format(
          "<edge source=\"{}\" target=\"{}\"><data key=\"time\">{}</data>"
          "<data key=\"event\">{}</data></edge>\n",
          body.firstId + i, body.firstId + into, track.end, endOf(body.tracks, track));
    }
  });
  return text + "</graph>\n</graphml>\n";
}

std::string dotGraph(const TrackReport& report) {
  std::string text = "digraph tracks {\n  rankdir=LR;\n  node [shape=box];\n";
  forTracks(report, [&](const BodyTracks& body, std::uint32_t i, const Track& track) {
    const std::string name = body.name.empty() ? "" : " " + body.name;
    text += fmt::format("  {} [label={}];\n", body.firstId + i,
                        dotText(fmt::format("{}{} {:.6g} to {:.6g}", body.firstId + i, name,
                                            track.begin, track.end)));
  });
  forTracks(report, [&](const BodyTracks& body, std::uint32_t i, const Track& track) {
    for (const std::uint32_t into : track.into) {
      text += fmt::format("  {} -> {} [label={}];\n", body.firstId + i, body.firstId + into,
                          dotText(endOf(body.tracks, track)));
    }
  });
  return text + "}\n";
}

namespace {

void describeSample(Members& members, const measure::TrackSample& sample) {
  const measure::SolidMeasures& one = sample.measures;
  members("time", one.time, "In time units.");
  members("volume", one.volume, "In length units cubed; negative of a cavity.");
  members("area", one.area, "Of the surface, in length units squared.").atLeast(0);
  members("centroid", one.centroid, "x, y and z.");
  members(
      "speed", sample.speed,
      "Distance of the centroid from that of the sample before, by the time between; null of the "
      "first.");
  members("genus", one.genus, "Number of handles.");
  members("cavities", one.cavities, "Connected surfaces that face inward.");
  members("min", one.bounds.min, "The least x, y and z.");
  members("max", one.bounds.max, "The greatest x, y and z.");
}

/// A track with what is known of it from its body.
struct NamedTrack {
  std::uint64_t id = 1;
  std::string body;
  std::string begins;
  std::string ends;
  std::vector<std::uint64_t> from;
  std::vector<std::uint64_t> into;
  const Track* track = nullptr;
};

std::vector<NamedTrack> tracksOf(const TrackReport& report) {
  std::vector<NamedTrack> tracks;
  forTracks(report, [&](const BodyTracks& body, std::uint32_t i, const Track& track) {
    tracks.push_back({body.firstId + i, body.name, std::string(beginOf(body.tracks, track)),
                      std::string(endOf(body.tracks, track)), idsOf(body, track.from),
                      idsOf(body, track.into), &track});
  });
  return tracks;
}

void describeTrack(Members& members, const NamedTrack& named) {
  static const Track kNone;
  const Track& track = named.track == nullptr ? kNone : *named.track;
  members("id", named.id, "Number of the track, from 1.").atLeast(1);
  members("body", named.body, "The name of the body.");
  members("kind", kindOf(track), "cavity: with --surfaces, a surface that faces inward.")
      .oneOf({"solid", "cavity"});
  members("begin", track.begin, "In time units.");
  members("end", track.end, "In time units.");
  members("begins", named.begins,
          "How it begins: with the mesh, or the event that it comes out of; part: before this part "
          "of the mesh.")
      .oneOf({"mesh", "appears", "splits", "merges", "rearranges", "part"});
  members(
      "ends", named.ends,
      "How it ends: with the mesh, or the event that it goes into; part: after this part of the "
      "mesh.")
      .oneOf({"mesh", "vanishes", "splits", "merges", "rearranges", "part"});
  members("from", named.from, "Tracks that it comes out of.");
  members("into", named.into, "Tracks that it goes into.");
  members("largest_volume", track.largestVolume,
          "Of its samples or, without samples, at some time of the slab in which it begins; in "
          "length units cubed.")
      .atLeast(0);
  members("samples", track.samples, "The component at each time, in the order of time.",
          describeSample);
}

/// An event with what is known of it from its body.
struct NamedEvent {
  std::string body;
  std::vector<std::uint64_t> before;
  std::vector<std::uint64_t> after;
  TrackEvent event;
};

std::vector<NamedEvent> eventsOf(const TrackReport& report) {
  std::vector<NamedEvent> events;
  for (const BodyTracks& body : report.bodies) {
    for (const TrackEvent& event : body.tracks.events) {
      events.push_back({body.name, idsOf(body, event.before), idsOf(body, event.after), event});
    }
  }
  return events;
}

void describeEvent(Members& members, const NamedEvent& named) {
  const TrackEvent& event = named.event;
  members("time", event.time, "In time units.");
  members("event", nameOf(event.kind), "What happens (docs/track.md).")
      .oneOf({"appears", "vanishes", "splits", "merges", "rearranges", "hole-opens", "hole-closes",
              "cavity-appears", "cavity-vanishes", "cavity-opens", "cavity-closes",
              "cavities-split", "cavities-merge"});
  members("body", named.body, "The name of the body.");
  members("place", event.place, "The mean of the vertices where the topology changes.");
  members("before", named.before, "Tracks that take part, before the event.");
  members("after", named.after, "Tracks that take part, after the event.");
  members("count", event.count,
          "Number of holes or cavities; else the difference of the numbers of tracks.");
  members("euler", event.euler, "What it adds to the Euler number of the slice.");
}

}  // namespace

void describe(Members& members, const TrackReport& report) {
  members("length_unit", report.lengthUnit, "Unit of all lengths: mm, m, ...; empty if unknown.");
  members("time_unit", report.timeUnit, "Unit of the times: s, ms, ...; empty if unknown.");
  members("tracks", tracksOf(report),
          "Components of each body, from birth to death, in the order of birth; bodies one after "
          "another.",
          describeTrack);
  members("events", eventsOf(report),
          "What happens, in the order of time; bodies one after another.", describeEvent);
  members("contacts", report.contacts,
          "Of several bodies whose surfaces have vertices in common: who touches whom, without a "
          "break, in the order of begin.",
          [&](Members& own, const measure::BodyContact& one) {
            const auto nameOfBody = [&](std::size_t body) {
              return report.bodies.empty() ? std::string() : report.bodies[body].name;
            };
            own("body", nameOfBody(one.body), "The name of a body.");
            own("other", nameOfBody(one.other), "The name of the body that it touches.");
            own("begin", one.begin, "In time units.");
            own("end", one.end, "In time units.");
            own("largest_area", one.largestArea,
                "Of its samples and at layers, in length units squared.")
                .atLeast(0);
            own("samples", one.samples, "The contact at each time, in the order of time.",
                [](Members& ofSample, const measure::ContactSample& sample) {
                  ofSample("time", sample.time, "In time units.");
                  ofSample("area", sample.area,
                           "The mean of the two surfaces, in length units squared.")
                      .atLeast(0);
                });
          });
  members("pruned_tracks", report.prunedTracks,
          "Tracks left out by --min-volume or --min-duration.");
  members("pruned_events", report.prunedEvents, "Events left out with them.");
}

}  // namespace t4d::verbs
