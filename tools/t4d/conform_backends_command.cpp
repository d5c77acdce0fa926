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
#include "tools/t4d/option_checks.h"
#include "tools/verbs/json_text.h"

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

ordered_json jsonOf(const CaseResult& result) {
  ordered_json checks = ordered_json::array();
  for (const Check& check : result.checks) {
    checks.push_back({{"name", check.name},
                      {"expected", jsonOf(check.expected)},
                      {"actual", jsonOf(check.actual)},
                      {"tolerance", check.tolerance},
                      {"passed", check.passed},
                      {"reason", check.reason},
                      {"found", check.found}});
  }
  ordered_json levels = ordered_json::array();
  for (const conformance::Level& level : result.levels) {
    const bool voxels = level.resolution.voxelSize > 0;
    levels.push_back({{"voxel_size", voxels ? ordered_json(level.resolution.voxelSize) : nullptr},
                      {"steps", voxels ? ordered_json(level.resolution.steps) : nullptr},
                      {"vertices", level.mesh.vertices},
                      {"tetrahedra", level.mesh.tetrahedra},
                      {"hypervolume", level.mesh.hypervolume},
                      {"error_hypervolume", verbs::orNull(level.hypervolumeError)},
                      {"error_slices", verbs::orNull(level.sliceError)}});
  }
  return {{"id", result.id},
          {"backend", result.backend},
          {"passed", result.passed()},
          {"description", result.description},
          {"expected_hypervolume", verbs::orNull(result.hypervolumeExpected)},
          {"worst_error", verbs::orNull(result.worstError)},
          {"order_hypervolume", verbs::orNull(result.orders.hypervolume)},
          {"order_slices", verbs::orNull(result.orders.slices)},
          {"seconds", result.seconds},
          {"levels", levels},
          {"checks", checks}};
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
    ordered_json all = ordered_json::array();
    for (const CaseResult& result : results) all.push_back(jsonOf(result));
    printJson({{"cases", all}, {"passed", passed}, {"failed", results.size() - passed}});
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
  auto* json = command->add_flag("--json", options->json, "Print every check as JSON");
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
