#include "conformance/driver/case_choice.h"

#include <string_view>

#include <fmt/format.h>
#include <fnmatch.h>

namespace t4d::conformance {
namespace {

/// A pattern is a glob for the id or its last part, or a folder.
bool matches(const std::string& id, const std::string& pattern) {
  const std::string name = id.substr(id.find('/') + 1);
  return fnmatch(pattern.c_str(), id.c_str(), 0) == 0 ||
         fnmatch(pattern.c_str(), name.c_str(), 0) == 0 || id.starts_with(pattern + "/");
}

/// Removes the "/" or ".t4d" that shell completion adds.
std::string withoutEnding(std::string pattern) {
  for (const std::string_view ending : {"/", ".t4d"}) {
    if (pattern.ends_with(ending)) pattern.resize(pattern.size() - ending.size());
  }
  return pattern;
}

/// Which cases match at least one pattern; a pattern that matches no case is an error.
Result<std::vector<bool>> matching(const std::vector<std::string>& ids,
                                   const std::vector<std::string>& patterns) {
  std::vector<bool> matched(ids.size());
  for (const std::string& pattern : patterns) {
    bool any = false;
    for (std::size_t i = 0; i < ids.size(); ++i) {
      if (!matches(ids[i], withoutEnding(pattern))) continue;
      any = matched[i] = true;
    }
    if (!any) return invalid(fmt::format("no case is called {}", pattern));
  }
  return matched;
}

}  // namespace

Result<std::vector<Choice>> chooseCases(const std::vector<std::string>& ids,
                                        const std::vector<std::string>& only,
                                        const std::vector<std::string>& skip) {
  const auto skipped = matching(ids, skip);
  if (!skipped) return skipped.error();
  const auto kept = matching(ids, only);
  if (!kept) return kept.error();
  std::vector<Choice> choices;
  for (std::size_t i = 0; i < ids.size(); ++i) {
    const bool dropped = !only.empty() && !(*kept)[i];
    choices.push_back(dropped ? Choice::Dropped : (*skipped)[i] ? Choice::Skipped : Choice::Run);
  }
  return choices;
}

}  // namespace t4d::conformance
