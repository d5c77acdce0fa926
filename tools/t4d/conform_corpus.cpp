#include <algorithm>
#include <filesystem>

#include <fmt/format.h>

#include "conformance/driver/reader_cases.h"
#include "tools/t4d/commands.h"
#include "tools/t4d/conform_run.h"
#include "tools/t4d/console.h"
#include "tools/t4d/json_option.h"
#include "tools/t4d/option_checks.h"

namespace t4d::tools {
namespace {

using namespace conformance;
namespace fs = std::filesystem;

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

struct CaseList {
  std::vector<ReaderCase> cases;
};

void describe(Members& members, const CaseList& list) {
  members("corpus_version", kCorpusVersion, "Version of the corpus.").pattern(kVersionPattern);
  members(
      "cases", list.cases, "Valid files first, the simplest ones leading; damaged files last.",
      [](Members& own, const ReaderCase& test) {
        static const CorpusFile kNone;
        const CorpusFile& file = test.file == nullptr ? kNone : *test.file;
        const bool asItIs = test.id == file.id;
        own("id", test.id, "Name of the corpus file, or of the damage to a valid one.")
            .pattern("^(valid|impl|invalid|cut|flip|overwrite)/.");
        own("result", test.file == nullptr ? "" : resultOf(test),
            "What a reader must find. Files in which only slabs that a slice does not need are "
            "overwritten are valid: the slice is still right.")
            .oneOf({"valid", "invalid", "either"});
        own("clause", asItIs && !file.rule.empty() ? std::optional(file.rule) : std::nullopt,
            "The rule of SPEC.md that is broken, or the heading that leaves the decision to the "
            "reader; null otherwise.")
            .notEmpty();
        own("fault", test.file == nullptr ? "" : faultOf(test),
            "What the case tests, in a sentence.")
            .notEmpty();
        own("offset", asItIs ? file.offset : std::nullopt,
            "Byte of the fault; null if it is not in one place.");
        own("features", file.features, "The features that the file uses.");
      });
}

int list(const std::vector<std::string>& only, const std::vector<std::string>& skip, bool json) {
  const std::vector<CorpusFile> files = makeCorpus();
  std::vector<ReaderCase> cases = readerCases(files);
  if (auto done = selectCases(cases, only, skip); !done) {
    return wrongUsage(done.error().text());
  }
  std::erase_if(cases, [](const ReaderCase& test) { return !test.skipped.empty(); });
  if (json) {
    printAsJson(CaseList{cases});
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
  addJsonOption<CaseList>(*listing, *json, "The cases of t4d conform reader, in order.");
  listing->footer("Example:\n  t4d conform list --only 'invalid/H*'");
  listing->callback([=, &exitCode] { exitCode = list(*only, *skip, *json); });
}

}  // namespace t4d::tools
