#include "tools/t4d/frame_order.h"

#include <algorithm>
#include <cctype>

#include <fmt/format.h>

#include "formats/t4d/url.h"
#include "tools/t4d/weave_input.h"
#include "voxel4d/natural_order.h"

namespace t4d::tools {
namespace {

/// A name with '0' for each run of digits.
std::string withoutNumbers(const std::string& name) {
  std::string text;
  for (const char c : name) {
    const bool digit = std::isdigit(static_cast<unsigned char>(c)) != 0;
    if (!digit) text += c;
    if (digit && !text.ends_with('0')) text += '0';
  }
  return text;
}

}  // namespace

std::string orderFrames(std::vector<std::string>& files) {
  const bool byNumbers = std::ranges::is_sorted(files, voxel4d::naturallyLess);
  if (files.size() < 2 || byNumbers) return {};
  const std::string form = withoutNumbers(files.front());
  const bool alike = std::ranges::all_of(
      files, [&](const std::string& file) { return withoutNumbers(file) == form; });
  if (!alike) return {};
  const auto shown = [](const std::string& file) { return formats::shownName(file); };
  constexpr std::size_t kLeastOfPattern = 3;
  if (std::ranges::is_sorted(files) && files.size() >= kLeastOfPattern) {
    std::ranges::stable_sort(files, voxel4d::naturallyLess);
    return orderNotice(shown(files.front()), shown(files.back()));
  }
  return fmt::format(
      "frames are in the order given, from {} to {}, which is not that of the numbers in their "
      "names",
      shown(files.front()), shown(files.back()));
}

}  // namespace t4d::tools
