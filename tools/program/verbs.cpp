#include <algorithm>
#include <numeric>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "tools/program/commands.h"

namespace t4d::tools {
namespace {

/// Levenshtein distance: the number of insertions, deletions and replacements from one word to the
/// other.
std::size_t editDistance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i + 1;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replaced, diagonal + 1, row[j] + 1});
    }
  }
  return row.back();
}

}  // namespace

void addVerbs(CLI::App& app, int& exitCode) {
#define T4D_VERB(Name) add##Name(app, exitCode);
#include "tools/program/verbs.inc"
#undef T4D_VERB
}

std::string wrongVerb(const CLI::App& command, const std::string& word) {
  std::vector<std::string> verbs;
  for (const CLI::App* verb : command.get_subcommands(nullptr)) verbs.push_back(verb->get_name());
  const std::string list =
      fmt::format("the verbs of {} are {}",
                  command.get_parent() == nullptr ? "t4d" : "t4d " + command.get_name(),
                  fmt::join(verbs, ", "));
  if (word.empty()) return "a verb is missing; " + list;
  const auto distance = [&](const std::string& verb) { return editDistance(word, verb); };
  const auto nearest = std::ranges::min_element(verbs, {}, distance);
  constexpr std::size_t kTypos = 2;
  const bool near = distance(*nearest) <= std::min(kTypos, nearest->size() / 2);
  return fmt::format("unknown verb '{}'{}; {}", word,
                     near ? fmt::format(" (did you mean {}?)", *nearest) : "", list);
}

}  // namespace t4d::tools
