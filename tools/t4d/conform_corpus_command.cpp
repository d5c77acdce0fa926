#include <algorithm>
#include <filesystem>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "conformance/driver/reader_cases.h"
#include "tools/t4d/commands.h"
#include "tools/t4d/console.h"
#include "tools/t4d/option_checks.h"

namespace t4d::tools {
namespace {

using namespace conformance;
namespace fs = std::filesystem;
using nlohmann::ordered_json;

int copy(const std::string& directory, bool force) {
  std::error_code error;
  if (fs::exists(directory, error)) {
    const bool empty = fs::is_directory(directory, error) && fs::is_empty(directory, error);
    if (!empty && !(force && fs::is_directory(directory, error))) {
      return wrongUsage(
          directory + ": is not an empty folder" +
          (fs::is_directory(directory, error) ? "; --force writes over what is there" : ""));
    }
  }
  if (auto written = writeCorpus(directory); !written) return report(written.error());
  print("{}: the corpus {}, {} files; README.md says what is in them\n", directory, kCorpusVersion,
        makeCorpus().size());
  return kDone;
}

/// The required result for the files of a case.
std::string resultOf(const ReaderCase& test) {
  if (test.id.starts_with("overwrite/")) return "valid";
  if (test.id.starts_with("cut/") || test.id.starts_with("flip/")) return "invalid";
  return conformance::nameOf(test.file->validity);
}

std::string faultOf(const ReaderCase& test) {
  // Some files are both described and sliced.
  const auto count = [&](const char* request) {
    return static_cast<std::size_t>(std::ranges::count_if(
        test.trials,
        [&](const conformance::Trial& trial) { return trial.request.front() == request; }));
  };
  if (test.id.starts_with("cut/")) {
    return fmt::format("{} truncated to {}.", test.file->id, counted(count("describe"), "length"));
  }
  if (test.id.starts_with("flip/")) {
    return fmt::format("{} with a bit flipped, in {}.", test.file->id,
                       counted(count("describe"), "place"));
  }
  if (test.id.starts_with("overwrite/")) {
    return fmt::format("{} with everything overwritten that a slice does not need, at {}.",
                       test.file->id, counted(count("slice"), "time"));
  }
  return test.file->fault;
}

int list(const std::vector<std::string>& only, const std::vector<std::string>& skip, bool json) {
  const std::vector<CorpusFile> files = makeCorpus();
  std::vector<ReaderCase> cases = readerCases(files);
  if (auto done = selectCases(cases, only, skip); !done) {
    return wrongUsage(done.error().text());
  }
  std::erase_if(cases, [](const ReaderCase& test) { return !test.skipped.empty(); });
  if (json) {
    ordered_json value = {{"corpus_version", kCorpusVersion}, {"cases", ordered_json::array()}};
    for (const ReaderCase& test : cases) {
      const bool asItIs = test.id == test.file->id;
      ordered_json entry = {{"id", test.id},     {"result", resultOf(test)},
                            {"clause", nullptr}, {"fault", faultOf(test)},
                            {"offset", nullptr}, {"features", test.file->features}};
      if (asItIs && !test.file->rule.empty()) entry["clause"] = test.file->rule;
      if (asItIs && test.file->offset) entry["offset"] = *test.file->offset;
      value["cases"].push_back(std::move(entry));
    }
    printJson(value);
    return kDone;
  }
  std::size_t width = 0;
  for (const ReaderCase& test : cases) width = std::max(width, test.id.size());
  for (const ReaderCase& test : cases) {
    const std::string rule = test.id == test.file->id ? test.file->rule : "";
    print("{:{}}  {:7}  {:3}  {}\n", test.id, width, resultOf(test), rule, faultOf(test));
  }
  return kDone;
}

}  // namespace

void addConformCorpus(CLI::App& conform, int& exitCode) {
  auto* copying = conform.add_subcommand(
      "copy", "Write the corpus, test files with expected answers, to a folder");
  auto directory = std::make_shared<std::string>();
  auto force = std::make_shared<bool>(false);
  copying->add_option("DIR", *directory, "Output folder; created if missing")
      ->required()
      ->check(someName());
  copying->add_flag("--force", *force, "Write to a folder that is not empty");
  copying->footer("Example:\n  t4d conform copy corpus");
  copying->callback([=, &exitCode] { exitCode = copy(*directory, *force); });

  auto* listing = conform.add_subcommand(
      "list", "List the cases of `conform reader`: expected result, broken rule and fault");
  auto only = std::make_shared<std::vector<std::string>>();
  auto skip = std::make_shared<std::vector<std::string>>();
  auto json = std::make_shared<bool>(false);
  listing->add_option("--only", *only, "List only these cases: globs or folders ('cut')")
      ->type_name("GLOB");
  listing->add_option("--skip", *skip, "Skip these cases")->type_name("GLOB");
  listing->add_flag("--json", *json, "Print JSON");
  listing->footer("Example:\n  t4d conform list --only 'invalid/H*'");
  listing->callback([=, &exitCode] { exitCode = list(*only, *skip, *json); });
}

}  // namespace t4d::tools
