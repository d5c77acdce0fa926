#include "conformance/driver/reader_suite.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <mutex>
#include <optional>
#include <thread>

#include <fmt/format.h>

#include "conformance/driver/served_reader.h"
#include "formats/output_folder.h"
#include "model/progress.h"
#include "platform/temporary_folder.h"

namespace t4d::conformance {
namespace {

namespace fs = std::filesystem;

/// Limits on timeouts: a reader that hangs costs ten times SuiteOptions::timeoutSeconds each time.
constexpr int kSlowTrialsOfCase = 2;
constexpr int kSlowTrials = 20;
/// Maximum number of wrong trials that are named per case, and whose files are kept.
constexpr std::size_t kNamed = 4;

Result<void> write(const fs::path& path, const std::string& bytes) {
  std::ofstream file(path, std::ios::binary);
  file << bytes;
  file.close();
  if (!file) {
    return fail(ErrorCode::Failed, fmt::format("cannot write: {}", std::strerror(errno)),
                path.string());
  }
  return {};
}

/// "slice 0.5" of "slice 0.5 with CONN at byte 88 destroyed".
std::string shortly(const Trial& trial) {
  return trial.about.substr(0, trial.about.find(" with "));
}

/// The results of the trials of one case; empty for trials that were not run.
using TrialResults = std::vector<std::optional<TrialResult>>;

/// Runs the trials of all cases. Threads take them from one queue, in order.
class SuiteRun {
 public:
  SuiteRun(const std::vector<ReaderCase>& cases, const SuiteOptions& options,
           const fs::path& folder, const model::Progress& progress)
      : cases_(cases),
        options_(options),
        folder_(folder),
        progress_(progress),
        results_(cases.size()),
        slow_(cases.size()) {
    for (std::size_t i = 0; i < cases.size(); ++i) {
      results_[i].resize(cases[i].trials.size());
      if (!cases[i].skipped.empty()) continue;
      for (std::size_t j = 0; j < cases[i].trials.size(); ++j) queue_.emplace_back(i, j);
    }
  }

  Result<void> run() {
    std::vector<std::thread> threads;
    for (unsigned i = 0; i < std::max(1U, options_.parallel); ++i) {
      threads.emplace_back([this, i] { work(folder_ / fmt::format("{}.t4d", i)); });
    }
    for (std::thread& thread : threads) thread.join();
    if (error_) return *error_;
    return {};
  }

  const std::vector<TrialResults>& results() const { return results_; }

 private:
  void work(const fs::path& path) {
    ServedReader served(options_.command, options_.timeoutSeconds, options_.stop);
    std::optional<std::pair<std::size_t, std::size_t>> last;
    // Whatever a serving reader does after its answer is attributed to that request.
    const auto blameLast = [&] {
      const auto fault = last ? served.lateFault() : std::nullopt;
      if (!fault) return;
      const auto [i, j] = *last;
      if (results_[i][j]->outcome == Outcome::Passed) {
        *results_[i][j] = {Outcome::Crashed, *fault, results_[i][j]->seconds};
      }
      if (options_.first) found_ = true;
    };
    while (!failed_ && !found_ && !(options_.stop != nullptr && *options_.stop)) {
      const std::size_t next = next_++;
      if (next >= queue_.size()) break;
      const auto [i, j] = queue_[next];
      if (slow_[i] >= kSlowTrialsOfCase || allSlow_ >= kSlowTrials) continue;
      blameLast();
      auto result = tried(*cases_[i].file, cases_[i].trials[j], path, served);
      if (!result) {
        const std::lock_guard lock(mutex_);
        error_ = result.error();
        failed_ = true;
        return;
      }
      const Outcome outcome = result->outcome;
      if (outcome == Outcome::TimedOut) {
        ++slow_[i];
        ++allSlow_;
      }
      if (outcome != Outcome::Passed && options_.first) found_ = true;
      if (outcome != Outcome::Skipped) {
        results_[i][j] = std::move(*result);
        last = {i, j};
      }
      if (progress_ && mutex_.try_lock()) {
        if (auto on = model::report(progress_, next, queue_.size()); !on) {
          error_ = on.error();
          failed_ = true;
        }
        mutex_.unlock();
      }
    }
    blameLast();
  }

  Result<TrialResult> tried(const CorpusFile& file, const Trial& trial, const fs::path& path,
                            ServedReader& served) const {
    const auto written = write(path, damaged(file.bytes, trial.damage));
    if (!written) return written.error();
    const auto evaluated = [&](const Reply& reply) {
      return evaluate(trial, reply, path.string(), options_.timeoutSeconds);
    };
    if (!options_.serve) {
      std::vector<std::string> words = options_.command;
      words.push_back(path.string());
      words.insert(words.end(), trial.request.begin(), trial.request.end());
      auto run = platform::runProgram(
          words, {.limit = platform::TimeLimit::ofProcessor(options_.timeoutSeconds),
                  .stop = options_.stop});
      if (!run) return run.error();
      return evaluated(replyOf(std::move(*run)));
    }
    const bool fresh = !served.hasAnswered();
    const auto reply = served.ask(trial.request, path.string());
    if (!reply) return reply.error();
    TrialResult result = evaluated(*reply);
    if (result.outcome != Outcome::Failed && result.outcome != Outcome::Crashed) return result;
    served.restart();
    if (fresh) return result;
    const auto again = served.ask(trial.request, path.string());
    if (!again) return again.error();
    const TrialResult alone = evaluated(*again);
    if (alone.outcome == Outcome::Skipped) return alone;
    if (alone.outcome == Outcome::Passed) {
      result.message += "; a fresh process gets it right: an earlier request has left something";
      return result;
    }
    served.restart();
    return alone;
  }

  const std::vector<ReaderCase>& cases_;
  const SuiteOptions& options_;
  const fs::path& folder_;
  const model::Progress& progress_;
  std::vector<std::pair<std::size_t, std::size_t>> queue_;  // indices of case and trial
  std::vector<TrialResults> results_;
  std::vector<std::atomic<int>> slow_;  // trials of the case
  std::atomic<int> allSlow_ = 0;
  std::atomic<std::size_t> next_ = 0;
  std::atomic<bool> failed_ = false;  // error_ is set
  std::atomic<bool> found_ = false;   // options_.first, and a trial was wrong
  std::mutex mutex_;                  // guards error_ and progress_
  std::optional<Error> error_;
};

ReaderResult resultOf(const ReaderCase& test, const TrialResults& trials) {
  ReaderResult result;
  if (!test.skipped.empty()) {
    result.outcome = Outcome::Skipped;
    result.message = test.skipped;
    return result;
  }
  std::size_t notRun = 0;
  for (std::size_t i = 0; i < trials.size(); ++i) {
    notRun += trials[i] ? 0 : 1;
    if (!trials[i]) continue;
    result.seconds += trials[i]->seconds;
    if (trials[i]->outcome != Outcome::Passed) result.wrong.push_back(i);
  }
  if (result.wrong.empty()) {
    if (notRun == 0) return result;
    result.outcome = Outcome::Skipped;
    result.message = "not run: the run ended before, or too many requests timed out";
    return result;
  }
  std::stable_sort(result.wrong.begin(), result.wrong.end(), [&](std::size_t a, std::size_t b) {
    return trials[a]->outcome > trials[b]->outcome;
  });
  const TrialResult& worst = *trials[result.wrong[0]];
  result.outcome = worst.outcome;
  result.message = fmt::format("{}: {}", test.trials[result.wrong[0]].about, worst.message);
  for (std::size_t i = 1; i < std::min(result.wrong.size(), kNamed); ++i) {
    result.message += fmt::format("{}{}", i == 1 ? "; also wrong: " : ", ",
                                  shortly(test.trials[result.wrong[i]]));
  }
  if (result.wrong.size() > kNamed) {
    result.message += fmt::format(" and {} more", result.wrong.size() - kNamed);
  }
  if (trials.size() > 1) {
    result.message += fmt::format(" ({} of {} wrong", result.wrong.size(), trials.size());
    result.message += notRun > 0 ? fmt::format(", {} not run)", notRun) : ")";
  }
  return result;
}

}  // namespace

Result<std::vector<ReaderResult>> runReaderCases(const std::vector<ReaderCase>& cases,
                                                 const SuiteOptions& options,
                                                 const model::Progress& progress) {
  const auto folder = platform::TemporaryFolder::create();
  if (!folder) return folder.error();
  SuiteRun run(cases, options, folder->path(), progress);
  if (auto done = run.run(); !done) return done.error();
  std::vector<ReaderResult> results;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    results.push_back(resultOf(cases[i], run.results()[i]));
  }
  return results;
}

fs::path keptFile(const ReaderCase& test, const Trial& trial) {
  if (isNone(trial.damage)) return test.id + ".t4d";
  std::string name = shortly(trial);
  std::replace(name.begin(), name.end(), ' ', '-');
  return fs::path(test.id) / (name + ".t4d");
}

Result<std::size_t> keepWrongFiles(const std::vector<ReaderCase>& cases,
                                   const std::vector<ReaderResult>& results,
                                   const fs::path& directory) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const std::string& bytes = cases[i].file->bytes;
    const std::vector<std::size_t>& wrong = results[i].wrong;
    for (std::size_t j = 0; j < std::min(wrong.size(), kNamed); ++j) {
      const Trial& trial = cases[i].trials[wrong[j]];
      const auto written = formats::writeInFolder(directory, keptFile(cases[i], trial).string(),
                                                  damaged(bytes, trial.damage));
      if (!written) return written.error();
      kept += isNone(trial.damage) && j > 0 ? 0 : 1;
    }
  }
  return kept;
}

}  // namespace t4d::conformance
