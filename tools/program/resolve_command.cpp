#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <memory>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "t4d/edit/contact_times.h"
#include "t4d/edit/resolve.h"
#include "t4d/formats/output_file.h"
#include "t4d/formats/t4d/writer.h"
#include "t4d/measure/chord_bound.h"
#include "t4d/measure/compare.h"
#include "t4d/verbs/json_text.h"
#include "tools/program/commands.h"
#include "tools/program/console.h"
#include "tools/program/input_options.h"
#include "tools/program/option_checks.h"
#include "tools/program/progress_bar.h"
#include "tools/program/resolve_page.h"
#include "tools/program/t4d_output.h"
#include "tools/program/version.h"

namespace t4d::tools {
namespace {

using nlohmann::ordered_json;

struct ResolveArguments {
  std::string obstacles;
  std::string input;
  std::vector<std::string> against;  // bodies of `obstacles`; none for all
  InputOptions only;                 // of `input`
  std::string output;
  edit::ResolveOptions resolve;
  bool ignoreUnits = false;
  int compression = 3;
  std::string html;
  bool json = false;
};

/// The bodies of both files.
struct ResolveInput {
  verbs::Input obstacles;
  verbs::Input all;                 // of the file that is changed
  std::vector<std::string> change;  // names of those that give way
};

Result<ResolveInput> openBoth(const ResolveArguments& options) {
  auto obstacles = verbs::openInput(options.obstacles,
                                    {.bodies = options.against, .maxCells = options.only.maxCells});
  if (!obstacles) return obstacles.error();
  const auto chosen = verbs::openInput(options.input, options.only);
  if (!chosen) return chosen.error();
  auto all = verbs::openInput(options.input, {.bodies = {}, .maxCells = options.only.maxCells});
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
          "all bodies of the file are to give way; choose some by --body, and the "
          "others are obstacles",
          options.input);
    }
  }
  if (!options.ignoreUnits) {
    if (auto same = verbs::checkSameUnits(input.obstacles, input.all); !same) return same.error();
  }
  return input;
}

Result<std::string> pageOf(const ResolveInput& input,
                           const std::vector<edit::ResolvedBody>& resolved) {
  const formats::Metadata& metadata = input.all.metadata;
  ResolvePage page{fmt::format("{} gives way to {}", input.all.name, input.obstacles.name),
                   metadata.lengthUnit,
                   metadata.timeUnit,
                   metadata.up == "z",
                   {}};
  for (std::size_t i = 0; i < resolved.size(); ++i) {
    const model::Body& body = input.all.bodies[i];
    if (std::ranges::count(input.change, body.name) == 0) continue;
    ResolvedView view{body.name, resolved[i].report, {}, {}, {}};
    if (view.report.changed) {
      const double time = view.report.maxDisplacementTime;
      const model::Body after{body.name, resolved[i].source.get()};
      for (const auto& [mesh, bodies] :
           {std::pair(&view.obstacles, std::span<const model::Body>(input.obstacles.bodies)),
            std::pair(&view.before, std::span<const model::Body>(&body, 1)),
            std::pair(&view.after, std::span<const model::Body>(&after, 1))}) {
        auto solids = measure::solidAt(bodies, time);
        if (!solids) return solids.error();
        *mesh = std::move(*solids);
      }
    }
    page.bodies.push_back(std::move(view));
  }
  return resolvePage(page);
}

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

Result<std::uint64_t> write(const ResolveArguments& options, const ResolveInput& input,
                            const std::vector<edit::ResolvedBody>& resolved,
                            std::vector<std::string>& losses) {
  auto writer = formats::T4dWriter::create(options.output, metadataOf(input.all, versionText()),
                                           {.compression = options.compression});
  if (!writer) return writer.error();
  std::uint64_t slabs = 0;
  for (const edit::ResolvedBody& body : resolved) slabs += body.source->slabCount();
  ProgressBar bar("writing " + options.output, slabs, "slabs");
  std::set<std::string> dropped;
  for (std::size_t i = 0; i < resolved.size(); ++i) {
    const model::Source& source = *resolved[i].source;
    WithoutStale current(writer->body(i), input.all.metadata.attributes, dropped);
    model::Sink& sink = resolved[i].report.changed ? current : writer->body(i);
    if (auto put = model::pump(source, sink, bar.part(source.slabCount())); !put) {
      return put.error();
    }
  }
  for (const std::string& name : dropped) {
    losses.push_back(fmt::format("attribute '{}': the surface that it was of has given way", name));
  }
  auto bytes = finishEdited(*writer, input.all);
  for (std::string& line : writer->losses()) losses.push_back(std::move(line));
  return bytes;
}

/// What the true motions need.
struct Deciding {
  double chordBound = 0;  ///< the largest of a body and an obstacle together
  bool known = true;      ///< whether that is known of all
  /// The clearance that makes it certain that no body meets an obstacle; nothing if it is already.
  std::optional<double> clearance = {};
};

/// Looks whether a resolved body is clear of the obstacles by more than the bounds of chords: that
/// of the body is the one it had before, since what is known of its motion was known then.
Result<void> decide(const ResolveArguments& options, const ResolveInput& input,
                    const model::Body& before, const edit::ResolvedBody& resolved,
                    Deciding& deciding, const model::Progress& progress) {
  const model::TimeSpan span = model::timeSpanOf(*before.source);
  const auto own = measure::chordBound(*before.source, span, motionOf(input.all, before.name));
  if (!own) return own.error();
  for (const model::Body& obstacle : input.obstacles.bodies) {
    const auto other =
        measure::chordBound(*obstacle.source, span, motionOf(input.obstacles, obstacle.name));
    if (!other) return other.error();
    deciding.known = deciding.known && *own && *other;
    const double bound = (*own ? (*own)->bound : 0) + (*other ? (*other)->bound : 0);
    deciding.chordBound = std::max(deciding.chordBound, bound);
    if (bound == 0 || bound < options.resolve.clearance) continue;
    // With some digits, and certainly more.
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

ordered_json jsonOf(const edit::ResolveReport& report) {
  ordered_json layers = ordered_json::array();
  for (const edit::ResolvedLayer& layer : report.layers) {
    layers.push_back({{"time", layer.time},
                      {"displacement", layer.displacement},
                      {"volume_before", layer.volumeBefore},
                      {"volume_after", layer.volumeAfter}});
  }
  return {{"changed", report.changed},
          {"max_displacement", report.maxDisplacement},
          {"max_displacement_time", report.maxDisplacementTime},
          {"max_displacement_point",
           {report.maxDisplacementPlace[0], report.maxDisplacementPlace[1],
            report.maxDisplacementPlace[2]}},
          {"volume_change_max", report.volumeChangeMax},
          {"hypervolume_change", report.hypervolumeChange},
          {"rounds", report.rounds},
          {"moved_vertices", report.movedVertices},
          {"added_layers", report.addedLayers},
          {"smooth_space", report.smoothSpace},
          {"smooth_time", report.smoothTime},
          {"layers", layers}};
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

int run(const ResolveArguments& options) {
  const std::array inputs = {options.obstacles, options.input};
  for (const std::string& output : {options.output, options.html}) {
    if (output.empty()) continue;
    if (const auto misuse = misuseOfOutput(output, inputs)) return wrongUsage(*misuse);
  }
  if (const auto misuse = misuseOfOutputs(std::array{options.output, options.html})) {
    return wrongUsage(*misuse);
  }
  if (auto writable = checkWritable({{options.output}}); !writable) {
    return report(writable.error());
  }
  const auto input = openBoth(options);
  if (!input) return report(input.error());
  std::optional<formats::OutputFile> html;
  if (!options.html.empty()) {
    auto created = formats::OutputFile::create(options.html);
    if (!created) return report(created.error());
    html.emplace(std::move(*created));
  }
  const model::TimeSpan timeOfObstacles = model::timeSpanOf(input->obstacles.bodies);
  std::vector<edit::ResolvedBody> resolved;
  std::vector<std::string> notices;
  edit::ResolveReport all;
  Deciding deciding;
  ordered_json bodies = ordered_json::array();
  for (const model::Body& body : input->all.bodies) {
    if (std::ranges::count(input->change, body.name) == 0) {
      resolved.push_back(
          {std::shared_ptr<const model::Source>(std::shared_ptr<void>(), body.source), {}});
      continue;
    }
    const model::TimeSpan time = model::timeSpanOf(*body.source);
    if (time.begin > timeOfObstacles.end || time.end < timeOfObstacles.begin) {
      notices.push_back(
          fmt::format("body '{}' exists from {} to {}, the obstacles from {} to {}: never together",
                      body.name, time.begin, time.end, timeOfObstacles.begin, timeOfObstacles.end));
    }
    ProgressBar bar("resolving " + body.name);
    auto one = edit::resolve(input->obstacles.bodies, body, options.resolve, bar.callback());
    if (!one) return report(inInput(one.error(), input->all));
    all.changed = all.changed || one->report.changed;
    all.maxDisplacement = std::max(all.maxDisplacement, one->report.maxDisplacement);
    if (std::abs(one->report.volumeChangeMax) > std::abs(all.volumeChangeMax)) {
      all.volumeChangeMax = one->report.volumeChangeMax;
    }
    all.hypervolumeChange += one->report.hypervolumeChange;
    all.rounds = std::max(all.rounds, one->report.rounds);
    all.movedVertices += one->report.movedVertices;
    {
      ProgressBar check("checking " + body.name);
      if (auto done = decide(options, *input, body, *one, deciding, check.callback()); !done) {
        return report(inInput(done.error(), input->all));
      }
    }
    ordered_json json = {{"name", body.name}};
    json.update(jsonOf(one->report));
    bodies.push_back(std::move(json));
    resolved.push_back(std::move(*one));
  }
  std::vector<std::string> losses;
  const auto bytes = write(options, *input, resolved, losses);
  if (!bytes) return report(inInput(bytes.error(), input->all));
  if (html) {
    const ProgressBar bar("drawing");
    const auto page = pageOf(*input, resolved);
    if (!page) return report(page.error());
    if (auto done = html->write(page->data(), page->size()); !done) return report(done.error());
    if (auto done = html->commit(); !done) return report(done.error());
  }
  if (deciding.clearance) {
    notices.push_back(
        fmt::format("the meshes are clear, but the motions that they were swept from may still "
                    "meet: with their "
                    "steps, --clearance {} makes it certain",
                    *deciding.clearance));
  }
  printNotices(notices);
  if (options.json) {
    printJson({{"clear", true},
               {"chord_bound", deciding.known ? ordered_json(deciding.chordBound) : ordered_json()},
               {"deciding_clearance", verbs::orNull(deciding.clearance)},
               {"changed", all.changed},
               {"max_displacement", all.maxDisplacement},
               {"volume_change_max", all.volumeChangeMax},
               {"hypervolume_change", all.hypervolumeChange},
               {"rounds", all.rounds},
               {"moved_vertices", all.movedVertices},
               {"bodies", bodies},
               {"bytes", *bytes}});
    return reportLosses(losses);
  }
  print("{}: clear of {}, {}\n", options.output, input->obstacles.name, sizeText(*bytes));
  for (std::size_t i = 0; i < resolved.size(); ++i) {
    const std::string& name = input->all.bodies[i].name;
    if (std::ranges::count(input->change, name) > 0) printReport(name, resolved[i].report);
  }
  return reportLosses(losses);
}

}  // namespace

void addResolve(CLI::App& app, int& exitCode) {
  auto* command =
      app.add_subcommand("resolve", "Deform a 4D mesh to avoid contact with another one");
  auto options = std::make_shared<ResolveArguments>();
  command->add_option("OBSTACLES", options->obstacles, "Input file (.t4d) that stays unchanged")
      ->required();
  command->add_option("FILE", options->input, "Input file (.t4d) to deform")->required();
  addT4dOutputOption(*command, options->output);
  options->only.addTo(*command);
  command
      ->add_option("--against", options->against,
                   "Use only this body of OBSTACLES; repeatable (default: all)")
      ->type_name("NAME")
      ->allow_extra_args(false)
      ->check(someName());
  command
      ->add_option("--clearance", options->resolve.clearance, "Distance to keep, in length units")
      ->check(numberFromZero())
      ->capture_default_str();
  command
      ->add_option("--smooth-space", options->resolve.smoothSpace,
                   "Extent of a dent, in length units (default: 3 times the largest displacement)")
      ->check(numberAboveZero());
  command
      ->add_option("--smooth-time", options->resolve.smoothTime,
                   "Extent of a dent in time, in time units (default: 0.1 of the body's time)")
      ->check(numberFromZero());
  command
      ->add_option("--max-move", options->resolve.maxMove,
                   "Maximum displacement, in length units (default: half the smallest extent)")
      ->check(numberAboveZero());
  command->add_option("--max-rounds", options->resolve.maxRounds, "Maximum number of contact tests")
      ->check(wholeNumber(1, 1000))
      ->capture_default_str();
  command->add_flag("--stay", options->resolve.stay, "Keep dents after the contact");
  command->add_flag("--ignore-units", options->ignoreUnits,
                    "Ignore differences in units and up axes");
  addCompressionOption(*command, options->compression);
  command
      ->add_option("--html", options->html,
                   "Write a page with plots over time and pictures before and after")
      ->check(someName());
  command->add_flag("--json", options->json, "Print JSON");
  command->footer("Example:\n  t4d resolve plate.t4d ball.t4d --clearance 0.1 -o dented.t4d");
  command->callback([=, &exitCode] { exitCode = run(*options); });
}

}  // namespace t4d::tools
