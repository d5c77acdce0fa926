#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "formats/input_file.h"
#include "formats/toolpath/gcode_arc.h"
#include "formats/toolpath/gcode_block.h"
#include "formats/toolpath/gcode_compensation.h"
#include "formats/toolpath/gcode_dialect.h"
#include "formats/toolpath/tool_path.h"

namespace t4d::formats {

/// The state of a machine that G-code sets line by line, and the path that its tool goes: modal
/// groups, offsets, canned cycles, tools and rotary axes. Where dialects differ it does as
/// LinuxCNC.
///
/// Positions are kept of the control point, in the frame of the stock with all rotary axes at zero,
/// as if the program were not turned: what a line programs, plus the origin in force, G92 and the
/// length offset (G43). What turns, scales or mirrors the program (G10 L2 R, G68, G51, G51.1) comes
/// after that, in place().
class GcodeMachine {
 public:
  GcodeMachine(const ToolPathOptions& options, const GcodeHabits& habits);

  /// Does what a line says, in the order of RS-274. `line` is for notices, `depth` that of calls.
  Result<void> apply(const GcodeBlock& block, std::uint64_t line, std::size_t depth);

  /// What parameters say of the machine; nothing if it is not known.
  std::optional<double> parameter(int number) const;
  std::optional<double> parameter(const std::string& name) const;

  /// The path, with notices that name places of the file.
  Result<ToolPath> finish(const InputFile& file);

 private:
  using Tenths = int;  // of a G word

  /// What words mean that stay in force until others come.
  struct Modes {
    std::array<int, 3> plane = {0, 1, 2};
    double unit = 1;  // mm
    bool relative = false;
    bool relativeCentre = true;
    bool inverseTime = false;
    bool perTurn = false;         // G95
    bool retractsToClear = true;  // G99, as LinuxCNC begins
    bool polar = false;           // G16
    double feed = 0;              // mm/min, or mm a turn
    double turnFeed = 0;          // degrees/min
    double spindle = 0;           // turns/min
    std::size_t system = 0;       // of G54 to G59.3
  };

  void keepModes(const GcodeBlock& block, std::size_t depth);
  void takeWholeNumbers(GcodeBlock& block);
  Result<void> checkWords(const GcodeBlock& block) const;
  Result<void> checkHeldMoves(const GcodeBlock& block) const;
  Result<void> checkRotaries(const GcodeBlock& block) const;
  Result<void> setFeed(const GcodeBlock& block);
  Result<void> setTool(const GcodeBlock& block);
  Result<void> mount(double tool);
  Result<void> setModes(const GcodeBlock& block);
  Result<void> setToolLength(Tenths code, const GcodeBlock& block);
  void controlTip(bool on);

  Result<void> applyNonModal(Tenths code, const GcodeBlock& block);
  Result<void> setOrigin(const GcodeBlock& block);
  Result<void> shiftOrigin(Tenths code, const GcodeBlock& block);
  Result<void> goToReference(Tenths code, const GcodeBlock& block);
  Result<void> moveInMachine(const GcodeBlock& block);
  Result<void> goInMachine(const GcodeBlock& axes, const std::optional<MachineAxes>& place,
                           bool rapid);

  Result<void> move(const GcodeBlock& block);
  Result<void> checkCut(bool cuts);
  Result<void> beginAtStart();
  bool comesFromStart(const GcodeBlock& block);
  Result<void> straight(const MachineAxes& to, bool rapid);
  double secondsOf(const MachineAxes& to, bool rapid) const;
  Result<ArcWords> arcWords(const GcodeBlock& block, const MachineAxes& to) const;
  Result<void> arc(const GcodeBlock& block, const MachineAxes& to, bool approaches);
  double scaleInPlane() const;
  Result<void> goAlong(const Arc& arc, const MachineAxes& to, double seconds, bool rapid);
  Result<void> spline(const GcodeBlock& block, const MachineAxes& to, bool approaches);
  Result<void> addNurbsPoint(const GcodeBlock& block, const MachineAxes& to);
  Result<void> endNurbs();
  Result<void> goAlong(const std::function<Eigen::Vector2d(double)>& curve, const MachineAxes& to,
                       bool rapid);
  Result<void> thread(const GcodeBlock& block, const MachineAxes& to);
  double repeatsOf(const GcodeBlock& block) const;
  Result<void> setSeries(const GcodeBlock& block);
  Result<void> cycle(const GcodeBlock& block);
  Result<void> go(const MachineAxes& to, double seconds, bool rapid);

  Result<void> setCompensation(Tenths code, const GcodeBlock& block);
  Result<void> endCompensation();
  Result<void> goCompensated(const CompensatedMove& move);
  double lengthBetween(const MachineAxes& from, const MachineAxes& to) const;

  /// The end of a straight move that waits for the next one.
  struct Corner {
    MachineAxes from = {};
    MachineAxes at = {};
    double size = 0;  // mm
    bool chamfer = false;
    std::uint64_t line = 0;
  };
  std::string missingAfterCorner() const;
  Result<void> turnCorner(const GcodeBlock& block, const MachineAxes& to);
  Result<void> roundCorner(const Corner& corner, const MachineAxes& to);

  Result<void> dwell(const GcodeBlock& block);
  Result<void> setTurns(const GcodeBlock& block);
  Result<void> setScale(const GcodeBlock& block);
  model::Point3 pointOf(const GcodeBlock& block) const;
  MachineAxes turnedAxes(const MachineAxes& at) const;
  MachineAxes unturnedAxes(const MachineAxes& at) const;
  Eigen::Vector2d polar(const GcodeBlock& block, const MachineAxes& at) const;
  void turnAgain();
  double feedOf() const;

  Result<void> useOrigin(std::size_t system);
  double offsetOf(int axis) const;
  double unitOf(int axis) const { return axis < 3 ? modes_.unit : 1; }
  Result<MachineAxes> targetOf(const GcodeBlock& block, const MachineAxes& from,
                               std::array<bool, 3>& known) const;
  ToolPlace place(const MachineAxes& at) const;
  Result<void> startOrGo(const MachineAxes& to, const std::array<bool, 3>& known, bool rapid);
  std::string unknownAxes() const;
  std::string sinceLeftOut() const;
  void noteLengthOffset();

  const ToolPathOptions& options_;
  GcodeHabits habits_;
  RotaryKinematics kinematics_;
  ToolPathBuilder builder_;
  std::uint64_t line_ = 0;
  std::size_t moves_ = 0;
  std::size_t dwells_ = 0;
  double dwell_ = 0;                // seconds
  std::size_t wholeNumbers_ = 0;    // that were taken as thousandths
  std::uint64_t firstWhole_ = 0;    // line
  std::size_t leftOut_ = 0;         // moves to places of the machine that are not known
  std::uint64_t firstLeftOut_ = 0;  // line
  std::uint64_t lastLeftOut_ = 0;
  std::vector<std::pair<std::uint64_t, std::string>> notes_;  // with the line

  // Modal groups.
  std::optional<int> motion_;
  std::optional<int> motionBefore_;  // the cycles that are in force
  Modes modes_;
  struct Saved {
    Modes modes;
    bool restores = false;  // when the subprogram ends
  };
  std::map<std::size_t, Saved> saved_;  // by the depth of calls
  double inverseFeed_ = 0;              // 1/min, of this line

  // Tools.
  double selected_ = 0;
  std::optional<double> mounted_;
  bool cuts_ = false;  // whether a cutting move has been read
  Eigen::Vector3d length_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d lengthOffset_ = Eigen::Vector3d::Zero();
  bool tipControl_ = false;
  bool notedLength_ = false;  // of the tool mounted

  // Offsets.
  std::array<std::optional<MachineAxes>, 9> origins_ = {};
  std::optional<std::size_t> unstated_;  // the system that is the stock's frame
  MachineAxes shift_ = {};               // G92
  MachineAxes storedShift_ = {};
  std::optional<MachineAxes> machineZero_;
  std::array<std::optional<MachineAxes>, 2> references_ = {};  // G28, G30

  // What a series of canned cycles keeps.
  struct Series {
    int code = 0;
    double level = 0;  // where it began
    std::optional<double> clear = {}, bottom = {}, peck = {};
  };
  std::optional<Series> series_;

  // What turns the program, in the plane and about points of the frame that is not turned.
  std::array<double, 9> turns_ = {};  // degrees, of G10 R, by system
  struct Turn {
    std::array<int, 3> plane = {0, 1, 2};
    model::Point3 about = model::Point3::Zero();
    double degrees = 0;
  };
  std::optional<Turn> turn_;  // G68
  struct Scale {
    model::Point3 about = model::Point3::Zero();
    Eigen::Vector3d factors = Eigen::Vector3d::Ones();
  };
  std::optional<Scale> scale_;   // G51
  std::optional<Scale> mirror_;  // G51.1
  std::optional<Eigen::Affine3d> turned_;

  MachineAxes at_ = {};    // what the program says
  MachineAxes tool_ = {};  // the same, but where the cutter is compensated
  std::array<bool, 3> known_ = {};
  std::array<bool, 3> assumed_ = {};          // of these, the axes that begin at the start
  std::optional<Eigen::Vector2d> splineEnd_;  // P, Q of the G5 before
  struct Nurbs {
    std::size_t order = 3;
    std::vector<Eigen::Vector3d> points;  // with their weights as the third number
  };
  std::optional<Nurbs> nurbs_;  // G5.2, until G5.3
  std::optional<CutterCompensation> compensation_;
  std::optional<Corner> corner_;
};

}  // namespace t4d::formats
