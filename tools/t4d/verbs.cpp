#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "tools/t4d/commands.h"
#include "tools/t4d/common_options.h"
#include "tools/t4d/similar_words.h"

namespace t4d::tools {
void addVerbs(CLI::App& app, int& exitCode) {
#define T4D_VERB(Name) add##Name(app, exitCode);
#include "tools/t4d/verbs.inc"
#undef T4D_VERB
  for (CLI::App* verb : app.get_subcommands(nullptr)) addCommonOptions(*verb);
}

std::string wrongVerb(const CLI::App& command, const std::string& word) {
  std::vector<std::string> verbs;
  for (const CLI::App* verb : command.get_subcommands(nullptr)) verbs.push_back(verb->get_name());
  const std::string list =
      fmt::format("the verbs of {} are {}",
                  command.get_parent() == nullptr ? "t4d" : "t4d " + command.get_name(),
                  fmt::join(verbs, ", "));
  if (word.empty()) return "a verb is missing; " + list;
  return fmt::format("unknown verb '{}'{}; {}", word, didYouMean(word, verbs), list);
}

}  // namespace t4d::tools
