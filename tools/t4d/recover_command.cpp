#include <algorithm>

#include <fmt/format.h>

#include "tools/t4d/commands.h"
#include "tools/t4d/console.h"
#include "tools/t4d/json_option.h"
#include "tools/t4d/option_checks.h"
#include "tools/t4d/version.h"
#include "tools/verbs/recover.h"

namespace t4d::tools {
namespace {

/// Maximum number of lines printed of each kind; the JSON output has all.
constexpr std::size_t kLines = 20;

void printText(const std::string& output, const verbs::RecoverReport& report) {
  const std::uint64_t of = report.slabsKnown.value_or(report.slabsSaved);
  print("{}: {}{} slab{} saved\n", output, grouped(report.slabsSaved),
        report.slabsKnown ? " of " + grouped(of) : "", of == 1 ? "" : "s");
  for (std::size_t i = 0; i < std::min(kLines, report.closed.size()); ++i) {
    const auto& [body, end] = report.closed[i];
    print("  closed '{}' where it {} at time {}: a cap over {} triangles\n", body,
          end.begin ? "begins" : "ends", end.time, grouped(end.triangles));
  }
  if (report.closed.size() > kLines) {
    print("  and {} more caps\n", grouped(report.closed.size() - kLines));
  }
  const verbs::Validation& validation = *report.validation;
  print("  {}", validation.valid() ? "valid" : "INVALID");
  if (validation.mesh) {
    print(": closed {}, oriented {}; hypervolume {:.12g}", validation.mesh->closed ? "yes" : "NO",
          validation.mesh->oriented ? "yes" : "NO", validation.mesh->hypervolume);
  }
  print("\n");
  for (const measure::Issue& issue : validation.issues.issues) {
    if (issue.severity == measure::Severity::Error) print("  error: {}\n", issue.message);
  }
}

/// One line per loss; consecutive slabs lost for the same reason share one.
std::vector<std::string> linesOf(const std::vector<formats::T4dLoss>& lost) {
  std::vector<std::string> lines;
  for (auto first = lost.begin(); first != lost.end();) {
    const auto end = std::find_if(first, lost.end(), [&](const formats::T4dLoss& loss) {
      return loss.what != first->what || !loss.time;
    });
    const auto last = end == first ? first : end - 1;
    std::string line = fmt::format("byte {}", first->offset);
    if (last != first) line += fmt::format(" to {}, {} times", last->offset, end - first);
    line += ": " + first->what;
    if (first->time) line += fmt::format(" (time {} to {})", first->time->begin, last->time->end);
    lines.push_back(std::move(line));
    first = last + 1;
  }
  return lines;
}

void printLosses(const std::vector<formats::T4dLoss>& lost) {
  std::vector<std::string> lines = linesOf(lost);
  if (lines.size() > kLines) {
    const std::size_t more = lines.size() - kLines;
    lines.resize(kLines);
    lines.push_back(fmt::format("and {} more; --json lists all", grouped(more)));
  }
  reportLosses(lines);
}

int run(const std::string& input, const std::string& output, bool json) {
  Result<verbs::RecoverReport> recovered;
  {
    ProgressBar bar("recovering");
    recovered =
        verbs::recover(input, output, {.generator = std::string(versionText())}, bar.callback());
  }
  if (!recovered) return report(recovered.error());
  printLosses(recovered->lost);
  if (json) printAsJson(*recovered);
  if (!recovered->validation) {
    say(input + ": no closed solid could be recovered; nothing was written");
    return kInvalid;
  }
  if (!json) printText(output, *recovered);
  if (!recovered->validation->valid()) return kFailed;
  return recovered->lost.empty() ? kDone : kLoss;
}

}  // namespace

void addRecover(CLI::App& app, int& exitCode) {
  auto* command =
      app.add_subcommand("recover", "Save the undamaged part of a .t4d file as a valid file");
  auto input = std::make_shared<std::string>();
  auto output = std::make_shared<std::string>();
  auto json = std::make_shared<bool>(false);
  command->add_option("FILE", *input, "Damaged .t4d file (not modified)")->required();
  command->add_option("-o,--output", *output, "Output file (.t4d)")
      ->required()
      ->check(someName())
      ->check(outputFile({".t4d"}));
  addJsonOption<verbs::RecoverReport>(
      *command, *json,
      "What was saved from a damaged .t4d file, and what was lost. Also printed if nothing could "
      "be saved (exit code 4) or the new file is not valid (exit code 1).");
  command->footer("Example:\n  t4d recover broken.t4d -o fixed.t4d");
  command->callback([=, &exitCode] { exitCode = run(*input, *output, *json); });
}

}  // namespace t4d::tools
