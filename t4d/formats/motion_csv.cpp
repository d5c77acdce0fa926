#include "t4d/formats/motion_csv.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "t4d/formats/text_scanner.h"

namespace t4d::formats {
namespace {

/// What a column holds: one of the numbers of a pose.
enum Part : int { kTime, kPosition = 1, kQuaternion = 4, kMatrix = 8, kParts = 24 };

constexpr const char* kTimeColumns = "time, t or timestamp";
constexpr const char* kKnownColumns =
    "the time (time, t or timestamp); the position (x y z, also px, tx, pos_x, position_x, "
    "translation_x and so on); the quaternion (qx qy qz qw, also quat_x, quaternion_x and so on); "
    "or the matrix m00 to m23 or m33 (row, column; also m11 to m34 or m44)";

std::string lowerCase(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return lower;
}

std::string_view trimmed(std::string_view text) {
  const auto isBlank = [](char c) { return c == ' ' || c == '\t'; };
  while (!text.empty() && isBlank(text.front())) text.remove_prefix(1);
  while (!text.empty() && isBlank(text.back())) text.remove_suffix(1);
  const bool quoted = text.size() >= 2 && text.front() == '"' && text.back() == '"';
  return quoted ? text.substr(1, text.size() - 2) : text;
}

/// A blank as the separator stands for any number of blanks and tabs.
std::vector<std::string_view> fieldsOf(std::string_view line, char separator) {
  std::vector<std::string_view> fields;
  if (separator == ' ') {
    for (line = trimmed(line); !line.empty(); line = trimmed(line)) {
      const auto end = std::min(line.find_first_of(" \t"), line.size());
      fields.push_back(trimmed(line.substr(0, end)));
      line.remove_prefix(end);
    }
    return fields;
  }
  while (true) {
    const auto end = line.find(separator);
    fields.push_back(trimmed(line.substr(0, end)));
    if (end == line.npos) return fields;
    line.remove_prefix(end + 1);
  }
}

char separatorOf(std::string_view line) {
  const auto has = [&](char c) { return line.find(c) != line.npos; };
  if (has(';')) return ';';
  if (!has('\t')) return has(',') ? ',' : ' ';
  // "time,<tab>x" is separated by commas, in "0,5<tab>1" they are in numbers.
  const auto fields = fieldsOf(line, '\t');
  const bool commas = std::ranges::any_of(fields, [](auto field) { return field.ends_with(','); });
  return commas ? ',' : '\t';
}

/// Whether a number such as 1,500 could also have thousands apart: up to three digits, not 0, and
/// three more.
bool mayBeThousands(std::string_view number) {
  if (number.starts_with('-') || number.starts_with('+')) number.remove_prefix(1);
  const auto comma = number.find(',');
  return comma >= 1 && comma <= 3 && number[0] != '0' && number.size() - comma == 4 &&
         number.find_first_of("eE") == number.npos;
}

/// The place of `letter` in `letters` behind one of the prefixes; nothing if it is none of them.
std::optional<int> lettered(const std::string& name, std::initializer_list<std::string_view> before,
                            std::string_view letters) {
  for (const std::string_view prefix : before) {
    if (name.size() != prefix.size() + 1 || !name.starts_with(prefix)) continue;
    const auto at = letters.find(name.back());
    if (at != letters.npos) return static_cast<int>(at);
  }
  return std::nullopt;
}

/// `firstIndex` is how the columns of a matrix are counted: from 0 or from 1.
std::optional<int> partOf(const std::string& name, int firstIndex) {
  if (name == "time" || name == "t" || name == "timestamp") return kTime;
  if (const auto axis =
          lettered(name, {"", "p", "t", "pos_", "position_", "translation_"}, "xyz")) {
    return kPosition + *axis;
  }
  if (const auto axis = lettered(name, {"q", "quat_", "quaternion_"}, "xyzw")) {
    return kQuaternion + *axis;
  }
  if (name.size() != 3 || name[0] != 'm') return std::nullopt;
  const int row = name[1] - '0' - firstIndex;
  const int column = name[2] - '0' - firstIndex;
  if (row < 0 || row > 3 || column < 0 || column > 3) return std::nullopt;
  return kMatrix + 4 * row + column;
}

class TableReader {
 public:
  TableReader(const InputFile& file, std::string* form)
      : file_(file), scanner_(file, {.comment = '#'}), form_(form) {}

  Result<model::Motion> read() {
    if (auto done = readHeader(); !done) return pass(done.error());
    if (auto done = findDecimalComma(); !done) return pass(done.error());
    if (form_ != nullptr) *form_ = form();
    std::vector<model::KeyPose> poses;
    std::vector<std::uint64_t> lines;
    if (first_) {
      auto pose = readPose(*first_);
      if (!pose) return pass(pose.error());
      poses.push_back(*pose);
      lines.push_back(firstLine_);
    }
    while (scanner_.nextLine()) {
      auto pose = readPose(scanner_.rest());
      if (!pose) return pass(pose.error());
      poses.push_back(*pose);
      lines.push_back(scanner_.line());
    }
    auto motion = joinPoses(poses);
    if (!motion) return invalid(motion.error().text(), file_.path.string());
    for (model::HalfTurn& turn : motion->halfTurns) {
      turn.between = fmt::format("lines {} and {}", lines[turn.pose], lines[turn.pose + 1]);
    }
    return motion;
  }

 private:
  using Numbers = std::array<double, kParts>;

  Result<void> readHeader() {
    scanner_.nextLine();
    const std::string_view line = scanner_.rest();
    separator_ = separatorOf(line);
    auto names = fieldsOf(line, separator_);
    if (auto inComment = namesInComment(names); !inComment.empty()) {
      names = std::move(inComment);
      first_ = line;
      firstLine_ = scanner_.line();
    }
    const bool fromZero =
        std::ranges::any_of(names, [](std::string_view name) { return lowerCase(name) == "m00"; });
    std::array<bool, kParts> has{};
    for (const std::string_view name : names) {
      const auto part = partOf(lowerCase(name), fromZero ? 0 : 1);
      double number = 0;
      if (!part && scanner_.parse(name, number, "")) {
        return scanner_.invalidHere(fmt::format(
            "found the number {}, expected a first line with the names of the columns: {}",
            inQuotes(name), kKnownColumns));
      }
      if (!part) {
        return scanner_.invalidHere(fmt::format(
            "the column {} is unknown; {}known are {}", inQuotes(name),
            names.size() == 1 ? "columns are separated by commas, semicolons, tabs or blanks; "
                              : "",
            kKnownColumns));
      }
      if (has[static_cast<std::size_t>(*part)]) {
        return scanner_.invalidHere(fmt::format(
            "the column {} holds the same number of a pose as the column {}", inQuotes(name),
            inQuotes(names_[static_cast<std::size_t>(
                std::ranges::find(parts_, static_cast<std::size_t>(*part)) - parts_.begin())])));
      }
      has[static_cast<std::size_t>(*part)] = true;
      parts_.push_back(static_cast<std::size_t>(*part));
      names_.emplace_back(name);
    }
    const auto count = [&](int from, int to) { return std::count(&has[from], &has[0] + to, true); };
    const auto matrix = count(kMatrix, kParts);
    const auto fourthRow = count(kMatrix + 12, kParts);
    const auto positions = count(kPosition, kQuaternion);
    const auto quaternions = count(kQuaternion, kMatrix);
    hasMatrix_ = matrix > 0;
    const bool whole =
        hasMatrix_ ? matrix - fourthRow == 12 && fourthRow % 4 == 0 && positions + quaternions == 0
                   : (positions == 3 || positions == 0) && (quaternions == 4 || quaternions == 0) &&
                         positions + quaternions > 0;
    if (has[kTime] && whole) return {};
    if (!has[kTime] && whole) {
      return scanner_.invalidHere(
          fmt::format("the column of the time is missing ({}); the columns are {}", kTimeColumns,
                      fmt::join(names_, ", ")));
    }
    if (const std::string missing = missingParts(has); !missing.empty()) {
      return scanner_.invalidHere(
          fmt::format("{} missing; the columns are {}", missing, fmt::join(names_, ", ")));
    }
    return scanner_.invalidHere(
        fmt::format("the columns are {}; expected the time with a position, a quaternion or both, "
                    "or with a whole matrix: {}",
                    fmt::join(names_, ", "), kKnownColumns));
  }

  /// The names of the columns in the last comment before this line of numbers, as in
  /// `# timestamp tx ty tz qx qy qz qw`; empty if that is not what they are.
  std::vector<std::string_view> namesInComment(const std::vector<std::string_view>& numbers) {
    double number = 0;
    for (const std::string_view field : numbers) {
      std::string pointed(field);
      std::ranges::replace(pointed, ',', '.');
      if (!scanner_.parse(pointed, number, "")) return {};
    }
    std::string_view comment;
    std::string_view rest = file_.bytes;
    for (std::uint64_t line = 1; line < scanner_.line(); ++line) {
      const auto end = std::min(rest.find('\n'), rest.size());
      std::string_view here = trimmed(rest.substr(0, end));
      rest.remove_prefix(std::min(end + 1, rest.size()));
      while (here.ends_with('\r') || here.ends_with(' ')) here.remove_suffix(1);
      if (here.starts_with('#')) comment = here.substr(1);
    }
    auto names = fieldsOf(trimmed(comment), separatorOf(comment));
    const bool known =
        names.size() == numbers.size() && std::ranges::all_of(names, [](std::string_view name) {
          return partOf(lowerCase(name), 0) || partOf(lowerCase(name), 1);
        });
    return known ? names : std::vector<std::string_view>();
  }

  /// Whether numbers have decimal commas, which they can where commas separate nothing.
  Result<void> findDecimalComma() {
    if (separator_ == ',') return {};
    TextScanner lines = scanner_;
    std::string_view fieldsHere = first_.value_or("");
    std::uint64_t line = firstLine_;
    std::string pointed;
    std::string unclear;
    std::uint64_t unclearLine = 0;
    bool certain = false;
    do {
      for (const std::string_view field : fieldsOf(fieldsHere, separator_)) {
        const auto commas = std::ranges::count(field, ',');
        if (commas == 0 && field.find('.') != field.npos && pointed.empty()) pointed = field;
        if (commas != 1 || field.find('.') != field.npos) continue;
        certain = certain || !mayBeThousands(field);
        if (unclear.empty()) {
          unclear = field;
          unclearLine = line;
        }
      }
      if (!lines.nextLine()) break;
      fieldsHere = lines.rest();
      line = lines.line();
    } while (true);
    if (unclear.empty()) return {};
    if (!pointed.empty()) {
      return invalid(
          fmt::format("found {} and {}: numbers have a decimal comma or a decimal point, "
                      "not both",
                      inQuotes(unclear), inQuotes(pointed)),
          file_.atLine(unclearLine));
    }
    if (!certain) {
      return invalid(fmt::format("found {}, whose comma may be a decimal comma or stand between "
                                 "thousands; write decimal points",
                                 inQuotes(unclear)),
                     file_.atLine(unclearLine));
    }
    decimalComma_ = true;
    return {};
  }

  /// What is unusual about the table, for a note.
  std::string form() const {
    std::vector<std::string_view> parts;
    if (separator_ == ' ') parts.emplace_back("columns are separated by blanks");
    if (first_) parts.emplace_back("their names are in a comment");
    if (decimalComma_) parts.emplace_back("numbers have decimal commas");
    return fmt::format("{}", fmt::join(parts, ", "));
  }

  /// Which columns a position, a quaternion or a matrix lacks that is there in part, if only one of
  /// them is begun.
  static std::string missingParts(const std::array<bool, kParts>& has) {
    struct Group {
      int begin;
      int end;
      std::vector<const char*> names;
    };
    static const std::array<Group, 2> kGroups = {
        {{kPosition, kQuaternion, {"x", "y", "z"}},
         {kQuaternion, kMatrix, {"qx", "qy", "qz", "qw"}}}};
    if (std::count(&has[kMatrix], &has[0] + kParts, true) > 0) return {};
    std::vector<const char*> missing;
    for (const Group& group : kGroups) {
      const auto there = std::count(&has[0] + group.begin, &has[0] + group.end, true);
      for (int part = group.begin; there > 0 && part < group.end; ++part) {
        if (!has[static_cast<std::size_t>(part)]) {
          missing.push_back(group.names[static_cast<std::size_t>(part - group.begin)]);
        }
      }
    }
    if (missing.empty()) return {};
    return fmt::format("{} {} {}", missing.size() == 1 ? "the column" : "the columns",
                       fmt::join(missing, ", "), missing.size() == 1 ? "is" : "are");
  }

  Result<model::KeyPose> readPose(std::string_view line) {
    const auto fields = fieldsOf(line, separator_);
    if (fields.size() != parts_.size()) {
      return scanner_.invalidHere(
          fmt::format("has {} fields, but {} columns are named", fields.size(), parts_.size()));
    }
    Numbers numbers{};
    numbers[kQuaternion + 3] = 1;
    numbers[kMatrix + 15] = 1;
    for (std::size_t i = 0; i < fields.size(); ++i) {
      std::string field(fields[i]);
      if (decimalComma_) std::ranges::replace(field, ',', '.');
      if (!scanner_.parse(field, numbers[parts_[i]], "a number")) {
        return scanner_.invalidHere(
            fmt::format("column {}: found {}, expected a number", names_[i], inQuotes(fields[i])));
      }
    }
    model::KeyPose pose;
    pose.time = numbers[kTime];
    return hasMatrix_ ? withMatrix(pose, numbers) : withQuaternion(pose, numbers);
  }

  Result<model::KeyPose> withQuaternion(model::KeyPose pose, const Numbers& numbers) {
    pose.position = model::Point3(&numbers[kPosition]);
    const double* q = &numbers[kQuaternion];
    pose.quaternion = Eigen::Quaterniond(q[3], q[0], q[1], q[2]);
    const double length = pose.quaternion.norm();
    if (!(std::abs(length - 1) <= kRounded)) {
      return scanner_.invalidHere(fmt::format("a quaternion of length {}, expected 1", length));
    }
    pose.quaternion.normalize();
    return pose;
  }

  Result<model::KeyPose> withMatrix(model::KeyPose pose, const Numbers& numbers) {
    const Eigen::Matrix4d matrix =
        Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(&numbers[kMatrix]);
    if (matrix.row(3) != Eigen::RowVector4d(0, 0, 0, 1)) {
      return scanner_.invalidHere("the last row of the matrix is not 0 0 0 1");
    }
    const Eigen::Matrix3d turn = matrix.topLeftCorner<3, 3>();
    if (!(turn * turn.transpose()).isIdentity(kRounded) || !(turn.determinant() > 0)) {
      return scanner_.invalidHere(
          "the matrix scales, shears or mirrors: a rigid motion only turns "
          "and moves");
    }
    pose.quaternion = Eigen::Quaterniond(turn).normalized();
    pose.position = matrix.topRightCorner<3, 1>();
    return pose;
  }

  /// Tables often have few digits; an error in the order of columns is far larger.
  static constexpr double kRounded = 1e-2;

  const InputFile& file_;
  TextScanner scanner_;
  std::string* form_;
  char separator_ = ',';
  bool decimalComma_ = false;
  std::optional<std::string_view> first_;  // pose, if a comment has the names
  std::uint64_t firstLine_ = 0;
  std::vector<std::size_t> parts_;  // of each column
  std::vector<std::string> names_;
  bool hasMatrix_ = false;
};

}  // namespace

Result<model::Motion> readMotionCsv(const InputFile& file, std::string* form) {
  return TableReader(file, form).read();
}

}  // namespace t4d::formats
