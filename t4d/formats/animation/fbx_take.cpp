#include "t4d/formats/animation/fbx_take.h"

#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string_view>
#include <utility>

#include "t4d/formats/input_file.h"

namespace t4d::formats {
namespace {

constexpr double kFbxTicksPerSecond = 46'186'158'000;

/// Widened takes begin here and end as long after 0, in seconds, and later by their number: 12
/// days, which doubles tell from 12 days and a nanosecond. Start `a` is `a` seconds before it,
/// stop `b` so many times kFbxStride after it, so that a duration tells both.
constexpr std::int64_t kFbxWide = std::int64_t{1} << 20;
constexpr std::int64_t kFbxStride = 1024;

/// The number that a property has, behind its name: where it is, how long it is, what it is.
struct FbxNumber {
  std::size_t at = 0;
  std::size_t size = 0;
  std::int64_t ticks = 0;
};

/// `P: "LocalStart", "KTime", "Time", "",46186158000`, from the name's closing quote on.
std::optional<FbxNumber> fbxNumberInText(std::string_view text, std::size_t at) {
  constexpr std::size_t kLongest = 100;
  const std::string_view rest = text.substr(at, kLongest);
  std::size_t comma = 0;
  for (int i = 0; i < 4; ++i) {
    comma = rest.find(',', comma);
    if (comma == rest.npos) return std::nullopt;
    ++comma;
  }
  const std::size_t begin = rest.find_first_not_of(" \t", comma);
  if (begin == rest.npos) return std::nullopt;
  FbxNumber found{at + begin, 0, 0};
  const auto [stop, problem] =
      std::from_chars(rest.data() + begin, rest.data() + rest.size(), found.ticks);
  if (problem != std::errc{}) return std::nullopt;
  found.size = static_cast<std::size_t>(stop - (rest.data() + begin));
  return found;
}

/// Three strings, each S, a length and its bytes, and L with 8 bytes.
std::optional<FbxNumber> fbxNumberInBinary(std::string_view bytes, std::size_t at) {
  for (int i = 0; i < 3; ++i) {
    if (bytes.size() < at + 5 || bytes[at] != 'S') return std::nullopt;
    at += 5 + std::size_t{loadNumber<std::uint32_t>(bytes.data() + at + 1)};
  }
  if (at > bytes.size() || bytes.size() - at < 9 || bytes[at] != 'L') return std::nullopt;
  return FbxNumber{at + 1, 8, loadNumber<std::int64_t>(bytes.data() + at + 1)};
}

/// Writes other ticks in place of a number. Returns by how much the bytes have become longer.
std::ptrdiff_t replaceFbxNumber(std::string& bytes, const FbxNumber& found, std::int64_t seconds,
                                bool isBinary) {
  const std::int64_t ticks = seconds * static_cast<std::int64_t>(kFbxTicksPerSecond);
  std::string text(sizeof ticks, '\0');
  if (isBinary) {
    std::memcpy(text.data(), &ticks, sizeof ticks);  // little-endian, as this machine is
  } else {
    text = std::to_string(ticks);
  }
  bytes.replace(found.at, found.size, text);
  return static_cast<std::ptrdiff_t>(text.size()) - static_cast<std::ptrdiff_t>(found.size);
}

}  // namespace

FbxTakes FbxTakes::widen(std::string& bytes) {
  const bool isBinary = bytes.starts_with("Kaydara FBX Binary");
  const auto secondsOf = [](const FbxNumber& found) {
    return static_cast<double>(found.ticks) / kFbxTicksPerSecond;
  };
  FbxTakes takes;
  std::optional<FbxNumber> start;
  for (std::size_t at = 0; (at = bytes.find("LocalSt", at)) != bytes.npos;) {
    const std::string_view rest = std::string_view(bytes).substr(at);
    const bool isStart = rest.starts_with("LocalStart");
    const bool isStop = rest.starts_with("LocalStop");
    at += isStart ? 10 : 9;
    if ((!isStart && !isStop) || at > bytes.size()) continue;
    const auto found = isBinary ? fbxNumberInBinary(bytes, at) : fbxNumberInText(bytes, at);
    // It is widened with the stop that follows: without one it would end at 0.
    if (isStart) start = found;
    if (!isStop || !found || takes.stops_.size() == kFbxStride) continue;
    const auto stopNumber = static_cast<std::int64_t>(takes.stops_.size());
    takes.stops_.push_back(secondsOf(*found));
    auto longer = replaceFbxNumber(bytes, *found, kFbxWide + kFbxStride * stopNumber, isBinary);
    if (start) {
      const auto startNumber = static_cast<std::int64_t>(takes.starts_.size());
      takes.starts_.push_back(secondsOf(*start));
      longer += replaceFbxNumber(bytes, *start, -kFbxWide - startNumber, isBinary);
      start.reset();
    }
    at = static_cast<std::size_t>(static_cast<std::ptrdiff_t>(at) + longer);
  }
  return takes;
}

FbxTakes::Take FbxTakes::takeOf(double duration) const {
  const auto within = [](double number, std::size_t count) {
    return number >= 0 && number < static_cast<double>(count);
  };
  // Both are widened, or the stop alone, since a start of 0 may be missing.
  for (const bool both : {true, false}) {
    const double rest = std::round(duration) - static_cast<double>(both ? 2 * kFbxWide : kFbxWide);
    const double stop = std::floor(rest / kFbxStride);
    const double start = rest - stop * kFbxStride;
    if (!within(stop, stops_.size()) || !within(start, both ? starts_.size() : 1)) continue;
    const double from = both ? starts_[static_cast<std::size_t>(start)] : 0;
    const double to = stops_[static_cast<std::size_t>(stop)];
    Take take;
    if (both) take.offset = -static_cast<double>(kFbxWide) - start;
    if (from < to) take.span = {from, to};
    return take;
  }
  return {};
}

}  // namespace t4d::formats
