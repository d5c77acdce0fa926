#include <algorithm>
#include <memory>
#include <optional>

#include <fmt/format.h>

#include "formats/file_extension.h"
#include "formats/output_file.h"
#include "tools/t4d/commands.h"
#include "tools/t4d/console.h"
#include "tools/t4d/console_observer.h"
#include "tools/t4d/ctc_option.h"
#include "tools/t4d/frame_options.h"
#include "tools/t4d/input_options.h"
#include "tools/t4d/json_option.h"
#include "tools/t4d/lineage_picture.h"
#include "tools/t4d/option_checks.h"
#include "tools/t4d/part_option.h"
#include "tools/t4d/table_output.h"
#include "tools/verbs/frame_times.h"
#include "tools/verbs/track.h"
#include "tools/verbs/track_parts.h"

namespace t4d::tools {
namespace {

using measure::Track;
using measure::TrackEvent;

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

Result<std::string> fileOf(const std::string& path, const verbs::TrackReport& report) {
  const std::string extension = formats::lowerCaseExtension(path);
  if (extension == ".csv") return tracksCsv(report);
  if (extension == ".json") return verbs::reportText(report) + "\n";
  if (extension == ".graphml") return graphMl(report);
  if (extension == ".dot") return dotGraph(report);
  return plotFile(path, lineagePicture(report));
}

void printTables(const verbs::TrackReport& report) {
  const bool several = report.bodies.size() > 1;
  std::vector<std::vector<std::string>> rows;
  const auto add = [&](const std::string& body, std::vector<std::string> fields) {
    if (several) fields.insert(fields.begin() + 1, body);
    rows.push_back(std::move(fields));
  };
  add("body", {"track", "begin", "", "end", "", "largest volume", "from", "into"});
  for (const verbs::BodyTracks& body : report.bodies) {
    for (std::uint32_t i = 0; i < body.tracks.tracks.size(); ++i) {
      const Track& track = body.tracks.tracks[i];
      add(shownLine(body.name),
          {fmt::format("{}", body.firstId + i), fmt::format("{:.9g}", track.begin),
           std::string(verbs::beginOf(body.tracks, track)), fmt::format("{:.9g}", track.end),
           std::string(verbs::endOf(body.tracks, track)),
           fmt::format("{:.6g}", track.largestVolume), idText(body, track.from),
           idText(body, track.into)});
    }
  }
  printTable(rows, several ? "rlrlrlrll" : "rrlrlrll");
  rows.clear();
  add("body", {"time", "event", "at", "before", "after"});
  for (const verbs::BodyTracks& body : report.bodies) {
    for (const TrackEvent& event : body.tracks.events) {
      const std::string name =
          fmt::format("{}{}", verbs::nameOf(event.kind),
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
            const verbs::Input& input) {
  ConsoleObserver observer;
  auto part = verbs::trackPart(input, tracking, options.part.chosen(), observer);
  if (!part) return report(part.error());
  if (auto added = addContacts(input, tracking, part->report, observer, options.part.chosen());
      !added) {
    return report(added.error());
  }
  const auto identity = [&] { return identityOf(input, tracking.times.size()); };
  tools::printText(options.part.inReport(verbs::Members::valueOf(part->report), identity,
                                         stateOf(*part, tracking)) +
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
  const auto input = verbs::openInput(options.input, options.only);
  if (!input) return report(input.error());
  measure::TrackOptions tracking = options.tracking;
  if (options.frames.count || !options.frames.times.empty() || !options.frames.timesFile.empty()) {
    const auto times = options.frames.of(model::timeSpanOf(input->bodies), kMostTimes);
    if (!times) return report(times.error());
    tracking.times = *times;
    tracking.layers = false;
  }
  if (auto good = checkOutputs(outputs); !good) return report(good.error());
  if (const auto done = options.part.settle(verbs::mostParts(*input), "slabs")) return *done;
  if (options.part.isGiven()) return runPart(options, tracking, *input);
  ConsoleObserver observer;
  auto tracked = verbs::track(*input, tracking, observer);
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
  for (const verbs::BodyTracks& body : tracked->bodies) {
    tracks += body.tracks.tracks.size();
    events += body.tracks.events.size();
  }
  std::optional<verbs::CtcReport> labelled;
  if (!options.ctc.folder.empty()) {
    std::vector<double> times = tracking.layers ? verbs::frameTimesOf(*input) : tracking.times;
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
  addJsonOption<verbs::TrackReport>(
      *command, options->json,
      "The components of a moving solid over time, and the events between them.");
  command->footer("Example:\n  t4d track cells.t4d -o lineage.svg --events events.csv");
  command->callback([=, &exitCode] { exitCode = run(*options); });
}

}  // namespace t4d::tools
