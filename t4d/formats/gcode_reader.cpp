#include "t4d/formats/gcode_reader.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "t4d/formats/text_scanner.h"

namespace t4d::formats {
namespace {

constexpr double kMillimetresPerInch = 25.4;

/// An arc's start and end may be this far from one circle, in mm or as a part of the radius: the
/// digits of a program are rounded.
constexpr double kArcRounding = 0.01;
constexpr double kArcRoundingPart = 0.001;

/// Words that exclude each other in a line: G words are numbered in tenths.
enum class Group : std::uint8_t { Motion, Plane, Units, Distance, Centres, Origin, Nothing };

struct KnownCode {
  int tenths;
  Group group;
};

constexpr std::array<KnownCode, 33> kGCodes = {{
    {0, Group::Motion},    {10, Group::Motion},    {20, Group::Motion},   {30, Group::Motion},
    {40, Group::Nothing},  {170, Group::Plane},    {180, Group::Plane},   {190, Group::Plane},
    {200, Group::Units},   {210, Group::Units},    {400, Group::Nothing}, {430, Group::Nothing},
    {490, Group::Nothing}, {540, Group::Origin},   {550, Group::Origin},  {560, Group::Origin},
    {570, Group::Origin},  {580, Group::Origin},   {590, Group::Origin},  {591, Group::Origin},
    {592, Group::Origin},  {593, Group::Origin},   {610, Group::Nothing}, {640, Group::Nothing},
    {800, Group::Nothing}, {900, Group::Distance}, {901, Group::Centres}, {910, Group::Distance},
    {911, Group::Centres}, {940, Group::Nothing},  {970, Group::Nothing}, {980, Group::Nothing},
    {990, Group::Nothing},
}};

constexpr std::array<int, 12> kHarmlessM = {0, 1, 3, 4, 5, 6, 7, 8, 9, 48, 49, 60};

/// What a G word is that is not read, and what to do about it.
std::string_view meaningOf(int tenths) {
  switch (tenths) {
    case 50:
    case 51:
    case 52:
      return "a spline; have arcs and lines written";
    case 100:
      return "a setting of offsets; remove it";
    case 280:
    case 300:
    case 530:
      return "a position of the machine, which is not known here; remove the line";
    case 410:
    case 420:
      return "cutter compensation; have the path of the tool's centre written";
    case 510:
    case 680:
      return "a scaled or turned program; have plain coordinates written";
    case 730:
    case 810:
    case 820:
    case 830:
    case 840:
    case 850:
    case 860:
    case 870:
    case 880:
    case 890:
      return "a canned cycle; have its moves written";
    case 920:
      return "a shift of the origin; have plain coordinates written";
    case 930:
      return "inverse time feed; have feed per minute written (G94)";
    case 950:
      return "feed per turn; have feed per minute written (G94)";
    case 960:
      return "a constant cutting speed, which lathes have";
    default:
      return "not among the words that are known";
  }
}

std::string_view meaningOf(char letter) {
  switch (letter) {
    case 'A':
    case 'B':
    case 'C':
      return "a rotary axis; for five axes give cutter locations (GOTO/x,y,z,i,j,k)";
    case 'U':
    case 'V':
    case 'W':
      return "a second linear axis";
    case 'E':
      return "the filament of a 3D printer, or an exponent; have plain decimal numbers written";
    case '#':
    case '[':
    case '=':
      return "a variable or an expression; have plain numbers written";
    default:
      return "not among the words that are known";
  }
}

/// The words of a line.
struct Block {
  std::optional<int> motion;
  std::array<std::optional<double>, 3> to;      // X Y Z
  std::array<std::optional<double>, 3> centre;  // I J K
  std::optional<double> radius;
  std::optional<double> feed;
  std::optional<double> turns;  // P
  std::optional<double> tool;
  bool changesTool = false;
  bool dwells = false;
  bool blends = false;  // G64, with P as its tolerance
  bool ends = false;

  bool moves() const {
    return std::ranges::any_of(to, [](const auto& value) { return value.has_value(); }) ||
           std::ranges::any_of(centre, [](const auto& value) { return value.has_value(); }) ||
           radius.has_value();
  }
};

class GcodeReader {
 public:
  GcodeReader(const InputFile& file, const ToolPathOptions& options)
      : file_(file), options_(options) {}

  Result<ToolPath> read() {
    std::string_view text = file_.bytes;
    if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
    for (line_ = 1; !text.empty() && !ended_; ++line_) {
      const auto end = std::min(text.find_first_of("\r\n"), text.size());
      if (auto done = readLine(text.substr(0, end)); !done) return pass(done.error());
      const bool two = text.substr(end).starts_with("\r\n");
      text.remove_prefix(std::min(end + (two ? 2 : 1), text.size()));
    }
    builder_.path.moves = moves_;
    if (dwells_ > 0) {
      builder_.path.notices.push_back(
          fmt::format("{}: {} no time here (G4)", file_.path.string(),
                      dwells_ == 1 ? "1 dwell takes" : fmt::format("{} dwells take", dwells_)));
    }
    if (optionalLines_ > 0) {
      builder_.path.notices.push_back(
          fmt::format("{}: {} with / (block delete) {} carried out", file_.path.string(),
                      optionalLines_ == 1 ? "1 line" : fmt::format("{} lines", optionalLines_),
                      optionalLines_ == 1 ? "is" : "are"));
    }
    auto path = builder_.finish();
    if (!path && path.error().where.empty()) path.error().where = file_.path.string();
    return path;
  }

 private:
  tl::unexpected<Error> refused(std::string message) const {
    return invalid(std::move(message), file_.atLine(line_));
  }
  tl::unexpected<Error> unsupported(const std::string& word, std::string_view meaning) const {
    return fail(ErrorCode::Unsupported, fmt::format("{} is not supported: it is {}", word, meaning),
                file_.atLine(line_));
  }

  /// The line without comments and blanks, in upper case.
  Result<std::string> wordsOf(std::string_view line) const {
    std::string words;
    bool comment = false;
    for (const char c : line) {
      if (comment) {
        comment = c != ')';
      } else if (c == '(') {
        comment = true;
      } else if (c == ')' && !words.starts_with('%')) {
        return refused("a closing bracket has no opening one: comments cannot be nested");
      } else if (c == ';') {
        break;
      } else if (c != ' ' && c != '\t') {
        words += c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
      }
    }
    if (comment) return refused("a comment has no closing bracket");
    return words;
  }

  Result<void> readLine(std::string_view line) {
    auto words = wordsOf(line);
    if (!words) return pass(words.error());
    std::string_view rest = *words;
    if (rest.starts_with('%')) return {};
    if (rest.starts_with('/')) {
      rest.remove_prefix(1);
      ++optionalLines_;
    }
    Block block;
    std::array<bool, 7> seen{};
    while (!rest.empty()) {
      const char letter = rest[0];
      if (letter < 'A' || letter > 'Z') {
        if (letter == '#' || letter == '[' || letter == '=') {
          return unsupported(std::string(1, letter), meaningOf(letter));
        }
        return refused(fmt::format("found {}, expected a letter", inQuotes(rest)));
      }
      rest.remove_prefix(1);
      double value = 0;
      const std::string_view from = rest;
      if (auto read = readNumber(letter, rest, value); !read) return read;
      const std::string word =
          fmt::format("{}{}", letter, from.substr(0, from.size() - rest.size()));
      if (auto taken = take(letter, value, word, block, seen); !taken) return taken;
    }
    return apply(block);
  }

  Result<void> readNumber(char letter, std::string_view& rest, double& value) const {
    std::string_view digits = rest;
    if (digits.starts_with('+')) digits.remove_prefix(1);
    const auto [stopped, problem] = std::from_chars(digits.data(), digits.data() + digits.size(),
                                                    value, std::chars_format::fixed);
    if (problem != std::errc{} || !std::isfinite(value)) {
      if (!rest.empty() && (rest[0] == '#' || rest[0] == '[')) {
        return unsupported(std::string(1, rest[0]), meaningOf(rest[0]));
      }
      return refused(rest.empty() ? fmt::format("{} stands without a number", letter)
                                  : fmt::format("{} is followed by {}, expected a number", letter,
                                                inQuotes(rest)));
    }
    constexpr double kLargest = 1e9;
    if (std::abs(value) > kLargest) {
      return refused(fmt::format("{} is followed by {:g}, but at most {:g} is possible", letter,
                                 value, kLargest));
    }
    rest = digits.substr(static_cast<std::size_t>(stopped - digits.data()));
    return {};
  }

  Result<void> set(std::optional<double>& into, double value, const std::string& word) const {
    if (into) return refused(fmt::format("{}: this letter comes twice in the line", word));
    into = value;
    return {};
  }

  Result<void> take(char letter, double value, const std::string& word, Block& block,
                    std::array<bool, 7>& seen) {
    switch (letter) {
      case 'G':
        return takeG(value, word, block, seen);
      case 'M':
        return takeM(value, word, block);
      case 'X':
      case 'Y':
      case 'Z':
        return set(block.to[static_cast<std::size_t>(letter - 'X')], value, word);
      case 'I':
      case 'J':
      case 'K':
        return set(block.centre[static_cast<std::size_t>(letter - 'I')], value, word);
      case 'R':
        return set(block.radius, value, word);
      case 'F':
        return set(block.feed, value, word);
      case 'P':
        return set(block.turns, value, word);
      case 'T':
        return set(block.tool, value, word);
      case 'S':
      case 'N':
      case 'O':
      case 'H':
      case 'D':
        return {};
      default:
        return unsupported(word, meaningOf(letter));
    }
  }

  Result<void> takeG(double value, const std::string& word, Block& block,
                     std::array<bool, 7>& seen) {
    const double tenths = 10 * value;
    const bool whole =
        tenths >= 0 && tenths < 10'000 && std::abs(tenths - std::round(tenths)) < 1e-6;
    const int code = whole ? static_cast<int>(std::round(tenths)) : -1;
    const auto known = std::ranges::find(kGCodes, code, &KnownCode::tenths);
    if (known == kGCodes.end()) return unsupported(word, meaningOf(code));
    if (known->group != Group::Nothing) {
      bool& before = seen[static_cast<std::size_t>(known->group)];
      if (before) {
        return refused(
            fmt::format("{}: another word in the line says the same or the opposite", word));
      }
      before = true;
    }
    if (known->group == Group::Origin) origin_ = {code, word, line_};
    switch (code) {
      case 0:
      case 10:
      case 20:
      case 30:
        block.motion = code / 10;
        break;
      case 40:
        block.dwells = true;
        break;
      case 640:
        block.blends = true;
        break;
      case 170:
        plane_ = {0, 1, 2};
        break;
      case 180:
        plane_ = {2, 0, 1};
        break;
      case 190:
        plane_ = {1, 2, 0};
        break;
      case 200:
        unit_ = kMillimetresPerInch;
        break;
      case 210:
        unit_ = 1;
        break;
      case 800:
        motion_.reset();
        break;
      case 900:
      case 910:
        relative_ = code == 910;
        break;
      case 901:
      case 911:
        relativeCentre_ = code == 911;
        break;
      default:
        break;
    }
    return {};
  }

  Result<void> takeM(double value, const std::string& word, Block& block) const {
    if (value == 2 || value == 30) {
      block.ends = true;
      return {};
    }
    if (value == 98 || value == 99) {
      return unsupported(word, "a subprogram; have the moves written one after another");
    }
    if (std::ranges::none_of(kHarmlessM, [&](int code) { return value == code; })) {
      return unsupported(word, "not among the words that are known");
    }
    block.changesTool = block.changesTool || value == 6;
    return {};
  }

  Result<void> apply(const Block& block) {
    if (block.feed) {
      if (!(*block.feed > 0)) return refused(fmt::format("the feed is {}", *block.feed));
      feed_ = *block.feed * unit_;
    }
    if (block.tool) tool_ = block.tool;
    if (block.changesTool) {
      if (cuts_ && tool_ != mounted_) {
        return fail(ErrorCode::Unsupported,
                    fmt::format("a second tool is mounted (T{}), but one tool mills at a time; "
                                "divide the program, and mill the parts one after another",
                                tool_.value_or(0)),
                    file_.atLine(line_));
      }
      mounted_ = tool_;
    }
    if (block.motion) motion_ = block.motion;
    const bool isArc = block.moves() && motion_ && *motion_ >= 2;
    if (block.turns && !block.dwells && !block.blends && !isArc) {
      return refused(fmt::format("P{} stands without G2, G3, G4 or G64", *block.turns));
    }
    if (block.dwells) {
      ++dwells_;
      if (block.moves()) return refused("G4 (a dwell) stands with coordinates or with R");
    } else if (block.moves()) {
      if (!motion_) return refused("coordinates without G0, G1, G2 or G3 before them");
      if (auto moved = move(block); !moved) return moved;
    }
    ended_ = block.ends;
    return {};
  }

  /// A coordinate system of the workpiece, and the line that chose it.
  struct Origin {
    int code = 540;
    std::string word = "G54";
    std::uint64_t line = 0;
  };

  Result<void> move(const Block& block) {
    const int motion = *motion_;
    model::Point3 to = at_;
    std::array<bool, 3> known = known_;
    for (int axis = 0; axis < 3; ++axis) {
      const auto& given = block.to[static_cast<std::size_t>(axis)];
      if (!given) continue;
      if (relative_ && !known_[static_cast<std::size_t>(axis)]) {
        return refused(
            fmt::format("{} is relative (G91) before a position has been given", "XYZ"[axis]));
      }
      to[axis] = (relative_ ? at_[axis] : 0) + *given * unit_;
      known[static_cast<std::size_t>(axis)] = true;
    }
    const bool all = known[0] && known[1] && known[2];
    if (motion != 0 && !builder_.started()) {
      return refused(
          "a cutting move comes before X, Y and Z have been given; begin with G0 and all three");
    }
    if (motion != 0 && !(feed_ > 0)) return refused("a cutting move has no feed; give F before");
    const bool hasCentre = block.centre != Block{}.centre;
    if (motion < 2 && (hasCentre || block.radius)) {
      return refused("I, J, K and R are for arcs (G2 and G3)");
    }
    if (moves_ == 0) {
      firstOrigin_ = origin_;
    } else if (origin_.code != firstOrigin_.code) {
      line_ = origin_.line;
      return unsupported(origin_.word,
                         fmt::format("a second origin, after {}; have plain coordinates written",
                                     firstOrigin_.word));
    }
    ++moves_;
    cuts_ = cuts_ || motion != 0;
    known_ = known;
    if (!builder_.started()) {
      at_ = to;
      if (all) builder_.start(to);
      return {};
    }
    if (motion >= 2) return arc(block, to, motion == 2);
    const double feed = motion == 0 ? options_.rapidFeed : feed_;
    return straight(to, 60 * (to - at_).norm() / feed, motion == 0);
  }

  Result<void> straight(const model::Point3& to, double seconds, bool rapid) {
    auto moved = builder_.moveTo(to, seconds, rapid);
    if (!moved) {
      moved.error().where = file_.atLine(line_);
      return moved;
    }
    at_ = to;
    return {};
  }

  /// An arc in the plane, straight along the third axis.
  Result<void> arc(const Block& block, const model::Point3& to, bool clockwise) {
    const auto [u, v, w] = plane_;
    const Eigen::Vector2d from2(at_[u], at_[v]);
    const Eigen::Vector2d to2(to[u], to[v]);
    const auto centre = centreOf(block, from2, to2, clockwise);
    if (!centre) return pass(centre.error());
    if (block.turns && *block.turns != 1) {
      return unsupported(fmt::format("P{}", *block.turns), "an arc of several turns; write each");
    }
    const Eigen::Vector2d begin = from2 - *centre;
    const Eigen::Vector2d end = to2 - *centre;
    const double radius = begin.norm();
    const double endRadius = end.norm();
    if (!(radius > 0)) return refused("the arc begins at its centre");
    if (std::abs(radius - endRadius) > std::max(kArcRounding, kArcRoundingPart * radius)) {
      return refused(
          fmt::format("the arc begins {:.6g} mm from its centre and ends {:.6g} mm from it", radius,
                      endRadius));
    }
    double angle = std::atan2(begin.x() * end.y() - begin.y() * end.x(), begin.dot(end));
    if (from2 == to2) angle = 0;  // a full circle
    if (clockwise && angle >= 0) angle -= 2 * std::numbers::pi;
    if (!clockwise && angle <= 0) angle += 2 * std::numbers::pi;
    const double largest = std::max(radius, endRadius);
    const double step = options_.tolerance < largest
                            ? 2 * std::acos(1 - options_.tolerance / largest)
                            : std::numbers::pi / 2;
    const double chords = std::ceil(std::abs(angle) / std::min(step, std::numbers::pi / 4));
    if (!(chords <= static_cast<double>(model::kMaxSegments))) {
      return refused(
          fmt::format("the arc has {:.3g} chords of the tolerance {}; allow a larger one", chords,
                      options_.tolerance));
    }
    const double height = to[w] - at_[w];
    const double seconds = 60 * std::hypot(radius * angle, height) / feed_ / chords;
    const model::Point3 start = at_;
    for (std::uint64_t i = 1; i <= static_cast<std::uint64_t>(chords); ++i) {
      const double part = static_cast<double>(i) / chords;
      model::Point3 next = to;
      if (part < 1) {
        const double turn = part * angle;
        const double scale = (1 - part) + part * endRadius / radius;
        next[u] = centre->x() + scale * (std::cos(turn) * begin.x() - std::sin(turn) * begin.y());
        next[v] = centre->y() + scale * (std::sin(turn) * begin.x() + std::cos(turn) * begin.y());
        next[w] = start[w] + part * height;
      }
      if (auto moved = straight(next, seconds, false); !moved) return moved;
    }
    return {};
  }

  Result<Eigen::Vector2d> centreOf(const Block& block, const Eigen::Vector2d& from,
                                   const Eigen::Vector2d& to, bool clockwise) const {
    const auto [u, v, w] = plane_;
    const auto centreU = block.centre[static_cast<std::size_t>(u)];
    const auto centreV = block.centre[static_cast<std::size_t>(v)];
    if (block.centre[static_cast<std::size_t>(w)]) {
      return refused(fmt::format("{} is not in the plane of the arc (G17, G18, G19)", "IJK"[w]));
    }
    if (block.radius) {
      if (centreU || centreV) return refused("an arc has both a radius and a centre");
      const double radius = *block.radius * unit_;
      const Eigen::Vector2d chord = to - from;
      const double length = chord.norm();
      if (!(length > 0)) return refused("an arc by radius ends where it begins; give its centre");
      const double square = radius * radius - length * length / 4;
      if (length / 2 > std::abs(radius) + kArcRounding) {
        return refused(
            fmt::format("the ends of the arc are {:.6g} mm apart, and its radius is "
                        "{:.6g} mm",
                        length, std::abs(radius)));
      }
      const double away = std::sqrt(std::max(square, 0.0)) / length;
      const double side = (radius > 0) == clockwise ? -1 : 1;
      return Eigen::Vector2d(from + chord / 2 +
                             side * away * Eigen::Vector2d(-chord.y(), chord.x()));
    }
    if (!centreU && !centreV) return refused("an arc has neither centre (I, J, K) nor radius (R)");
    if (!relativeCentre_) {
      if (!centreU || !centreV) return refused("with G90.1 an arc has both numbers of its centre");
      return Eigen::Vector2d(*centreU * unit_, *centreV * unit_);
    }
    return Eigen::Vector2d(from +
                           unit_ * Eigen::Vector2d(centreU.value_or(0), centreV.value_or(0)));
  }

  const InputFile& file_;
  const ToolPathOptions& options_;
  ToolPathBuilder builder_;
  std::uint64_t line_ = 1;
  std::size_t moves_ = 0;
  std::size_t dwells_ = 0;
  std::size_t optionalLines_ = 0;
  bool cuts_ = false;  // whether a cutting move has been read
  bool ended_ = false;
  // What lines set for those after them.
  double unit_ = 1;  // mm
  bool relative_ = false;
  bool relativeCentre_ = true;
  std::array<int, 3> plane_ = {0, 1, 2};
  Origin origin_;
  Origin firstOrigin_;  // of the first move
  std::optional<int> motion_;
  double feed_ = 0;  // mm/min
  std::optional<double> tool_;
  std::optional<double> mounted_;
  model::Point3 at_ = model::Point3::Zero();
  std::array<bool, 3> known_{};
};

}  // namespace

Result<ToolPath> readGcode(const InputFile& file, const ToolPathOptions& options) {
  return GcodeReader(file, options).read();
}

Result<ToolPath> readGcode(const std::filesystem::path& path, const ToolPathOptions& options) {
  const auto file = readInputFile(path);
  if (!file) return pass(file.error());
  return readGcode(*file, options);
}

}  // namespace t4d::formats
