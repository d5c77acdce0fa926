#include "tools/t4d/similar_words.h"

#include <algorithm>
#include <cctype>
#include <numeric>
#include <vector>

#include <fmt/format.h>

namespace t4d::tools {
namespace {

bool sameLetter(char a, char b) {
  return std::tolower(static_cast<unsigned char>(a)) == std::tolower(static_cast<unsigned char>(b));
}

/// Levenshtein distance: the number of insertions, deletions and replacements from one word to the
/// other. Upper and lower case are the same.
std::size_t editDistance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i + 1;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t replaced = diagonal + (sameLetter(a[i], b[j]) ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replaced, diagonal + 1, row[j] + 1});
    }
  }
  return row.back();
}

}  // namespace

std::string didYouMean(std::string_view word, std::span<const std::string> words) {
  constexpr std::size_t kLongest = 100;  // the work is the product of the lengths
  if (words.empty() || word.size() > kLongest) return {};
  const auto distance = [&](const std::string& other) {
    return other.size() > kLongest ? kLongest : editDistance(word, other);
  };
  const auto nearest = std::ranges::min_element(words, {}, distance);
  constexpr std::size_t kTypos = 2;
  if (distance(*nearest) > std::min(kTypos, nearest->size() / 2)) return {};
  return fmt::format(" (did you mean {}?)", *nearest);
}

}  // namespace t4d::tools
