#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "formats/file_extension.h"
#include "formats/motion/srdf_reader.h"
#include "formats/output_file.h"
#include "formats/t4d/body_details.h"
#include "formats/triangle/triangle_mesh_formats.h"
#include "measure/overlap.h"
#include "model/progress.h"
#include "tools/report/html_page.h"
#include "tools/report/svg_plot.h"
#include "tools/t4d/clearance_matrix.h"
#include "tools/t4d/collide_page.h"
#include "tools/t4d/commands.h"
#include "tools/t4d/console.h"
#include "tools/t4d/console_observer.h"
#include "tools/t4d/frame_options.h"
#include "tools/t4d/input_options.h"
#include "tools/t4d/json_option.h"
#include "tools/t4d/option_checks.h"
#include "tools/t4d/part_option.h"
#include "tools/t4d/progress_bar.h"
#include "tools/t4d/table_output.h"
#include "tools/verbs/collide.h"
#include "tools/verbs/json_text.h"

namespace t4d::tools {
namespace {

using formats::Metadata;
using measure::ClearanceVerdict;
using measure::Collision;
using measure::CollisionVerdict;
using measure::Contact;
using measure::Verdict;
using model::Point3;
using verbs::CollidedPair;

constexpr std::uint64_t kMostClearances = 1'000'000;

struct CollideArguments {
  std::vector<std::string> inputs;
  InputOptions only;
  verbs::CollideOptions collide;
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
void printPairs(const verbs::CollideReport& found, const CollideArguments& options) {
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

void printIgnored(std::span<const verbs::BodyNames> ignored) {
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
    auto shown = verbs::contactView(pair);
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
std::string clearancePlot(const verbs::CollideReport& found, const Metadata& metadata) {
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
Result<std::string> tableOf(const verbs::CollideReport& found, const Metadata& metadata,
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
Result<std::vector<verbs::BodyNames>> ignoredPairs(const CollideArguments& options,
                                                   std::span<const verbs::Input> inputs) {
  std::set<std::string> names;
  std::multimap<std::string, std::string> bodiesOf;  // links
  for (const verbs::Input& input : inputs) {
    for (const formats::BodyInfo& body : input.metadata.bodies) {
      names.insert(body.name);
      bodiesOf.emplace(linkOf(body), body.name);
    }
  }
  std::vector<verbs::BodyNames> pairs;
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
      verbs::BodyNames pair = {text.substr(0, at), text.substr(at + 1)};
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
                                        std::span<const verbs::Input> inputs) {
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
std::string jsonOf(const CollideArguments& options, const verbs::CollideReport& found,
                   std::span<const verbs::Input> inputs) {
  return options.part.inReport(verbs::Members::valueOf(found), [&] {
    auto files = nlohmann::ordered_json::object();
    for (const verbs::Input& input : inputs) {
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
  std::vector<verbs::Input> inputs;
  for (const std::string& path : options.inputs) {
    auto opened = verbs::openInput(path, options.only);
    if (!opened) return report(opened.error());
    inputs.push_back(std::move(*opened));
  }
  verbs::CollideOptions how = options.collide;
  how.overlapVolumes = !options.noVolume;
  auto ignored = ignoredPairs(options, inputs);
  if (!ignored) return report(ignored.error());
  how.ignore = std::move(*ignored);
  if (options.part.isAsked()) {
    if (const auto done = options.part.settle(verbs::pairCount(inputs, how), "pairs of bodies")) {
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
  const auto found = verbs::collide(inputs, how, observer);
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
    auto done = verbs::writeContacts(*found, metadata, output, observer);
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
  addJsonOption<verbs::CollideReport>(
      *command, options->json, "When moving solids touch or overlap, and how near they come.");
  command->footer("Example:\n  t4d collide bolt.t4d nut.t4d --clearance 0.05 -o contacts.glb");
  command->callback([=, &exitCode] { exitCode = run(*options); });
}

}  // namespace t4d::tools
