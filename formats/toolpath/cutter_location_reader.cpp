#include "formats/toolpath/cutter_location_reader.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "formats/text/text_scanner.h"
#include "model/number.h"

namespace t4d::formats {
namespace {

constexpr double kMillimetresInAnInch = 25.4;

constexpr std::array<std::string_view, 25> kHarmless = {
    "PARTNO", "PPRINT", "MACHIN", "SPINDL", "COOLNT", "TOOLNO",  "SELCTL",   "MULTAX", "CUTTER",
    "INTOL",  "OUTTOL", "TOLER",  "STOP",   "OPSTOP", "REMARK",  "INSERT",   "SEQNO",  "PREFUN",
    "AUXFUN", "CUTCOM", "TLDATA", "MSYS",   "PAINT",  "SPINDLE", "TOOL PATH"};

class CutterLocationReader {
 public:
  CutterLocationReader(const InputFile& file, const ToolPathOptions& options)
      : file_(file), options_(options) {}

  Result<ToolPath> read() {
    std::string_view text = file_.bytes;
    if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
    std::string statement;
    std::uint64_t number = 0;
    while (!text.empty() && !ended_) {
      const auto end = std::min(text.find_first_of("\r\n"), text.size());
      std::string_view line = text.substr(0, end);
      const bool two = text.substr(end).starts_with("\r\n");
      text.remove_prefix(std::min(end + (two ? 2 : 1), text.size()));
      ++number;
      if (statement.empty()) line_ = number;
      line = line.substr(0, line.find("$$"));
      while (!line.empty() && (line.back() == ' ' || line.back() == '\t')) line.remove_suffix(1);
      const bool continues = line.ends_with('$');
      if (continues) line.remove_suffix(1);
      for (const char c : line) {
        statement += c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c == '\t' ? ' ' : c;
      }
      if (continues && !text.empty()) continue;
      if (auto done = apply(statement); !done) return done.error();
      statement.clear();
    }
    builder_.path.moves = moves_;
    auto path = builder_.finish();
    if (!path && path.error().where.empty()) path.error().where = file_.path.string();
    return path;
  }

 private:
  Error refused(std::string message) const {
    return invalid(std::move(message), file_.atLine(line_));
  }

  static std::string_view trimmed(std::string_view text) {
    while (text.starts_with(' ')) text.remove_prefix(1);
    while (text.ends_with(' ')) text.remove_suffix(1);
    return text;
  }

  Result<void> apply(std::string_view statement) {
    statement = trimmed(statement);
    if (statement.empty()) return {};
    const auto slash = std::min(statement.find('/'), statement.size());
    const std::string_view word = trimmed(statement.substr(0, slash));
    std::string_view rest = statement.substr(std::min(slash + 1, statement.size()));
    std::vector<std::string_view> values;
    while (slash < statement.size()) {
      const auto comma = std::min(rest.find(','), rest.size());
      values.push_back(trimmed(rest.substr(0, comma)));
      if (comma == rest.size()) break;
      rest.remove_prefix(comma + 1);
    }
    if (word == "GOTO" || word == "FROM") return goTo(values, word);
    if (word == "FEDRAT") return setFeed(values);
    if (word == "RAPID") {
      rapid_ = true;
      return {};
    }
    if (word == "UNITS") return setUnits(values);
    if (word == "END" || word == "FINI" || word == "END-OF-PATH") {
      ended_ = true;
      return {};
    }
    if (word == "LOADTL" || word == "LOADTOOL") return loadTool(values);
    const auto isThis = [&](std::string_view known) { return word.starts_with(known); };
    if (std::ranges::any_of(kHarmless, isThis)) return {};
    return fail(ErrorCode::Unsupported,
                fmt::format("{} is not supported; known are GOTO, FROM, FEDRAT, RAPID, UNITS, and "
                            "statements that move nothing",
                            inQuotes(word)),
                file_.atLine(line_));
  }

  Result<void> loadTool(const std::vector<std::string_view>& values) {
    const std::string tool(values.empty() ? "" : values[0]);
    if (options_.tools) {
      const auto number = numberOf(tool);
      if (!number) return number.error();
      auto mounted = builder_.mount(static_cast<int>(std::clamp(*number, -1.0, 1e9)));
      if (!mounted) mounted.error().where = file_.atLine(line_);
      return mounted;
    }
    if (moves_ > 0 && tool != tool_) {
      return fail(
          ErrorCode::Unsupported,
          fmt::format("a second tool is loaded ({}), and one is given for all", inQuotes(tool)),
          file_.atLine(line_), Remedy::EachTool);
    }
    tool_ = tool;
    return {};
  }

  Result<double> numberOf(std::string_view text) const {
    const auto value = model::numberIn<double>(model::withoutPlus(text));
    if (!value || !std::isfinite(*value)) {
      return refused(fmt::format("found {}, expected a number", inQuotes(text)));
    }
    return *value;
  }

  Result<void> setUnits(const std::vector<std::string_view>& values) {
    if (values.size() == 1 && (values[0] == "MM" || values[0] == "MILLIMETERS")) {
      unit_ = 1;
    } else if (values.size() == 1 &&
               (values[0] == "INCHES" || values[0] == "INCH" || values[0] == "IN")) {
      unit_ = kMillimetresInAnInch;
    } else {
      return refused("UNITS is followed by something else than MM or INCHES");
    }
    return {};
  }

  Result<void> setFeed(const std::vector<std::string_view>& values) {
    std::optional<double> feed;
    double unit = unit_;
    for (const std::string_view value : values) {
      if (value == "MMPM" || value == "PERMIN") {
        unit = value == "MMPM" ? 1 : unit_;
      } else if (value == "IPM") {
        unit = kMillimetresInAnInch;
      } else if (value == "MMPR" || value == "IPR" || value == "PERREV") {
        return fail(ErrorCode::Unsupported,
                    fmt::format("{} is not supported: it is feed per turn; have feed per minute "
                                "written",
                                value),
                    file_.atLine(line_));
      } else {
        const auto number = numberOf(value);
        if (!number) return number.error();
        feed = *number;
      }
    }
    if (!feed || !(*feed > 0)) return refused("FEDRAT names no feed above zero");
    feed_ = *feed * unit;
    rapid_ = false;
    return {};
  }

  Result<void> goTo(const std::vector<std::string_view>& values, std::string_view word) {
    if (values.size() != 3 && values.size() != 6) {
      return refused(
          fmt::format("{} has {} numbers; expected x,y,z or x,y,z,i,j,k", word, values.size()));
    }
    std::array<double, 6> numbers{};
    for (std::size_t i = 0; i < values.size(); ++i) {
      const auto number = numberOf(values[i]);
      if (!number) return number.error();
      numbers[i] = *number;
    }
    const model::Point3 tip = unit_ * model::Point3(&numbers[0]);
    if (values.size() == 6) {
      const Eigen::Vector3d axis(&numbers[3]);
      if (!(axis.stableNorm() > 0)) return refused("the axis of the tool has the length zero");
      axis_ = axis.stableNormalized();
    }
    ++moves_;
    const bool rapid = std::exchange(rapid_, false);
    if (!builder_.started() || word == "FROM") {
      if (builder_.started()) return refused("FROM comes after a move");
      builder_.start(tip, axis_);
      return {};
    }
    const double length = (tip - builder_.tip()).norm();
    if (options_.tools && builder_.path.mountings.empty()) {
      return refused("a move comes before a tool is loaded (LOADTL/1)");
    }
    if (!rapid && !(feed_ > 0)) return refused("a move has no feed; give FEDRAT before");
    const double feed = rapid ? options_.rapidFeed : feed_;
    const double seconds = length > ToolPathBuilder::kNoWay
                               ? 60 * length / feed
                               : builder_.turnTo(axis_) / ToolPathBuilder::kTurnDegreesPerSecond;
    auto moved = builder_.moveTo(tip, axis_, seconds, rapid);
    if (!moved) moved.error().where = file_.atLine(line_);
    return moved;
  }

  const InputFile& file_;
  const ToolPathOptions& options_;
  ToolPathBuilder builder_{options_};
  std::uint64_t line_ = 1;
  std::size_t moves_ = 0;
  std::string tool_;
  bool ended_ = false;
  bool rapid_ = false;
  double unit_ = 1;  // mm
  double feed_ = 0;  // mm/min
  Eigen::Vector3d axis_ = Eigen::Vector3d::UnitZ();
};

}  // namespace

Result<ToolPath> readCutterLocations(const InputFile& file, const ToolPathOptions& options) {
  return CutterLocationReader(file, options).read();
}

Result<ToolPath> readCutterLocations(const std::filesystem::path& path,
                                     const ToolPathOptions& options) {
  const auto file = readInputFile(path);
  if (!file) return file.error();
  return readCutterLocations(*file, options);
}

}  // namespace t4d::formats
