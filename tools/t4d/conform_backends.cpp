#include <algorithm>
#include <cmath>
#include <filesystem>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <fnmatch.h>
#include <nlohmann/json.hpp>

#include "conformance/backends/own_backends.h"
#include "conformance/backends/program_backend.h"
#include "formats/output_file.h"
#include "formats/output_folder.h"
#include "t4d/conformance.h"
#include "tools/t4d/commands.h"
#include "tools/t4d/conform_page.h"
#include "tools/t4d/console.h"
#include "tools/t4d/json_option.h"
#include "tools/t4d/json_text.h"
#include "tools/t4d/option_checks.h"

namespace t4d::tools {
namespace {

using conformance::Backend;
using conformance::Case;
using conformance::CaseResult;
using conformance::Check;
using nlohmann::ordered_json;

struct ConformBackendsArguments {
  std::vector<std::string> backends;
  bool programGiven = false;
  conformance::ProgramOptions program;
  std::string keep;
  std::vector<std::string> cases;  // globs
  bool quick = false;
  bool list = false;
  bool json = false;
  std::string html;
};

std::vector<std::string> ownNames() {
  std::vector<std::string> names;
  for (const auto& backend : conformance::ownBackends()) names.push_back(backend->name());
  return names;
}

Result<std::vector<std::unique_ptr<Backend>>> backendsOf(const ConformBackendsArguments& options) {
  const auto asked = [&](const std::string& name) {
    if (options.backends.empty()) return !options.programGiven;
    return std::find(options.backends.begin(), options.backends.end(), name) !=
           options.backends.end();
  };
  std::vector<std::unique_ptr<Backend>> backends = conformance::ownBackends();
  std::erase_if(backends, [&](const auto& backend) { return !asked(backend->name()); });
  if (options.programGiven) {
    conformance::ProgramOptions program = options.program;
    program.keep = options.keep;
    auto backend = conformance::programBackend(std::move(program));
    if (!backend) return backend.error();
    backends.push_back(std::move(*backend));
  }
  return backends;
}

bool isWanted(const Case& given, const ConformBackendsArguments& options) {
  if (options.quick && given.large) return false;
  return options.cases.empty() ||
         std::any_of(options.cases.begin(), options.cases.end(), [&](const std::string& glob) {
           return fnmatch(glob.c_str(), given.id.c_str(), 0) == 0;
         });
}

ordered_json jsonOf(const conformance::Value& value) {
  return std::visit([](auto number) { return ordered_json(number); }, value);
}

/// What a backend makes of the cases.
struct BackendRun {
  std::vector<CaseResult> cases;
  std::size_t passed = 0;
};

void describeLevel(Members& members, const conformance::Level& level) {
  const bool voxels = level.resolution.voxelSize > 0;
  members("voxel_size", voxels ? std::optional(level.resolution.voxelSize) : std::nullopt,
          "Voxel size, in length units; null if there are no voxels.")
      .above(0);
  members("steps", voxels ? std::optional(level.resolution.steps) : std::nullopt,
          "Number of intervals between frames; null if there are no voxels.")
      .atLeast(1);
  members("vertices", level.mesh.vertices, "Vertices of the mesh, each counted once.");
  members("tetrahedra", level.mesh.tetrahedra, "Cells of the mesh.");
  members("hypervolume", level.mesh.hypervolume,
          "Enclosed hypervolume, in cubed length units times time units.")
      .orNull();
  members("error_hypervolume", level.hypervolumeError,
          "|found - expected| / expected of the hypervolume; null if nothing is expected.")
      .atLeast(0);
  members(
      "error_slices", level.sliceError,
      "|found - expected| / expected of the slice volumes, root mean square; null if nothing is "
      "expected.")
      .atLeast(0);
}

void describeCheck(Members& members, const Check& check) {
  const std::vector<std::string> anyNumber = {"boolean", "number", "null"};
  members("name", check.name, "What was checked, after the voxel size if there are several.");
  members("expected", jsonOf(check.expected), "A boolean, a count, or a measure.").types(anyNumber);
  members("actual", jsonOf(check.actual), "What was found.").types(anyNumber);
  members("tolerance", check.tolerance,
          "The largest allowed difference between actual and expected.")
      .atLeast(0)
      .orNull();
  members("passed", check.passed, "Whether the difference is at most the tolerance.");
  members("reason", check.reason, "The reason for the tolerance, or for the check.");
  members("found", check.found,
          "Description of a failure that the numbers do not explain; otherwise empty.");
}

void describeCase(Members& members, const CaseResult& result) {
  members("id", result.id, "As `--list` prints it and `--case` takes it.")
      .pattern("^[a-z]+(-[a-z]+)*$");
  members("backend", result.backend, "The backend: a name that `--backend` takes, or `program`.")
      .notEmpty();
  members("passed", result.passed(), "Whether every check passed.");
  members("description", result.description, "The solid and its motion.");
  members(
      "expected_hypervolume", result.hypervolumeExpected,
      "Hypervolume of the last level by the closed form, in cubed length units times time units; "
      "null if there is none.")
      .atLeast(0);
  members(
      "worst_error", result.worstError,
      "The largest |found - expected| / expected of the hypervolume and the volumes of slices of "
      "the last level; null if no mesh was built.")
      .atLeast(0);
  members(
      "order_hypervolume", result.orders.hypervolume,
      "The order of convergence of the hypervolume's error between the first and the last level; "
      "null for one level.");
  members("order_slices", result.orders.slices,
          "The order of convergence of the error of slice volumes (root mean square); null for one "
          "level.");
  members("seconds", result.seconds,
          "Time to build and check the meshes, while other cases were running.")
      .atLeast(0);
  members("levels", result.levels,
          "The meshes: one, or one for each voxel size, from large to small.", describeLevel);
  members("checks", result.checks, "All checks.", describeCheck).itemsFrom(1);
}

void describe(Members& members, const BackendRun& run) {
  members("cases", run.cases, "One for each case and backend.", describeCase).itemsFrom(1);
  members("passed", run.passed, "Number of cases that passed every check.");
  members("failed", run.cases.size() - run.passed, "Number of the other cases.");
}

void printText(const std::vector<CaseResult>& results, std::size_t passed) {
  std::vector<std::vector<std::string>> rows = {conformColumns()};
  for (const CaseResult& result : results) rows.push_back(conformRow(result));
  printTable(rows, "llrrrrrrl");
  constexpr std::size_t kShown = 5;
  for (const CaseResult& result : results) {
    std::size_t failed = 0;
    for (const Check& check : result.checks) {
      if (check.passed || ++failed > kShown) continue;
      const std::string differ =
          check.tolerance > 0 ? fmt::format(", tolerance {:.2g}", check.tolerance) : "";
      print("FAILED {} by {}: {}: expected {}, found {}{} ({})\n", result.id, result.backend,
            check.name, valueText(check.expected), valueText(check.actual), differ, check.reason);
      if (!check.found.empty()) print("       {}\n", check.found);
    }
    if (failed > kShown) {
      print("       and {} more of this case; --json and --html show all\n",
            counted(failed - kShown, "check"));
    }
  }
  print("{} of {} cases passed\n", passed, results.size());
}

int list(const std::vector<Case>& cases, const std::vector<std::unique_ptr<Backend>>& backends,
         const ConformBackendsArguments& options) {
  std::vector<std::vector<std::string>> rows;
  for (const Case& given : cases) {
    if (!isWanted(given, options)) continue;
    std::vector<std::string> names;
    for (const auto& backend : backends) {
      if (backend->supports(given)) names.push_back(backend->name());
    }
    rows.push_back({given.id, fmt::format("{}", fmt::join(names, ", ")), given.description});
  }
  printTable(rows, "l");
  return kDone;
}

int run(const ConformBackendsArguments& options) {
  const std::vector<Case> cases = conformance::analyticCases();
  const auto backends = backendsOf(options);
  if (!backends) return wrongUsage(backends.error().text());
  std::vector<conformance::Job> jobs;
  for (const Case& given : cases) {
    if (!isWanted(given, options)) continue;
    for (const auto& backend : *backends) {
      if (backend->supports(given)) jobs.push_back({&given, backend.get()});
    }
  }
  if (jobs.empty()) {
    return wrongUsage("no case matches these options; `t4d conform backends --list` lists them");
  }
  if (options.list) return list(cases, *backends, options);
  if (!options.keep.empty()) {
    if (auto made = formats::makeKeptFolder(options.keep); !made) return report(made.error());
  }
  std::optional<formats::OutputFile> page;
  if (!options.html.empty()) {
    auto created = formats::OutputFile::create(options.html);
    if (!created) return report(created.error());
    page.emplace(std::move(*created));
  }

  std::vector<CaseResult> results;
  {
    ProgressBar bar("testing the backends");
    const model::Progress show = bar.callback();
    double done = 0;
    results = conformance::runCases(jobs, options.quick, [&](const CaseResult&) {
      ++done;
      show(done / static_cast<double>(jobs.size()));
    });
  }
  const auto passed = static_cast<std::size_t>(std::count_if(
      results.begin(), results.end(), [](const CaseResult& result) { return result.passed(); }));
  if (page) {
    if (auto written = page->finish(conformPage(results)); !written) return report(written.error());
  }
  if (options.json) {
    printAsJson(BackendRun{results, passed});
  } else {
    printText(results, passed);
  }
  return passed == results.size() ? kDone : kFailed;
}

}  // namespace

void addConformBackends(CLI::App& conform, int& exitCode) {
  auto* command =
      conform.add_subcommand("backends", "Check the backends against closed-form solutions");
  auto options = std::make_shared<ConformBackendsArguments>();
  command
      ->add_option("--backend", options->backends, "Test this backend; repeatable (default: all)")
      ->check(CLI::IsMember(ownNames()))
      ->allow_extra_args(false);
  auto* program = command->add_option("--backend-program", options->program.command,
                                      "Test a program, run as CMD CASE.obj MOTION.json OUT.t4d");
  command
      ->add_option("--tolerance", options->program.tolerance,
                   "Relative tolerance of the program's times, lengths and volumes")
      ->check(numberAboveZero())
      ->capture_default_str()
      ->needs(program);
  command->add_option("--timeout", options->program.timeoutSeconds, "Timeout per case, in seconds")
      ->check(numberAboveZero())
      ->capture_default_str()
      ->needs(program);
  command->add_option("--keep", options->keep, "Keep the program's files in this folder")
      ->check(someName())
      ->needs(program);
  command
      ->add_option("--case", options->cases,
                   "Run only cases whose name matches this glob; repeatable")
      ->allow_extra_args(false);
  command->add_flag("--quick", options->quick, "Skip the smallest voxels and the large case");
  auto* json = addJsonOption<BackendRun>(
      *command, options->json,
      "Every check of the meshes that backends built of moving solids with closed-form solutions. "
      "Measures are null if they are not numbers or too large for a double.");
  auto* html = command
                   ->add_option("--html", options->html,
                                "Write a page: the table, convergence plots, every check")
                   ->check(htmlFile());
  command->add_flag("--list", options->list, "List the cases and run nothing")
      ->excludes(json)
      ->excludes(html);
  command->footer(
      "Example:\n"
      "  t4d conform backends --html backends.html\n"
      "  t4d conform backends --backend voxel4d --case 'cube-*'\n"
      "  t4d conform backends --backend-program ./my-sweep\n\n"
      "Exit codes: 0 every case passed, 1 some failed, 2 wrong usage.");
  command->callback([=, &exitCode] {
    options->programGiven = program->count() > 0;
    exitCode = run(*options);
  });
}

}  // namespace t4d::tools
