#include "tools/t4d/resolve.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <memory>
#include <set>

#include <fmt/format.h>

#include "edit/contact_times.h"
#include "formats/output_file.h"
#include "measure/chord_bound.h"
#include "t4d/check.h"
#include "t4d/file.h"
#include "tools/t4d/commands.h"
#include "tools/t4d/console.h"
#include "tools/t4d/console_observer.h"
#include "tools/t4d/input.h"
#include "tools/t4d/json_option.h"
#include "tools/t4d/members.h"
#include "tools/t4d/option_checks.h"
#include "tools/t4d/progress_bar.h"
#include "tools/t4d/resolve_page.h"
#include "tools/t4d/t4d_output.h"
#include "tools/t4d/version.h"

namespace t4d::tools {
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

namespace {

struct ResolveArguments {
  std::string obstacles;
  std::string input;
  std::vector<std::string> against;  // bodies of `obstacles`; none for all
  InputOptions only;                 // of `input`
  ResolveOptions resolve;
  std::string html;
  bool json = false;
};

/// The bodies of both files.
struct ResolveInput {
  Input obstacles;
  Input all;                        // of the file that is changed
  std::vector<std::string> change;  // names of those that give way
};

Result<ResolveInput> openBoth(const ResolveArguments& options) {
  auto obstacles =
      openInput(options.obstacles, {.bodies = options.against, .maxCells = options.only.maxCells});
  if (!obstacles) return obstacles.error();
  const auto chosen = openInput(options.input, options.only);
  if (!chosen) return chosen.error();
  auto all = openInput(options.input, {.bodies = {}, .maxCells = options.only.maxCells});
  if (!all) return all.error();
  ResolveInput input{std::move(*obstacles), std::move(*all), {}};
  for (const model::Body& body : chosen->bodies) input.change.push_back(body.name);
  std::error_code ignored;
  if (std::filesystem::equivalent(options.obstacles, options.input, ignored)) {
    std::erase_if(input.obstacles.bodies, [&](const model::Body& body) {
      return options.against.empty() && std::ranges::count(input.change, body.name) > 0;
    });
    for (const model::Body& body : input.obstacles.bodies) {
      if (std::ranges::count(input.change, body.name) == 0) continue;
      return invalid(fmt::format("body '{}' cannot be an obstacle to itself", body.name),
                     options.input);
    }
    if (input.obstacles.bodies.empty()) {
      return invalid(
          "the same file twice has no obstacles; choose the bodies to deform with --body, and the "
          "others are obstacles",
          options.input);
    }
  }
  return input;
}

Result<std::string> pageOf(const ResolveInput& input, const ResolveReport& report) {
  std::vector<ResolvedView> views;
  for (const NamedResolvedBody& resolved : report.bodies) {
    ResolvedView view{resolved.name, resolved.report, {}, {}, {}};
    if (view.report.changed) {
      const double time = view.report.maxDisplacementTime;
      const model::Body& before =
          *std::ranges::find(input.all.bodies, resolved.name, &model::Body::name);
      const model::Body after{resolved.name, resolved.source.get()};
      for (const auto& [mesh, bodies] :
           {std::pair(&view.obstacles, std::span<const model::Body>(input.obstacles.bodies)),
            std::pair(&view.before, std::span<const model::Body>(&before, 1)),
            std::pair(&view.after, std::span<const model::Body>(&after, 1))}) {
        auto solids = measure::solidAt(bodies, time);
        if (!solids) return solids.error();
        *mesh = std::move(*solids);
      }
    }
    views.push_back(std::move(view));
  }
  return resolvePage(fmt::format("{} gives way to {}", input.all.name, input.obstacles.name),
                     input.all.metadata, views);
}

void printReport(const std::string& name, const edit::ResolveReport& report) {
  if (!report.changed) {
    print("  {}: clear already, nothing has moved\n", name);
    return;
  }
  const model::Point3& place = report.maxDisplacementPlace;
  print("  {}: moves by at most {:.6g}, at time {:.6g} at ({:.6g}, {:.6g}, {:.6g})\n", name,
        report.maxDisplacement, report.maxDisplacementTime, place[0], place[1], place[2]);
  print("    {} of {} have moved, over {:.6g} and a time of {:.6g}; {}, {}\n",
        counted(report.movedVertices, "vertex", "vertices"), counted(report.layers.size(), "layer"),
        report.smoothSpace, report.smoothTime, counted(report.addedLayers, "new layer"),
        counted(report.rounds, "round"));
  print("    change of volume at most {:.6g}, of hypervolume {:.6g}\n", report.volumeChangeMax,
        report.hypervolumeChange);
}

/// Prints what the mesh and the motions leave open.
void printOpenQuestions(const ResolveReport& resolved) {
  printNotices(resolved.notices);
  if (!resolved.decidingClearance) return;
  printNotices({fmt::format(
      "the meshes are clear, but the motions that they were swept from may still meet: with their "
      "steps, --clearance {} makes it certain",
      *resolved.decidingClearance)});
}

int run(ResolveArguments& options) {
  const std::string& output = options.resolve.output;
  const std::array inputs = {options.obstacles, options.input};
  if (auto good = checkOutputs(std::array{output, options.html}, inputs); !good) {
    return report(good.error());
  }
  const auto input = openBoth(options);
  if (!input) return report(input.error());
  std::optional<formats::OutputFile> html;
  if (!options.html.empty()) {
    auto created = formats::OutputFile::create(options.html);
    if (!created) return report(created.error());
    html.emplace(std::move(*created));
  }
  options.resolve.change = input->change;
  options.resolve.generator = versionText();
  ConsoleObserver observer;
  const auto resolved = resolve(input->obstacles, input->all, options.resolve, observer);
  if (!resolved) return report(resolved.error());
  if (html) {
    const ProgressBar bar("drawing");
    const auto page = pageOf(*input, *resolved);
    if (!page) return report(page.error());
    if (auto done = html->finish(*page); !done) return report(done.error());
  }
  printOpenQuestions(*resolved);
  if (options.json) {
    printAsJson(*resolved);
    return reportLosses(resolved->losses);
  }
  print("{}: clear of {}, {}\n", output, input->obstacles.name, sizeText(*resolved->bytes));
  for (const NamedResolvedBody& body : resolved->bodies) printReport(body.name, body.report);
  return reportLosses(resolved->losses);
}

}  // namespace

void addResolve(CLI::App& app, int& exitCode) {
  auto* command =
      app.add_subcommand("resolve", "Deform a 4D mesh to avoid contact with another one");
  auto options = std::make_shared<ResolveArguments>();
  command->add_option("OBSTACLES", options->obstacles, "Input file (.t4d) that stays unchanged")
      ->required();
  command->add_option("FILE", options->input, "Input file (.t4d) to deform")->required();
  addT4dOutputOption(*command, options->resolve.output);
  options->only.addTo(*command);
  command
      ->add_option("--against", options->against,
                   "Use only this body of OBSTACLES; repeatable (default: all)")
      ->type_name("NAME")
      ->allow_extra_args(false)
      ->check(someName());
  command
      ->add_option("--clearance", options->resolve.mesh.clearance,
                   "Distance to keep, in length units")
      ->check(numberFromZero())
      ->capture_default_str();
  command
      ->add_option("--smooth-space", options->resolve.mesh.smoothSpace,
                   "Extent of a dent, in length units (default: 3 times the largest displacement)")
      ->check(numberAboveZero());
  command
      ->add_option("--smooth-time", options->resolve.mesh.smoothTime,
                   "Extent of a dent in time, in time units (default: 0.1 of the body's time)")
      ->check(numberFromZero());
  command
      ->add_option("--max-move", options->resolve.mesh.maxMove,
                   "Maximum displacement, in length units (default: half the smallest extent)")
      ->check(numberAboveZero());
  command
      ->add_option("--max-rounds", options->resolve.mesh.maxRounds,
                   "Maximum number of contact tests")
      ->check(wholeNumber(1, 1000))
      ->capture_default_str();
  command->add_flag("--stay", options->resolve.mesh.stay, "Keep dents after the contact");
  command->add_flag("--ignore-units", options->resolve.ignoreUnits,
                    "Ignore differences in units and up axes");
  addCompressionOption(*command, options->resolve.compression);
  command
      ->add_option("--html", options->html,
                   "Write a page with plots over time and pictures before and after")
      ->check(htmlFile());
  addJsonOption<ResolveReport>(*command, options->json, "A 4D mesh that gives way to another one.");
  command->footer("Example:\n  t4d resolve plate.t4d ball.t4d --clearance 0.1 -o dented.t4d");
  command->callback([=, &exitCode] { exitCode = run(*options); });
}

}  // namespace t4d::tools
