#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "formats/input_file.h"
#include "formats/toolpath/gcode_arc.h"
#include "formats/toolpath/gcode_block.h"
#include "formats/toolpath/tool_path.h"

namespace t4d::formats {

/// The state of a machine that G-code sets line by line, and the path that its tool goes: modal
/// groups, offsets, canned cycles, tools and rotary axes. Where dialects differ it does as
/// LinuxCNC.
///
/// Positions are kept of the control point, in the frame of the stock with all rotary axes at zero:
/// what a line programs, plus the origin in force, G92 and the length offset (G43).
class GcodeMachine {
 public:
  explicit GcodeMachine(const ToolPathOptions& options);

  /// Does what a line says, in the order of RS-274. `line` is for notices.
  Result<void> apply(const GcodeBlock& block, std::uint64_t line);

  /// What parameters say of the machine; nothing if it is not known.
  std::optional<double> parameter(int number) const;
  std::optional<double> parameter(const std::string& name) const;

  /// The path, with notices that name places of the file.
  Result<ToolPath> finish(const InputFile& file);

 private:
  using Tenths = int;  // of a G word

  Result<void> checkWords(const GcodeBlock& block) const;
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
  Result<void> checkCut(bool cuts) const;
  Result<void> straight(const MachineAxes& to, bool rapid);
  Result<ArcWords> arcWords(const GcodeBlock& block, const MachineAxes& to) const;
  Result<void> arc(const GcodeBlock& block, const MachineAxes& to);
  Result<void> setSeries(const GcodeBlock& block);
  Result<void> cycle(const GcodeBlock& block);
  Result<void> go(const MachineAxes& to, double seconds, bool rapid);

  Result<void> useOrigin(std::size_t system);
  double offsetOf(int axis) const;
  double unitOf(int axis) const { return axis < 3 ? unit_ : 1; }
  Result<MachineAxes> targetOf(const GcodeBlock& block, std::array<bool, 3>& known) const;
  ToolPlace place(const MachineAxes& at) const;
  Result<void> startOrGo(const MachineAxes& to, const std::array<bool, 3>& known, bool rapid);
  std::string unknownAxes() const;
  std::string sinceLeftOut() const;
  void noteLengthOffset();

  const ToolPathOptions& options_;
  RotaryKinematics kinematics_;
  ToolPathBuilder builder_;
  std::uint64_t line_ = 0;
  std::size_t moves_ = 0;
  std::size_t dwells_ = 0;
  std::size_t leftOut_ = 0;         // moves to places of the machine that are not known
  std::uint64_t firstLeftOut_ = 0;  // line
  std::uint64_t lastLeftOut_ = 0;
  std::vector<std::pair<std::uint64_t, std::string>> notes_;  // with the line

  // Modal groups.
  std::optional<int> motion_;
  std::optional<int> motionBefore_;  // the cycles that are in force
  std::array<int, 3> plane_ = {0, 1, 2};
  double unit_ = 1;  // mm
  bool relative_ = false;
  bool relativeCentre_ = true;
  bool inverseTime_ = false;
  bool retractsToClear_ = true;  // G99, as LinuxCNC begins
  double feed_ = 0;              // mm/min
  double turnFeed_ = 0;          // degrees/min
  double inverseFeed_ = 0;       // 1/min, of this line

  // Tools.
  double selected_ = 0;
  std::optional<double> mounted_;
  bool cuts_ = false;  // whether a cutting move has been read
  Eigen::Vector3d length_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d lengthOffset_ = Eigen::Vector3d::Zero();
  bool tipControl_ = false;
  bool notedLength_ = false;  // of the tool mounted

  // Offsets.
  std::size_t system_ = 0;  // of G54 to G59.3
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

  MachineAxes at_ = {};
  std::array<bool, 3> known_ = {};
};

}  // namespace t4d::formats
