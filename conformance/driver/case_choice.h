#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "t4d/error.h"

namespace t4d::conformance {

enum class Choice : std::uint8_t { Run, Skipped, Dropped };

/// Chooses the cases that match one of `only`, unless it is empty, and skips those that match one
/// of `skip`. A pattern is a glob of the id ("invalid/H*", where * also matches /) or of the name
/// in it ("one-simplex"), or a folder ("cut"). Fails if a pattern matches nothing.
Result<std::vector<Choice>> chooseCases(const std::vector<std::string>& ids,
                                        const std::vector<std::string>& only,
                                        const std::vector<std::string>& skip);

/// Keeps the chosen cases. `Case` has an `id`, and a `skipped`, which is set to the reason if the
/// case is not run. Fails if chooseCases does, and if no case is left.
template <class Case>
Result<void> selectCases(std::vector<Case>& cases, const std::vector<std::string>& only,
                         const std::vector<std::string>& skip) {
  std::vector<std::string> ids;
  for (const Case& test : cases) ids.push_back(test.id);
  const auto choices = chooseCases(ids, only, skip);
  if (!choices) return choices.error();
  std::vector<Case> chosen;
  bool any = false;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    if ((*choices)[i] == Choice::Dropped) continue;
    if ((*choices)[i] == Choice::Skipped) cases[i].skipped = "named by --skip";
    any = any || cases[i].skipped.empty();
    chosen.push_back(std::move(cases[i]));
  }
  if (!any) return invalid("no case is left: all are skipped");
  cases = std::move(chosen);
  return {};
}

}  // namespace t4d::conformance
