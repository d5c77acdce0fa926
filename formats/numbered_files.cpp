#include "formats/numbered_files.h"

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "model/number.h"

namespace t4d::formats {
namespace {

/// A path before and behind its number.
struct Numbered {
  std::filesystem::path path;
  std::string before;
  std::uint64_t number = 0;
  std::string behind;
};

std::optional<Numbered> numbered(const std::filesystem::path& path) {
  const std::string folder = path.parent_path().string();
  const std::string stem = path.stem().string();
  constexpr const char* kDigits = "0123456789";
  const auto last = stem.find_last_of(kDigits);
  if (last == stem.npos) return std::nullopt;
  const auto before = stem.find_last_not_of(kDigits, last);
  const std::size_t first = before == stem.npos ? 0 : before + 1;
  Numbered found{path, folder + "/" + stem.substr(0, first), 0,
                 stem.substr(last + 1) + path.extension().string()};
  const auto number =
      model::numberIn<std::uint64_t>(std::string_view(stem).substr(first, last + 1 - first));
  if (!number) return std::nullopt;
  found.number = *number;
  return found;
}

}  // namespace

Result<void> checkNumbers(std::span<const std::filesystem::path> files) {
  std::vector<Numbered> series;
  for (const auto& file : files) {
    auto found = numbered(file);
    const bool alike = found && (series.empty() || (found->before == series.front().before &&
                                                    found->behind == series.front().behind));
    if (!alike) return {};
    series.push_back(std::move(*found));
  }
  if (!std::ranges::is_sorted(series, {}, &Numbered::number)) return {};
  for (std::size_t i = 1; i < series.size(); ++i) {
    const Numbered& next = series[i];
    if (next.number == series[i - 1].number + 1) continue;
    const std::string before = series[i - 1].path.filename().string();
    if (next.number == series[i - 1].number) {
      return invalid(fmt::format("has the same number as {}", before), next.path.string());
    }
    return invalid(fmt::format("follows {}: number {} is missing; name all files of the series, or "
                               "give them numbers without gaps",
                               before, series[i - 1].number + 1),
                   next.path.string());
  }
  return {};
}

}  // namespace t4d::formats
