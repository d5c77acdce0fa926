#include <algorithm>
#include <array>
#include <filesystem>
#include <memory>

#include <fmt/format.h>

#include "formats/output_file.h"
#include "t4d/check.h"
#include "tools/t4d/commands.h"
#include "tools/t4d/console.h"
#include "tools/t4d/console_observer.h"
#include "tools/t4d/input_options.h"
#include "tools/t4d/json_option.h"
#include "tools/t4d/option_checks.h"
#include "tools/t4d/progress_bar.h"
#include "tools/t4d/resolve_page.h"
#include "tools/t4d/t4d_output.h"
#include "tools/t4d/version.h"
#include "tools/verbs/resolve.h"

namespace t4d::tools {
namespace {

struct ResolveArguments {
  std::string obstacles;
  std::string input;
  std::vector<std::string> against;  // bodies of `obstacles`; none for all
  InputOptions only;                 // of `input`
  verbs::ResolveOptions resolve;
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
          "the same file twice has no obstacles; choose the bodies to deform with --body, and the "
          "others are obstacles",
          options.input);
    }
  }
  return input;
}

Result<std::string> pageOf(const ResolveInput& input, const verbs::ResolveReport& report) {
  std::vector<ResolvedView> views;
  for (const verbs::NamedResolvedBody& resolved : report.bodies) {
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
void printOpenQuestions(const verbs::ResolveReport& resolved) {
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
  const auto resolved = verbs::resolve(input->obstacles, input->all, options.resolve, observer);
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
  for (const verbs::NamedResolvedBody& body : resolved->bodies) printReport(body.name, body.report);
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
  addJsonOption<verbs::ResolveReport>(*command, options->json,
                                      "A 4D mesh that gives way to another one.");
  command->footer("Example:\n  t4d resolve plate.t4d ball.t4d --clearance 0.1 -o dented.t4d");
  command->callback([=, &exitCode] { exitCode = run(*options); });
}

}  // namespace t4d::tools
