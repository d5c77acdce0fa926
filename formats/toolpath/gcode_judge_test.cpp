#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <map>
#include <numbers>
#include <numeric>
#include <sstream>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "fixtures/milled_programs.h"
#include "formats/toolpath/gcode_reader.h"
#include "platform/test_folder.h"

/// The interpreter of LinuxCNC, rs274, as a judge of tool paths: the motions that it makes of a
/// program are those that readGcode does, in place, order, kind and time.
namespace t4d::formats {
namespace {

namespace fs = std::filesystem;
using model::Point3;

constexpr double kMmPerInch = 25.4;

// Its numbers, and offsets that are added to them, have four decimals.
constexpr double kRounding = 2e-4;

constexpr int kTools = 56;  // in its table

struct JudgedMove {
  Point3 end;  // of the tip, in the frame of the stock
  bool rapid = false;
  double rounding = 0;
  double feed = 0;  // mm/min; 0: not told
  double turn = 0;  // radians about the centre, in the plane of these axes
  std::array<int, 3> plane = {0, 1, 2};
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
};

/// Reads its canonical motions.
class CanonReader {
 public:
  CanonReader(Point3 machineZero, std::map<int, double> lengths)
      : machineZero_(std::move(machineZero)), lengths_(std::move(lengths)) {}

  std::vector<JudgedMove> read(const std::string& text) {
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
      // "   16 N104   ARC_FEED(1.0000, ...)"
      const auto open = line.find('(');
      if (open == std::string::npos) continue;
      // A long number stands without a blank before the name.
      auto name = line.find_last_of(' ', open) + 1;
      if (line[name] == 'N' && std::isdigit(line[name + 1]) != 0) {
        name = line.find_first_not_of("0123456789", name + 1);
      }
      take(line.substr(name, open - name), line.substr(open + 1));
    }
    return moves_;
  }

 private:
  static std::vector<double> numbersOf(std::string text) {
    std::ranges::replace(text, ',', ' ');
    std::istringstream in(text);
    std::vector<double> numbers;
    for (double value = 0; in >> value;) numbers.push_back(value);
    return numbers;
  }

  void take(const std::string& name, const std::string& rest) {
    const std::vector<double> n = numbersOf(rest);
    const auto point = [&](std::size_t first) {
      return Point3(unit_ * Point3(n.at(first), n.at(first + 1), n.at(first + 2)));
    };
    if (name == "USE_LENGTH_UNITS") unit_ = rest.starts_with("CANON_UNITS_MM") ? 1 : kMmPerInch;
    if (name == "SET_G5X_OFFSET") origin_ = point(1);
    if (name == "SET_XY_ROTATION") turn_ = Eigen::Rotation2Dd(n.at(0) * std::numbers::pi / 180);
    if (name == "SET_G92_OFFSET") shift_ = point(0);
    if (name == "USE_TOOL_LENGTH_OFFSET") lengthOffset_ = point(0);
    if (name == "SET_FEED_RATE") feed_ = unit_ * n.at(0);
    if (name == "CHANGE_TOOL" && !moves_.empty()) {
      JudgedMove jump = moves_.back();
      jump.end.z() -= lengths_[static_cast<int>(n.at(0))] - length_;
      jump.rapid = true;
      jump.turn = 0;
      moves_.push_back(jump);
    }
    if (name == "CHANGE_TOOL") length_ = lengths_[static_cast<int>(n.at(0))];
    if (name == "SELECT_PLANE") {
      plane_ = rest.starts_with("CANON_PLANE_XY")   ? std::array{0, 1, 2}
               : rest.starts_with("CANON_PLANE_XZ") ? std::array{2, 0, 1}
                                                    : std::array{1, 2, 0};
    }
    if (name == "STRAIGHT_TRAVERSE") moves_.push_back({tipOf(point(0)), true, kRounding * unit_});
    if (name == "STRAIGHT_FEED")
      moves_.push_back({tipOf(point(0)), false, kRounding * unit_, feed_});
    if (name == "ARC_FEED") takeArc(n);
  }

  Point3 tipOf(const Point3& programmed) const {
    Point3 turned = programmed + shift_;
    turned.head<2>() = turn_ * Eigen::Vector2d(turned.head<2>());
    return turned + origin_ + lengthOffset_ + machineZero_ - Point3(0, 0, length_);
  }

  void takeArc(const std::vector<double>& n) {
    const auto inSpace = [&](double u, double v, double w) {
      Point3 point;
      point[plane_[0]] = unit_ * u;
      point[plane_[1]] = unit_ * v;
      point[plane_[2]] = unit_ * w;
      return tipOf(point);
    };
    JudgedMove move{inSpace(n.at(0), n.at(1), n.at(5)), false, kRounding * unit_, feed_};
    const Point3 centre = inSpace(n.at(2), n.at(3), 0);
    move.plane = plane_;
    move.centre = {centre[plane_[0]], centre[plane_[1]]};
    const Point3 from = moves_.back().end;
    const Eigen::Vector2d begin = Eigen::Vector2d(from[plane_[0]], from[plane_[1]]) - move.centre;
    const Eigen::Vector2d end =
        Eigen::Vector2d(move.end[plane_[0]], move.end[plane_[1]]) - move.centre;
    const double rotation = n.at(4);
    const double sign = rotation > 0 ? 1 : -1;
    double angle = std::atan2(begin.x() * end.y() - begin.y() * end.x(), begin.dot(end));
    if (sign * angle < 1e-4) angle += sign * 2 * std::numbers::pi;
    move.turn = angle + sign * (std::abs(rotation) - 1) * 2 * std::numbers::pi;
    moves_.push_back(move);
  }

  Point3 machineZero_;
  std::map<int, double> lengths_;
  double unit_ = 1;
  Eigen::Rotation2Dd turn_ = Eigen::Rotation2Dd(0);
  double feed_ = 0;
  double length_ = 0;
  Point3 origin_ = Point3::Zero();
  Point3 shift_ = Point3::Zero();
  Point3 lengthOffset_ = Point3::Zero();
  std::array<int, 3> plane_ = {0, 1, 2};
  std::vector<JudgedMove> moves_;
};

/// Follows a path along the moves of the judge, and says where they part.
std::string differenceOf(const ToolPath& path, std::vector<JudgedMove> moves) {
  const auto& segments = path.motion.segments;
  std::size_t at = 0;
  const auto isRapid = [&](const model::Segment& segment) {
    const double middle = 0.5 * (segment.timeBegin + segment.timeEnd);
    return std::ranges::any_of(path.rapids, [&](const model::TimeSpan& rapid) {
      return rapid.begin < middle && middle < rapid.end;
    });
  };
  const Point3 start = segments.front().start.translation;
  const auto first = std::ranges::find_if(
      moves, [&](const JudgedMove& move) { return (move.end - start).norm() < move.rounding; });
  if (first == moves.end()) return "it never comes to where the path begins";
  Point3 from = start;
  for (auto move = first + 1; move != moves.end(); ++move) {
    if (move->turn == 0 && (move->end - from).norm() < 1e-9) continue;
    const auto where = [&](const std::string& what) {
      return fmt::format("move {} to ({:.4f}, {:.4f}, {:.4f}): {}", move - moves.begin(),
                         move->end.x(), move->end.y(), move->end.z(), what);
    };
    double turn = 0;
    double length = 0;
    double seconds = 0;
    bool arrived = (from - move->end).norm() < move->rounding && move->turn == 0;
    while (at < segments.size() && !arrived) {
      const model::Segment& segment = segments[at++];
      const Point3 begin = segment.start.translation;
      const Point3 end = segment.end.translation;
      if (isRapid(segment) != move->rapid) return where("rapid by one of them");
      length += (end - begin).norm();
      seconds += segment.timeEnd - segment.timeBegin;
      const auto flat = [&](const Point3& point) {
        return Eigen::Vector2d(Eigen::Vector2d(point[move->plane[0]], point[move->plane[1]]) -
                               move->centre);
      };
      const Eigen::Vector2d a = flat(begin);
      const Eigen::Vector2d b = flat(end);
      turn += std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b));
      arrived = (end - move->end).norm() < move->rounding &&
                (move->turn == 0 || std::abs(turn - move->turn) < 0.01);
      if (move->turn == 0 && !arrived) return where("the path goes elsewhere");
    }
    if (!arrived) return where("the path has ended");
    if (move->feed > 0 && std::abs(seconds - 60 * length / move->feed) > 0.01 * seconds + 1e-3) {
      return where(fmt::format("{:.4g} s instead of {:.4g}", seconds, 60 * length / move->feed));
    }
    from = at == 0 ? start : segments[at - 1].end.translation;
  }
  if (at == segments.size()) return "";
  return fmt::format("the path goes on after {} of {} moves", at, segments.size());
}

/// A folder for the files of one run.
class GcodeJudge : public testing::Test {
 protected:
  void SetUp() override {
    folder_.write("judge.ini",
                  "[RS274NGC]\nPARAMETER_FILE = judge.var\nSUBROUTINE_PATH = .\n[EMCIO]\n"
                  "TOOL_TABLE = judge.tbl\n");
    setParameters({}, Point3::Zero());
    setTools({}, {});
  }

  /// Its units are inches, unless a machine says otherwise.
  void setTools(const std::map<int, double>& lengths,
                const std::map<int, double>& diameters) const {
    const auto inches = [](const std::map<int, double>& sizes, int tool) {
      const auto found = sizes.find(tool);
      return found == sizes.end() ? 0 : found->second / kMmPerInch;
    };
    std::string table;
    for (int tool = 1; tool < kTools; ++tool) {
      table += fmt::format("T{0} P{0} Z{1:.6f} D{2:.6f}\n", tool, inches(lengths, tool),
                           inches(diameters, tool));
    }
    folder_.write("judge.tbl", table);
  }

  void setParameters(const std::map<int, Point3>& offsets, const Point3& machineZero) const {
    std::map<int, double> values;
    for (int first : {5161, 5181, 5211}) {
      for (int i = 0; i < 9; ++i) values[first + i] = 0;
    }
    values[5220] = 1;
    for (int i = 5221; i < 5400; ++i) values[i] = 0;
    for (const auto& [code, point] : offsets) {
      const int system = code <= 590 ? (code - 540) / 10 : code - 590 + 5;
      const int place = code == 280 ? 5161 : code == 300 ? 5181 : 5221 + 20 * system;
      const Point3 value = code >= 540 ? Point3(point - machineZero) : point;
      for (int i = 0; i < 3; ++i) values[place + i] = value[i] / kMmPerInch;
    }
    if (!offsets.contains(540)) {
      for (int i = 0; i < 3; ++i) values[5221 + i] = -machineZero[i] / kMmPerInch;
    }
    std::string text;
    for (const auto& [number, value] : values) text += fmt::format("{}\t{:.6f}\n", number, value);
    folder_.write("judge.var", text);
  }

  /// What it prints, and whether it finds nothing wrong. It keeps its tools in a file of the home
  /// folder, which two runs at once would share.
  std::pair<bool, std::string> judge(const fs::path& program) const {
    const std::string command = fmt::format(
        "cd '{0}' && HOME='{0}' LD_LIBRARY_PATH='{1}/usr/lib' timeout 60 '{1}/usr/bin/rs274' -g "
        "-i judge.ini -t judge.tbl -v judge.var '{2}' > out.txt 2>&1 < /dev/null",
        folder_.path().string(), T4D_LINUXCNC, program.string());
    const int code = std::system(command.c_str());
    std::string text = platform::contents(folder_ / "out.txt");
    const bool ends = text.find("PROGRAM_END()") != std::string::npos;
    return {code == 0 && ends, std::move(text)};
  }

  platform::TestFolder folder_;
};

TEST_F(GcodeJudge, OurProgramsMoveAsLinuxCncMovesThem) {
  std::size_t judged = 0;
  for (const fixtures::MilledProgram& program : fixtures::milledPrograms()) {
    if (!program.rotaries.empty()) continue;
    SCOPED_TRACE(program.name);
    ToolPathOptions options{.tolerance = 1e-5};
    options.tools.emplace();
    for (const auto& [number, spec] : program.tools) options.tools->push_back(number);
    for (const auto& [number, length] : program.lengths) options.lengths[number] = {0, 0, length};
    options.diameters = fixtures::diametersOf(program);
    for (const std::string& offset : program.offsets) {
      ASSERT_TRUE(parseOffset(offset, options.offsets));
    }
    const auto path = readGcode(InputFile{program.name, program.text}, options);
    ASSERT_TRUE(path) << path.error().text();
    const Point3 machineZero =
        options.offsets.contains(530) ? options.offsets.at(530) : Point3::Zero().eval();
    setParameters(options.offsets, machineZero);
    setTools(program.lengths, options.diameters);
    folder_.write("program.ngc", program.text);
    const auto [good, text] = judge("program.ngc");
    EXPECT_TRUE(good) << text;
    CanonReader canon(machineZero, program.lengths);
    EXPECT_EQ(differenceOf(*path, canon.read(text)), "") << text;
    ++judged;
  }
  EXPECT_GE(judged, 20U);
}

/// Read from where they are installed. The machine begins at its zero.
TEST_F(GcodeJudge, ItsOwnExamplesMoveAsItMovesThem) {
  std::size_t same = 0;
  const std::map<int, double> diameters = [] {
    std::map<int, double> found;
    for (int tool = 1; tool < kTools; ++tool) found[tool] = 3.175;
    return found;
  }();
  setTools({}, diameters);
  for (const auto& entry :
       fs::directory_iterator(fs::path(T4D_LINUXCNC) / "usr/share/linuxcnc/ncfiles")) {
    if (entry.path().extension() != ".ngc") continue;
    SCOPED_TRACE(entry.path().filename());
    const std::string program = platform::contents(entry.path());
    ToolPathOptions options{.tolerance = 1e-5};
    options.start = Point3::Zero();
    options.diameters = diameters;
    options.offsets[530] = Point3::Zero();
    for (const int code : {540, 550, 560, 570, 580, 590, 591, 592, 593}) {
      options.offsets[code] = Point3::Zero();
    }
    auto path = readGcode(InputFile{"example", program}, options);
    if (!path && path.error().message.starts_with("a second tool")) {
      options.tools.emplace(kTools);
      std::iota(options.tools->begin(), options.tools->end(), 1);
      path = readGcode(InputFile{"example", "T1 M6 " + program}, options);
    }
    folder_.write("program.ngc", program);
    const auto [good, text] = judge("program.ngc");
    if (!path) {
      // Either refuses, or it is one of the words that docs/mill.md says are not read.
      EXPECT_TRUE(!good || path.error().code == ErrorCode::Unsupported ||
                  path.error().message.starts_with("nothing moves") ||
                  path.error().message.starts_with("a cutting move comes before a tool") ||
                  path.error().message.find("not longer than the radius") != std::string::npos)
          << path.error().text();
      std::cout << entry.path().filename() << ": " << path.error().text() << "\n";
      continue;
    }
    // It does not print where splines go, nor the feed of a spindle that is waited for.
    const bool tells = text.find("NURBS") == text.npos && text.find("SYNCH") == text.npos;
    if (!good || !tells) continue;
    std::vector<JudgedMove> moves = CanonReader(Point3::Zero(), {}).read(text);
    moves.insert(moves.begin(), {Point3::Zero(), true, kRounding});
    const std::string difference = differenceOf(*path, moves);
    EXPECT_EQ(difference, "");
    std::cout << entry.path().filename() << ": " << path->motion.segments.size() << " moves\n";
    same += difference.empty() ? 1 : 0;
  }
  EXPECT_GE(same, 16U);
}

}  // namespace
}  // namespace t4d::formats
