#include "tools/t4d/part_option.h"

#include <algorithm>
#include <array>
#include <filesystem>

#include <fmt/format.h>

#include "tools/t4d/console.h"
#include "tools/t4d/json_text.h"
#include "tools/t4d/option_checks.h"
#include "tools/t4d/part_report.h"
#include "tools/t4d/version.h"

namespace t4d::tools {
namespace {

using nlohmann::ordered_json;

/// Options that may differ from part to part of the same run.
bool mayDiffer(const std::string& name) {
  constexpr std::array kNames = {"--help",   "--part",   "--most-parts", "--json",
                                 "--output", "--visits", "--dwell",      "--first",
                                 "--last",   "--quiet",  "--threads",    "--max-cells"};
  return std::ranges::find(kNames, name) != kNames.end();
}

/// Adds what the command line says, but for the places of files: those can differ between machines.
void addWords(const CLI::App& command, ordered_json& words) {
  for (const CLI::Option* option : command.get_options()) {
    const std::string name = option->get_single_name();
    const std::string shown = option->get_positional() ? name : "--" + name;
    if (option->count() == 0 || mayDiffer(shown)) continue;
    auto values = ordered_json::array();
    for (const std::string& value : option->results()) {
      std::error_code ignored;
      const std::filesystem::path path(value);
      const bool isFile = std::filesystem::exists(path, ignored);
      values.push_back(isFile && path.has_filename() ? path.filename().string() : value);
    }
    words[shown] = std::move(values);
  }
  const auto all = [](const CLI::App*) { return true; };
  for (const CLI::App* group : command.get_subcommands(all)) addWords(*group, words);
}

}  // namespace

void PartOption::addTo(CLI::App& command, const std::string& help) {
  command_ = &command;
  addPartOption(command, part_, help);
  command.add_flag("--most-parts", most_, "Print the largest N of --part, and stop");
}

std::optional<int> PartOption::settle(std::uint64_t most, std::string_view things) const {
  if (most_) {
    printJson({{"parts", most}});
    return kDone;
  }
  if (chosen().count <= most) return std::nullopt;
  return wrongUsage(fmt::format("--part: there are {} {}, too few for {} parts", grouped(most),
                                things, grouped(chosen().count)));
}

ordered_json PartOption::reportOf(ordered_json report, ordered_json input,
                                  ordered_json state) const {
  auto words = ordered_json::object();
  addWords(*command_, words);
  ordered_json part = {{"verb", command_->get_name()},
                       {"version", versionText()},
                       {"number", chosen().number},
                       {"count", chosen().count},
                       {"options", std::move(words)}};
  if (!input.is_null()) part["input"] = std::move(input);
  if (!state.is_null()) part["state"] = std::move(state);
  report["part"] = std::move(part);
  addChecksums(report);
  return report;
}

std::string PartOption::inReport(ordered_json report, const std::function<ordered_json()>& input,
                                 ordered_json state) const {
  if (isGiven()) report = reportOf(std::move(report), input(), std::move(state));
  return jsonText(report);
}

void addNoPartOption(CLI::App& command, const std::string& why) {
  const auto refuse = [why](const std::string&) { throw CLI::ValidationError("--part", why); };
  command.add_option_function<std::string>("--part", refuse, why)->group("");
}

}  // namespace t4d::tools
