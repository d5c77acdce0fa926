#include <atomic>
#include <csignal>
#include <thread>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <sys/resource.h>

#include "conformance/driver/reader_report.h"
#include "formats/output_file.h"
#include "tools/commands.h"
#include "tools/console.h"

namespace t4d::tools {
namespace {

using namespace conformance;

struct Options {
  std::string reader;
  std::vector<std::string> only;
  std::vector<std::string> skip;
  std::vector<std::string> without;
  unsigned parallel = std::max(1U, std::thread::hardware_concurrency());
  double seconds = 10;
  std::string junit;
  std::string keep;
  bool first = false;
  bool json = false;
  bool verbose = false;
};

std::atomic<bool> interrupted = false;

/// While it lives, Ctrl-C ends the readers that run and lets this program put its things away.
class Interruptible {
 public:
  Interruptible() {
    struct sigaction action {};
    action.sa_handler = [](int) { interrupted = true; };
    sigaction(SIGINT, &action, &interrupt_);
    sigaction(SIGTERM, &action, &terminate_);
  }
  ~Interruptible() {
    sigaction(SIGINT, &interrupt_, nullptr);
    sigaction(SIGTERM, &terminate_, nullptr);
  }
  Interruptible(const Interruptible&) = delete;
  Interruptible& operator=(const Interruptible&) = delete;

 private:
  struct sigaction interrupt_ {};
  struct sigaction terminate_ {};
};

/// A reader that crashes a hundred times should not leave a hundred core dumps.
void leaveNoCoreDumps() {
  const rlimit none{0, 0};
  setrlimit(RLIMIT_CORE, &none);
}

Result<void> writeText(const std::string& path, const std::string& text) {
  auto file = formats::OutputFile::create(path);
  if (!file) return pass(file.error());
  return file->write(text.data(), text.size()).and_then([&] { return file->commit(); });
}

int wrongUsage(const Error& error) {
  fmt::print(stderr, "t4d: {}\n", error.text());
  return kUsage;
}

int run(const Options& options) {
  const auto command = readerCommand(options.reader);
  if (!command) return wrongUsage(command.error());
  const std::vector<CorpusFile> files = makeCorpus();
  std::vector<ReaderCase> cases = readerCases(files, options.without);
  if (auto done = selectCases(cases, options.only, options.skip); !done) {
    fmt::print(stderr, "t4d: {}; `t4d conform list` lists them\n", done.error().text());
    return kUsage;
  }
  leaveNoCoreDumps();
  Result<std::vector<ReaderResult>> results;
  {
    const Interruptible interruptible;
    ProgressBar bar("trying the reader");
    results = runReaderCases(
        cases, {*command, options.seconds, options.parallel, options.first, &interrupted},
        bar.callback());
  }
  if (!results) {
    return results.error().code == ErrorCode::InvalidInput ? wrongUsage(results.error())
                                                           : report(results.error());
  }
  if (interrupted) {
    fmt::print(stderr, "t4d: interrupted\n");
    return kFailed;
  }
  if (!options.junit.empty()) {
    const auto written = writeText(options.junit, reportJunit(options.reader, cases, *results));
    if (!written) return report(written.error());
  }
  if (!options.keep.empty()) {
    const auto kept = keepWrongFiles(cases, *results, options.keep);
    if (!kept) return report(kept.error());
    if (*kept > 0) fmt::print(stderr, "t4d: {} files are in {}\n", *kept, options.keep);
  }
  if (options.json) {
    printJson(reportJson(options.reader, cases, *results));
  } else {
    constexpr std::size_t kShown = 20;
    fmt::print(
        "{}", reportText(options.reader, cases, *results, options.verbose ? cases.size() : kShown));
  }
  const OutcomeCounts counts = countsOf(*results);
  const auto count = [&](Outcome outcome) { return counts[static_cast<std::size_t>(outcome)]; };
  const bool right =
      count(Outcome::Failed) + count(Outcome::Crashed) + count(Outcome::TimedOut) == 0;
  return right ? kDone : kFailed;
}

}  // namespace

void addConformReader(CLI::App& conform, int& exitCode) {
  auto* command = conform.add_subcommand(
      "reader", "Put any program that reads .t4d to the corpus and to damage made on the spot");
  auto options = std::make_shared<Options>();
  command
      ->add_option("--reader", options->reader,
                   "The program, called as READER FILE describe and READER FILE slice T; it may "
                   "have arguments: 'python3 my_reader.py'")
      ->required()
      ->type_name("READER");
  command->add_option("--only", options->only, "Only these cases: globs or folders ('cut')")
      ->type_name("GLOB");
  command->add_option("--skip", options->skip, "Leave these cases out")->type_name("GLOB");
  command
      ->add_option("--without", options->without,
                   "A feature that the reader does not know: it must refuse files that name it")
      ->check(CLI::IsMember({"zstd", "means"}))
      ->type_name("FEATURE");
  command
      ->add_option("--parallel", options->parallel, "Starts at a time (default: one a processor)")
      ->check(CLI::Range(1U, 1024U))
      ->type_name("N");
  command->add_option("--timeout", options->seconds, "Seconds that a start may take (default: 10)")
      ->check(CLI::Range(0.01, 86400.0))
      ->type_name("SECONDS");
  command->add_option("--junit", options->junit, "Write the results as JUnit's XML")
      ->type_name("FILE");
  command->add_option("--keep", options->keep, "Leave the files of cases that are not right here")
      ->type_name("DIR");
  command->add_flag("--first", options->first, "End at the first start that is not right");
  command->add_flag("--verbose", options->verbose, "Say all cases that are not right");
  command->add_flag("--json", options->json, "Print JSON");
  command->footer(
      "Exits with 0 where all cases have passed, with 1 where one has not.\n"
      "Examples:\n"
      "  t4d conform reader --reader ./my-reader\n"
      "  t4d conform reader --reader 'python3 my_reader.py' --without zstd --only valid");
  command->callback([=, &exitCode] { exitCode = run(*options); });
}

}  // namespace t4d::tools
