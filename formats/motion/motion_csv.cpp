#include "formats/motion/motion_csv.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "formats/input_file.h"
#include "formats/motion/time_column.h"
#include "formats/text/number_table.h"
#include "model/degrees.h"
#include "t4d/motion.h"

namespace t4d::formats {
namespace {

/// The contents of a column: one of the numbers of a pose. Numbered quaternions have their own
/// numbers until it is known which is w.
enum Part : int {
  kPosition = 0,
  kQuaternion = 3,
  kNumbered = 7,
  kRollPitchYaw = 11,
  kRotationVector = 14,
  kMatrix = 17,
  kParts = 33
};

/// The numbers of one kind, which come together.
struct Group {
  int begin;
  int end;
  const char* names;
};
constexpr std::array<Group, 5> kGroups = {{{kPosition, kQuaternion, "x y z"},
                                           {kQuaternion, kNumbered, "qx qy qz qw"},
                                           {kNumbered, kRollPitchYaw, "q1 q2 q3 q4"},
                                           {kRollPitchYaw, kRotationVector, "roll pitch yaw"},
                                           {kRotationVector, kMatrix, "rx ry rz"}}};

constexpr const char* kKnownColumns =
    "the time (time, t or timestamp; secs and nsecs); the position (x y z, also px, tx, pos_x, "
    "position_x, translation_x, position.x and so on); the quaternion (qx qy qz qw, also quat_x, "
    "quaternion_x, orientation.x and so on), angles roll, pitch and yaw, or a rotation vector (rx "
    "ry rz); or the matrix m00 to m23 or m33 (row, column; also m11 to m34 or m44)";

/// The place of `letter` in `letters` behind one of the prefixes; nothing if it is none of them.
std::optional<int> lettered(std::string_view name, std::initializer_list<std::string_view> before,
                            std::string_view letters) {
  for (const std::string_view prefix : before) {
    if (name.size() != prefix.size() + 1 || !name.starts_with(prefix)) continue;
    const auto at = letters.find(name.back());
    if (at != letters.npos) return static_cast<int>(at);
  }
  return std::nullopt;
}

/// The last two parts of a name such as `field.pose.position.x` or `/tool/pose/position/x`, with a
/// dot.
std::string lastParts(const std::string& name) {
  const auto last = name.find_last_of("./");
  if (last == name.npos || last == 0) return name;
  const auto before = name.find_last_of("./", last - 1);
  const auto begin = before == name.npos ? 0 : before + 1;
  return name.substr(begin, last - begin) + "." + name.substr(last + 1);
}

bool isQualified(const std::string& name) { return name.find_first_of("./") != name.npos; }

/// How columns with numbers in their names are counted: from 0 or from 1.
struct FirstIndex {
  int matrix = 1;
  int quaternion = 1;
};

FirstIndex firstIndexOf(std::span<const std::string> names) {
  FirstIndex first;
  for (const std::string& name : names) {
    const std::string base = columnName(name).base;
    if (base == "m00") first.matrix = 0;
    if (base == "q0") first.quaternion = 0;
  }
  return first;
}

std::optional<int> partOf(const std::string& base, const FirstIndex& first) {
  const std::string name = lastParts(base);
  if (const auto axis = lettered(
          name,
          {"", "p", "t", "pos_", "position_", "translation_", "position.", "translation.", "pos."},
          "xyz")) {
    return kPosition + *axis;
  }
  if (const auto axis = lettered(name,
                                 {"q", "q_", "quat_", "quaternion_", "orientation_", "orientation.",
                                  "rotation.", "quaternion.", "quat."},
                                 "xyzw")) {
    return kQuaternion + *axis;
  }
  if (const auto axis = lettered(name, {"r"}, "xyz")) return kRotationVector + *axis;
  constexpr std::array kAngles = {"roll", "pitch", "yaw"};
  for (int i = 0; i < 3; ++i) {
    if (name.substr(name.find('.') + 1) == kAngles[static_cast<std::size_t>(i)]) {
      return kRollPitchYaw + i;
    }
  }
  if (name.size() == 2 && name[0] == 'q') {
    const int index = name[1] - '0' - first.quaternion;
    if (index >= 0 && index < 4) return kNumbered + index;
  }
  if (name.size() != 3 || name[0] != 'm') return std::nullopt;
  const int row = name[1] - '0' - first.matrix;
  const int column = name[2] - '0' - first.matrix;
  if (row < 0 || row > 3 || column < 0 || column > 3) return std::nullopt;
  return kMatrix + 4 * row + column;
}

bool arePoseColumns(const std::vector<std::string>& names) {
  const FirstIndex first = firstIndexOf(names);
  return std::ranges::all_of(names, [&](const std::string& name) {
    return TimeColumn::isTime(name) || partOf(columnName(name).base, first);
  });
}

/// Turns by roll about x, then by pitch about y, then by yaw about z, axes that do not turn along.
Eigen::Quaterniond fromRollPitchYaw(const Eigen::Vector3d& radians) {
  using Eigen::AngleAxisd;
  using Eigen::Vector3d;
  return AngleAxisd(radians[2], Vector3d::UnitZ()) * AngleAxisd(radians[1], Vector3d::UnitY()) *
         AngleAxisd(radians[0], Vector3d::UnitX());
}

Eigen::Quaterniond fromRotationVector(const Eigen::Vector3d& radians) {
  const double angle = radians.norm();
  if (!(angle > 0)) return Eigen::Quaterniond::Identity();
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle, radians / angle));
}

class TableReader {
 public:
  TableReader(const InputFile& file, std::string* form, const MotionTableOptions& options)
      : file_(file), options_(options), form_(form), table_(file) {}

  Result<model::Motion> read() {
    if (auto done = table_.begin(arePoseColumns); !done) return done.error();
    if (auto done = nameColumns(); !done) return done.error();
    if (auto done = findColumns(); !done) return done.error();
    if (auto done = findRotation(); !done) return done.error();
    if (auto done = findLengthUnit(); !done) return done.error();
    while (table_.nextRow()) {
      if (auto added = addRow(); !added) return added.error();
    }
    if (form_ != nullptr) *form_ = form();
    auto motion = joinPoses(poses_);
    if (!motion) return invalid(motion.error().text(), file_.path.string());
    for (model::HalfTurn& turn : motion->halfTurns) {
      turn.between =
          fmt::format("lines {} and {}", rows_.lines()[turn.pose], rows_.lines()[turn.pose + 1]);
    }
    motion->lengthUnit = lengthUnit_;
    motion->timeUnit = time_.unit();
    return motion;
  }

 private:
  /// The columns of a table that does not name them.
  Result<void> nameColumns() {
    const std::size_t count = table_.unnamedColumns();
    if (count == 0) return {};
    const bool isTum = table_.separatedByBlanks() && options_.angles.empty();
    if (count == 8 && (isTum || !options_.quaternion.empty())) {
      if (options_.quaternion == "wxyz") {
        table_.setNames({"time", "x", "y", "z", "qw", "qx", "qy", "qz"});
      } else {
        table_.setNames({"time", "x", "y", "z", "qx", "qy", "qz", "qw"});
      }
    } else if (count == 7 && options_.angles.starts_with("rpy")) {
      table_.setNames({"time", "x", "y", "z", "roll", "pitch", "yaw"});
    } else if (count == 7 && !options_.angles.empty()) {
      table_.setNames({"time", "x", "y", "z", "rx", "ry", "rz"});
    } else {
      return table_.invalidHere(
          fmt::format("found {} numbers, expected a first line with the names of the columns: {}",
                      count, kKnownColumns));
    }
    notes_.push_back(
        fmt::format("no names of columns: read as {}", fmt::join(table_.names(), " ")));
    return {};
  }

  Result<void> findColumns() {
    const std::vector<std::string>& names = table_.names();
    const FirstIndex first = firstIndexOf(names);
    const bool qualified = std::ranges::any_of(names, isQualified);
    time_ = TimeColumn::find(names);
    std::vector<std::string> skipped;
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (std::ranges::find(time_.columns(), i) != time_.columns().end()) continue;
      const auto part = partOf(columnName(names[i]).base, first);
      if (part) {
        if (auto set = setColumn(static_cast<std::size_t>(*part), i); !set) return set;
      } else if (qualified || TimeColumn::isTime(names[i])) {
        skipped.push_back(names[i]);
      } else {
        return table_.invalidHere(fmt::format(
            "the column {} is unknown; {}known are {}", inQuotes(names[i]),
            names.size() == 1 ? "columns are separated by commas, semicolons, tabs or blanks; "
                              : "",
            kKnownColumns));
      }
    }
    if (!skipped.empty()) notes_.push_back(noticeOfUnread(skipped));
    return checkColumns();
  }

  Result<void> setColumn(std::size_t part, std::size_t column) {
    const std::string& name = table_.names()[column];
    if (const auto other = columns_[part]) {
      return table_.invalidHere(
          fmt::format("the column {} holds the same number of a pose as the column {}",
                      inQuotes(name), inQuotes(table_.names()[*other])));
    }
    columns_[part] = column;
    return {};
  }

  std::ptrdiff_t countOf(int begin, int end) const {
    return std::count_if(&columns_[0] + begin, &columns_[0] + end,
                         [](const auto& column) { return column.has_value(); });
  }
  bool has(int begin, int end) const { return countOf(begin, end) == end - begin; }

  Result<void> checkColumns() {
    const auto matrix = countOf(kMatrix, kParts);
    const auto fourthRow = countOf(kMatrix + 12, kParts);
    const auto others = countOf(0, kMatrix);
    const auto named = [&] { return fmt::format("{}", fmt::join(table_.names(), ", ")); };
    int rotations = 0;
    bool whole = others > 0;
    for (const Group& group : kGroups) {
      const auto count = countOf(group.begin, group.end);
      whole = whole && (count == 0 || count == group.end - group.begin);
      if (group.begin != kPosition && count > 0) ++rotations;
    }
    whole = matrix > 0 ? matrix - fourthRow == 12 && fourthRow % 4 == 0 && others == 0
                       : whole && rotations <= 1;
    if (whole && !time_.empty()) return {};
    if (whole) {
      return table_.invalidHere(fmt::format(
          "the column of the time is missing ({}); the columns are {}", kTimeColumns, named()));
    }
    if (rotations > 1) {
      return table_.invalidHere(fmt::format(
          "the columns are {}, which give the rotation more than once; keep one of them", named()));
    }
    const std::string missing = matrix > 0 ? "" : missingColumns();
    if (!missing.empty()) {
      return table_.invalidHere(fmt::format("{} missing; the columns are {}", missing, named()));
    }
    return table_.invalidHere(
        fmt::format("the columns are {}; expected the time with a position, a rotation or both, or "
                    "with a whole matrix: {}",
                    named(), kKnownColumns));
  }

  /// The missing columns of the groups that are there in part.
  std::string missingColumns() const {
    std::vector<std::string_view> missing;
    for (const Group& group : kGroups) {
      if (countOf(group.begin, group.end) == 0) continue;
      std::string_view names = group.names;
      for (int part = group.begin; part < group.end; ++part) {
        const auto end = std::min(names.find(' '), names.size());
        if (!columns_[static_cast<std::size_t>(part)]) missing.push_back(names.substr(0, end));
        names.remove_prefix(std::min(end + 1, names.size()));
      }
    }
    if (missing.empty()) return {};
    return fmt::format("{} {} {}", missing.size() == 1 ? "the column" : "the columns",
                       fmt::join(missing, ", "), missing.size() == 1 ? "is" : "are");
  }

  /// The unit that columns state, the same for all; "" if none does.
  Result<std::string> unitOf(int begin, int end) const {
    std::string unit = columnName(table_.names()[*columns_[static_cast<std::size_t>(begin)]]).unit;
    for (int part = begin + 1; part < end; ++part) {
      const std::string& name = table_.names()[*columns_[static_cast<std::size_t>(part)]];
      if (columnName(name).unit == unit) continue;
      return table_.invalidHere(fmt::format(
          "the columns {} and {} have different units",
          inQuotes(table_.names()[*columns_[static_cast<std::size_t>(begin)]]), inQuotes(name)));
    }
    return unit;
  }

  Result<void> findRotation() {
    const bool numbered = has(kNumbered, kRollPitchYaw);
    if (numbered && options_.quaternion.empty()) {
      return table_.invalidHere(
          "the columns q1 to q4, or q0 to q3, do not say which is w: name them qx, qy, qz and qw, "
          "or state the order of `quaternion`, xyzw or wxyz");
    }
    if (!options_.quaternion.empty() && !numbered && table_.unnamedColumns() == 0) {
      return fail(ErrorCode::Options,
                  "the order of quaternions is stated, but the columns are named without it",
                  file_.path.string());
    }
    for (int part = kNumbered; numbered && part < kRollPitchYaw; ++part) {
      const auto axis = std::string_view("xyzw").find(
          options_.quaternion[static_cast<std::size_t>(part - kNumbered)]);
      columns_[kQuaternion + axis] = columns_[static_cast<std::size_t>(part)];
      columns_[static_cast<std::size_t>(part)].reset();
    }
    return findAngles();
  }

  /// Finds which columns are angles, and their unit.
  Result<void> findAngles() {
    const bool rollPitchYaw = has(kRollPitchYaw, kRotationVector);
    const bool vector = has(kRotationVector, kMatrix);
    if (!rollPitchYaw && !vector) {
      if (options_.angles.empty()) return {};
      return fail(ErrorCode::Options, "angles are stated, but the table has none",
                  file_.path.string());
    }
    angles_ = rollPitchYaw ? kRollPitchYaw : kRotationVector;
    auto named = unitOf(angles_, angles_ + 3);
    if (!named) return named.error();
    const auto colon = options_.angles.find(':');
    const std::string kind = options_.angles.substr(0, colon);
    std::string unit = colon == std::string::npos ? "" : options_.angles.substr(colon + 1);
    if (rollPitchYaw && kind == "rotvec") {
      return fail(ErrorCode::Options,
                  "rotation vectors are stated, but the columns are roll, pitch and yaw",
                  file_.path.string());
    }
    if (!named->empty() && !unit.empty() && *named != unit) {
      return fail(ErrorCode::Options,
                  fmt::format("angles are stated to be in '{}', but the names of the columns say "
                              "'{}'",
                              unit, *named),
                  file_.path.string());
    }
    if (!named->empty()) unit = *named;
    isVector_ = vector && kind != "rpy";
    if (isVector_ && kind.empty() && unit == "deg") {
      return table_.invalidHere(
          "rx, ry and rz in degrees may be a rotation vector or angles of roll, pitch and yaw: "
          "state `angles`, rotvec:deg or rpy:deg");
    }
    if (unit.empty() && !isVector_) {
      return table_.invalidHere(
          "nothing says whether roll, pitch and yaw are in degrees or radians: name the columns "
          "roll_deg or roll_rad and so on, or state `angles`, rpy:deg or rpy:rad");
    }
    statedUnit_ = !unit.empty();
    if (!statedUnit_) {
      unit = "rad";
      notes_.emplace_back("rx ry rz are rotation vectors in radians");
    }
    if (unit != "deg" && unit != "rad") {
      return table_.invalidHere(fmt::format("angles are in '{}', expected deg or rad", unit));
    }
    perUnit_ = unit == "deg" ? model::kRadiansPerDegree : 1;
    return {};
  }

  Result<void> findLengthUnit() {
    lengthUnit_ = options_.lengthUnit;
    if (!has(kPosition, kQuaternion)) return {};
    const auto named = unitOf(kPosition, kQuaternion);
    if (!named) return named.error();
    if (named->empty()) return {};
    if (lengthUnit_.empty()) lengthUnit_ = *named;
    const auto conversion = model::lengthConversion(*named, lengthUnit_);
    if (!conversion) {
      return table_.invalidHere(
          fmt::format("positions are in '{}', which cannot be converted to "
                      "'{}'; known units are nm, um, mm, cm, dm, m, km, in, "
                      "ft and yd",
                      *named, lengthUnit_));
    }
    length_ = *conversion;
    return {};
  }

  /// Adds the pose of this row, or leaves it out if it repeats the one before.
  Result<void> addRow() {
    const auto pose = readPose();
    if (!pose) return pose.error();
    // Either quaternion of a rotation stands for both.
    Eigen::Vector4d q = pose->quaternion.coeffs();
    const Eigen::Vector4d other = -q;
    if (std::ranges::lexicographical_compare(q, other)) q = other;
    const model::Point3& p = pose->position;
    const std::array content = {p.x(), p.y(), p.z(), q[0], q[1], q[2], q[3]};
    const auto added = rows_.add(table_, pose->time, content);
    if (!added) return added.error();
    if (*added) poses_.push_back(*pose);
    return {};
  }

  Result<model::KeyPose> readPose() {
    std::array<double, 2> stamps{};
    const auto time = std::span(stamps).first(time_.columns().size());
    if (auto read = table_.numbers(time_.columns(), time); !read) return read.error();
    if (poses_.empty()) {
      if (auto chosen = time_.choose(time, options_.timeUnit); !chosen) {
        return table_.invalidHere(chosen.error().message);
      }
    }
    model::KeyPose pose;
    pose.time = time_.at(time);
    return countOf(kMatrix, kParts) > 0 ? withMatrix(pose) : withRotation(pose);
  }

  /// The numbers of some parts; those that have no column keep their value.
  template <int Size>
  Result<void> read(int begin, Eigen::Matrix<double, Size, 1>& into) {
    for (int i = 0; i < Size; ++i) {
      const auto column = columns_[static_cast<std::size_t>(begin + i)];
      if (!column) continue;
      const auto done = table_.numbers(std::span(&*column, 1), std::span(&into[i], 1));
      if (!done) return done;
    }
    return {};
  }

  Result<model::KeyPose> withRotation(model::KeyPose pose) {
    if (auto done = read<3>(kPosition, pose.position); !done) return done.error();
    if (!pose.position.allFinite()) return table_.invalidHere("has a position that is not finite");
    for (double& coordinate : pose.position) coordinate = length_(coordinate);
    if (angles_ != 0) return withAngles(pose);
    Eigen::Vector4d q(0, 0, 0, 1);
    if (auto done = read<4>(kQuaternion, q); !done) return done.error();
    if (!(std::abs(q.norm() - 1) <= kRounded)) {
      return table_.invalidHere(fmt::format("a quaternion of length {}, expected 1", q.norm()));
    }
    pose.quaternion = Eigen::Quaterniond(q[3], q[0], q[1], q[2]).normalized();
    return pose;
  }

  Result<model::KeyPose> withAngles(model::KeyPose pose) {
    Eigen::Vector3d angles = Eigen::Vector3d::Zero();
    if (auto done = read<3>(angles_, angles); !done) return done.error();
    if (!angles.allFinite()) return table_.invalidHere("has an angle that is not finite");
    // A vector that turns by more is not one of radians.
    constexpr double kMostRadians = 2 * std::numbers::pi + kRounded;
    if (isVector_ && !statedUnit_ && angles.norm() > kMostRadians) {
      return table_.invalidHere(fmt::format(
          "rx, ry and rz are a rotation vector of {:.4g} radians, more than a whole turn: state "
          "`angles`, rotvec:deg, rotvec:rad, rpy:deg or rpy:rad",
          angles.norm()));
    }
    angles *= perUnit_;
    pose.quaternion = (isVector_ ? fromRotationVector(angles) : fromRollPitchYaw(angles));
    pose.quaternion.normalize();
    return pose;
  }

  Result<model::KeyPose> withMatrix(model::KeyPose pose) {
    Eigen::Matrix<double, 16, 1> numbers = Eigen::Matrix<double, 16, 1>::Zero();
    numbers[15] = 1;
    if (auto done = read<16>(kMatrix, numbers); !done) return done.error();
    const Eigen::Matrix4d matrix =
        Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(numbers.data());
    if (matrix.row(3) != Eigen::RowVector4d(0, 0, 0, 1)) {
      return table_.invalidHere("the last row of the matrix is not 0 0 0 1");
    }
    const Eigen::Matrix3d turn = matrix.topLeftCorner<3, 3>();
    if (!(turn * turn.transpose()).isIdentity(kRounded) || !(turn.determinant() > 0)) {
      return table_.invalidHere(
          "the matrix scales, shears or mirrors: a rigid motion only turns and moves");
    }
    pose.quaternion = Eigen::Quaterniond(turn).normalized();
    pose.position = matrix.topRightCorner<3, 1>();
    return pose;
  }

  /// Unusual properties of the table, for a note.
  std::string form() const {
    std::vector<std::string> parts = table_.form();
    parts.insert(parts.end(), notes_.begin(), notes_.end());
    if (auto notice = rows_.notice(); !notice.empty()) parts.push_back(notice);
    return fmt::format("{}", fmt::join(parts, ", "));
  }

  /// Tables often have few digits; an error in the order of columns is far larger.
  static constexpr double kRounded = 1e-2;

  const InputFile& file_;
  const MotionTableOptions& options_;
  std::string* form_;
  NumberTable table_;
  TimeColumn time_;
  std::array<std::optional<std::size_t>, kParts> columns_{};
  int angles_ = 0;  // the first part of the angles; 0 if there are none
  bool isVector_ = false;
  bool statedUnit_ = false;
  double perUnit_ = 1;  // radians
  std::string lengthUnit_;
  model::UnitConversion length_;
  std::vector<model::KeyPose> poses_;
  RowTimes rows_;
  std::vector<std::string> notes_;
};

}  // namespace

Result<model::Motion> readMotionCsv(const InputFile& file, std::string* form,
                                    const MotionTableOptions& options) {
  return TableReader(file, form, options).read();
}

}  // namespace t4d::formats
