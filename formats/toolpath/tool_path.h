#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "formats/toolpath/rotary_kinematics.h"
#include "platform/file_format.h"
#include "t4d/error.h"
#include "t4d/mesh.h"
#include "t4d/motion.h"

namespace t4d::formats {

/// From this time on the spindle holds this tool, or none. 0 is the one without a number.
struct Mounting {
  double time = 0;
  std::optional<int> tool = {};
};

/// How a cutting tool moves: its tip is the origin of the tool, which points along +z from there.
struct ToolPath {
  model::Motion motion = {};                 ///< in mm and s
  std::vector<model::TimeSpan> rapids = {};  ///< moves that must not cut
  /// In order of time; if empty, the one tool, which has no number, is mounted throughout.
  std::vector<Mounting> mountings = {};
  std::size_t moves = 0;                  ///< in the file; an arc is one
  double dwell = 0;                       ///< seconds, which the motion does not have
  std::size_t unknownMoves = 0;           ///< to places of the machine whose zero is not given
  std::vector<std::string> notices = {};  ///< one sentence each
};

/// Where the dialects of controls differ.
enum class GcodeDialect : std::uint8_t { LinuxCnc, Grbl, Fanuc, Haas, Mach3, Siemens };

/// "linuxcnc" and so on; nothing for another name.
std::optional<GcodeDialect> gcodeDialect(std::string_view name);

struct ToolPathOptions {
  double tolerance = 0.01;    ///< mm; the farthest that chords of arcs are from them
  double rapidFeed = 10'000;  ///< mm/min
  /// The tools that can be mounted, by number; none: one tool mills, whatever its number.
  std::optional<std::vector<int>> tools = {};
  /// How far each tool reaches below the control point, in mm; empty if tips are programmed.
  std::map<int, Eigen::Vector3d> lengths = {};
  /// Origins in the frame of the stock, in mm, by G words in tenths: 540 to 593; 530, the zero of
  /// the machine; and from there the places 280 and 300, to which G28 and G30 go.
  std::map<int, model::Point3> offsets = {};
  std::vector<RotaryAxis> rotaries = {};
  /// Where the control point is in the frame of the stock, in mm, before a program says so. If it
  /// is not given, a program that cuts before begins at `assumedStart`, or at the zero of the
  /// machine where that is known, with a notice; and what it would cut on the way from there is
  /// drawn as a rapid move.
  std::optional<model::Point3> start = {};
  model::Point3 assumedStart = model::Point3::Zero();
  std::optional<double> defaultFeed = {};  ///< mm/min, where a program gives none
  /// Of the tools, by number, in mm: what G41 and G42 keep the path away from the programmed one.
  /// 0 is that of a tool without a number.
  std::map<int, double> diameters = {};
  std::optional<GcodeDialect> dialect = {};  ///< none: guessed
  /// X, Y and Z are always those of the tip in the frame of the stock, as after G43.4.
  bool tipControl = false;
  double reach = 100;  ///< mm; how far from its tip the tool must be right as it turns
  /// Maximum number of lines that a program may execute beyond those it has; more are refused, as
  /// the program may never end.
  std::uint64_t repeatedLines = 5'000'000;
};

/// G-code, cutter locations and tables of tools. Machines give them any extension.
std::vector<platform::FileFormat> toolPathFormats();

/// Reads `x,y,z`.
Result<model::Point3> parsePoint(std::string_view text);

/// Reads `G55=x,y,z` into ToolPathOptions::offsets.
Result<void> parseOffset(std::string_view text, std::map<int, model::Point3>& offsets);

/// Builds a tool path from moves that are straight for the tip, while the tool turns evenly about
/// it by the smallest angle.
class ToolPathBuilder {
 public:
  static constexpr double kTurnDegreesPerSecond = 36;  ///< of rapid turns
  static constexpr double kNoWay = 1e-9;               ///< mm; less is rounding, and no move

  /// The options must outlive this.
  explicit ToolPathBuilder(const ToolPathOptions& options);

  bool started() const { return started_; }
  bool isAway() const { return away_; }
  double time() const { return time_; }
  const model::Point3& tip() const { return tip_; }

  /// `axis` is the direction from the tip to the shank; any length but zero.
  void start(const model::Point3& tip, const Eigen::Vector3d& axis = Eigen::Vector3d::UnitZ());

  /// In `seconds`. No way and no turn are no move. Fails for more segments than a motion can have,
  /// and if the tool would turn by half a turn, which could be any way round.
  Result<void> moveTo(const model::Point3& tip, const Eigen::Vector3d& axis, double seconds,
                      bool rapid);
  Result<void> moveTo(const model::Point3& tip, double seconds, bool rapid) {
    return moveTo(tip, axis_, seconds, rapid);
  }

  /// The angle in degrees from the present axis to another one.
  double turnTo(const Eigen::Vector3d& axis) const;

  /// A tool, or none, is in the spindle from now on. Fails (Remedy::EachTool) if it is not
  /// among those that are given.
  Result<void> mount(std::optional<int> tool);

  /// The tool goes somewhere that is not known, as if none were mounted, until it comes back.
  void leave();
  Result<void> comeBack(const model::Point3& tip, const Eigen::Vector3d& axis);

  /// Fails if nothing moved.
  Result<ToolPath> finish();

  ToolPath path;  ///< of which `moves`, `unknownMoves` and `notices` are the caller's

 private:
  void hold(std::optional<int> tool);

  const ToolPathOptions& options_;
  std::optional<int> tool_;  // 0 if tools have no numbers
  bool started_ = false;
  bool away_ = false;
  double time_ = 0;
  model::Point3 tip_ = model::Point3::Zero();
  Eigen::Vector3d axis_ = Eigen::Vector3d::UnitZ();
  model::Pose pose_;
};

}  // namespace t4d::formats
