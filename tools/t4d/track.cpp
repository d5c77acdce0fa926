#include "tools/t4d/track.h"

#include <algorithm>
#include <array>
#include <memory>
#include <optional>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "formats/file_extension.h"
#include "formats/output_file.h"
#include "formats/text/xml_text.h"
#include "measure/derived_track.h"
#include "tools/t4d/commands.h"
#include "tools/t4d/console.h"
#include "tools/t4d/console_observer.h"
#include "tools/t4d/csv_field.h"
#include "tools/t4d/ctc_option.h"
#include "tools/t4d/frame_options.h"
#include "tools/t4d/frame_times.h"
#include "tools/t4d/input.h"
#include "tools/t4d/json_option.h"
#include "tools/t4d/lineage_picture.h"
#include "tools/t4d/members.h"
#include "tools/t4d/option_checks.h"
#include "tools/t4d/part_option.h"
#include "tools/t4d/table_output.h"
#include "tools/t4d/track_parts.h"

namespace t4d::tools {
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

namespace {

constexpr std::uint64_t kMostTimes = 1'000'000;

struct TrackArguments {
  std::string input;
  FrameOptions frames;
  InputOptions only;
  measure::TrackOptions tracking;
  std::vector<std::string> outputs;
  std::string events;
  std::string samples;
  CtcOption ctc;
  std::string contacts;
  PartOption part;
  bool json = false;
};

Result<std::string> fileOf(const std::string& path, const TrackReport& report) {
  const std::string extension = formats::lowerCaseExtension(path);
  if (extension == ".csv") return tracksCsv(report);
  if (extension == ".json") return reportText(report) + "\n";
  if (extension == ".graphml") return graphMl(report);
  if (extension == ".dot") return dotGraph(report);
  return plotFile(path, lineagePicture(report));
}

void printTables(const TrackReport& report) {
  const bool several = report.bodies.size() > 1;
  std::vector<std::vector<std::string>> rows;
  const auto add = [&](const std::string& body, std::vector<std::string> fields) {
    if (several) fields.insert(fields.begin() + 1, body);
    rows.push_back(std::move(fields));
  };
  add("body", {"track", "begin", "", "end", "", "largest volume", "from", "into"});
  for (const BodyTracks& body : report.bodies) {
    for (std::uint32_t i = 0; i < body.tracks.tracks.size(); ++i) {
      const Track& track = body.tracks.tracks[i];
      add(shownLine(body.name),
          {fmt::format("{}", body.firstId + i), fmt::format("{:.9g}", track.begin),
           std::string(beginOf(body.tracks, track)), fmt::format("{:.9g}", track.end),
           std::string(endOf(body.tracks, track)), fmt::format("{:.6g}", track.largestVolume),
           idText(body, track.from), idText(body, track.into)});
    }
  }
  printTable(rows, several ? "rlrlrlrll" : "rrlrlrll");
  rows.clear();
  add("body", {"time", "event", "at", "before", "after"});
  for (const BodyTracks& body : report.bodies) {
    for (const TrackEvent& event : body.tracks.events) {
      const std::string name =
          fmt::format("{}{}", nameOf(event.kind),
                      event.count > 1 && event.before.size() == event.after.size()
                          ? fmt::format(" ({})", event.count)
                          : "");
      add(shownLine(body.name), {fmt::format("{:.9g}", event.time), name,
                                 fmt::format("({:.6g}, {:.6g}, {:.6g})", event.place.x(),
                                             event.place.y(), event.place.z()),
                                 idText(body, event.before), idText(body, event.after)});
    }
  }
  if (rows.size() > 1) printTable(rows, several ? "rlllll" : "rllll");
}

bool needsContacts(const TrackArguments& options) {
  const auto isJson = [](const std::string& path) {
    return formats::lowerCaseExtension(path) == ".json";
  };
  return options.json || !options.contacts.empty() || std::ranges::any_of(options.outputs, isJson);
}

/// Tracks in a part of the slabs, for `t4d join`.
int runPart(const TrackArguments& options, const measure::TrackOptions& tracking,
            const Input& input) {
  ConsoleObserver observer;
  auto part = trackPart(input, tracking, options.part.chosen(), observer);
  if (!part) return report(part.error());
  if (auto added = addContacts(input, tracking, part->report, observer, options.part.chosen());
      !added) {
    return report(added.error());
  }
  const auto identity = [&] { return identityOf(input, tracking.times.size()); };
  tools::printText(
      options.part.inReport(Members::valueOf(part->report), identity, stateOf(*part, tracking)) +
      "\n");
  return kDone;
}

int run(const TrackArguments& options) {
  if (const std::string misuse = options.ctc.misuse(); !misuse.empty()) return wrongUsage(misuse);
  std::vector<std::string> outputs = options.outputs;
  for (const std::string& output : {options.events, options.samples, options.contacts}) {
    if (!output.empty()) outputs.push_back(output);
  }
  if (options.part.isGiven() && (!options.json || !outputs.empty())) {
    return wrongUsage("--part needs --json, and no file: what parts found is joined first");
  }
  const auto input = openInput(options.input, options.only);
  if (!input) return report(input.error());
  measure::TrackOptions tracking = options.tracking;
  if (options.frames.count || !options.frames.times.empty() || !options.frames.timesFile.empty()) {
    const auto times = options.frames.of(model::timeSpanOf(input->bodies), kMostTimes);
    if (!times) return report(times.error());
    tracking.times = *times;
    tracking.layers = false;
  }
  if (auto good = checkOutputs(outputs); !good) return report(good.error());
  if (const auto done = options.part.settle(mostParts(*input), "slabs")) return *done;
  if (options.part.isGiven()) return runPart(options, tracking, *input);
  ConsoleObserver observer;
  auto tracked = track(*input, tracking, observer);
  if (!tracked) return report(tracked.error());
  if (needsContacts(options)) {
    if (auto added = addContacts(*input, tracking, *tracked, observer); !added) {
      return report(added.error());
    }
  }
  const auto write = [&](const std::string& path, const Result<std::string>& text) {
    return text.and_then(
        [&](const std::string& bytes) { return formats::writeOutputFile(path, bytes); });
  };
  for (const std::string& output : options.outputs) {
    if (auto written = write(output, fileOf(output, *tracked)); !written) {
      return report(written.error());
    }
  }
  if (!options.events.empty()) {
    if (auto written = write(options.events, eventsCsv(*tracked)); !written) {
      return report(written.error());
    }
  }
  if (!options.samples.empty()) {
    if (auto written = write(options.samples, samplesCsv(*tracked)); !written) {
      return report(written.error());
    }
  }
  if (!options.contacts.empty()) {
    if (auto written = write(options.contacts, contactsCsv(*tracked)); !written) {
      return report(written.error());
    }
  }
  std::uint64_t tracks = 0;
  std::uint64_t events = 0;
  for (const BodyTracks& body : tracked->bodies) {
    tracks += body.tracks.tracks.size();
    events += body.tracks.events.size();
  }
  std::optional<CtcReport> labelled;
  if (!options.ctc.folder.empty()) {
    std::vector<double> times = tracking.layers ? frameTimesOf(*input) : tracking.times;
    std::ranges::sort(times);
    times.erase(std::ranges::unique(times).begin(), times.end());
    auto written = options.ctc.write(*input, *tracked, times, observer);
    if (!written) return report(written.error());
    labelled = *written;
  }
  if (options.json) {
    printAsJson(*tracked);
    return kDone;
  }
  if (labelled) {
    const auto& [x, y, z] = labelled->size;
    print("{}: {} of {} x {} x {} voxels, {}\n", options.ctc.folder,
          counted(labelled->frames, "frame"), x, y, z, counted(labelled->labels, "label"));
    if (labelled->lostLinks > 0) {
      print("  left out: {}, since a label has one parent\n",
            counted(labelled->lostLinks, "further link of mergers", "further links of mergers"));
    }
  } else if (outputs.empty()) {
    printTables(*tracked);
  } else {
    print("{}: {}, {}\n", options.input, counted(tracks, "track"), counted(events, "event"));
  }
  if (tracked->prunedTracks + tracked->prunedEvents > 0) {
    print("  left out: {}, {}\n", counted(tracked->prunedTracks, "track"),
          counted(tracked->prunedEvents, "event"));
  }
  return kDone;
}

}  // namespace

void addTrack(CLI::App& app, int& exitCode) {
  auto* command = app.add_subcommand(
      "track", "Track the components of a moving solid: who appears, splits, merges, vanishes");
  auto options = std::make_shared<TrackArguments>();
  command->add_option("FILE", options->input, kT4dFileHelp)->required();
  options->frames.addTo(*command, kMostTimes, "all layers");
  CLI::Option* surfaces =
      command->add_flag("--surfaces", options->tracking.surfaces,
                        "Track every surface, those of cavities, too, instead of components");
  command
      ->add_option("--min-volume", options->tracking.minVolume,
                   "Leave out tracks that never reach this volume")
      ->check(numberFromZero());
  command
      ->add_option("--min-duration", options->tracking.minDuration,
                   "Leave out tracks that last for less than this time")
      ->check(numberFromZero());
  options->only.addTo(*command);
  command
      ->add_option("-o,--output", options->outputs,
                   "Output file: tracks (.csv, .json), their graph (.graphml, .dot) or a picture "
                   "of it (.svg, .png); repeatable")
      ->allow_extra_args(false)
      ->check(someName())
      ->check(outputByExtension({".csv", ".json", ".graphml", ".dot", ".svg", ".png"}))
      ->type_name("FILE");
  command->add_option("--events", options->events, "Write a table of events (.csv)")
      ->check(outputFile({".csv"}))
      ->type_name("FILE");
  command->add_option("--samples", options->samples, "Write a row for each track and time (.csv)")
      ->check(outputFile({".csv"}))
      ->type_name("FILE");
  options->ctc.addTo(*command)->excludes(surfaces);
  command
      ->add_option("--contacts", options->contacts,
                   "Write a row for each contact between bodies and time (.csv)")
      ->check(outputFile({".csv"}))
      ->type_name("FILE");
  options->part.addTo(*command,
                      "Track only in part K of N of the slabs; `t4d join` joins the reports");
  addJsonOption<TrackReport>(
      *command, options->json,
      "The components of a moving solid over time, and the events between them.");
  command->footer("Example:\n  t4d track cells.t4d -o lineage.svg --events events.csv");
  command->callback([=, &exitCode] { exitCode = run(*options); });
}

}  // namespace t4d::tools
