#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "t4d/error.h"

namespace t4d::formats {

/// The parameters of a G-code program: `#5`, `#<depth>`, `#<_speed>`. As in LinuxCNC, #1 to #30 and
/// names belong to the subprogram that is running, other numbers and names with an underscore to
/// the whole program, and numbers that have never been set are 0.
class GcodeParameters {
 public:
  /// What the control says of itself, by number or name: its position, offsets and tool.
  struct Control {
    std::function<std::optional<double>(int)> numbered;
    std::function<std::optional<double>(const std::string&)> named;
  };
  explicit GcodeParameters(Control control) : control_(std::move(control)), frames_(1) {}

  static constexpr int kMost = 5602;
  static constexpr std::size_t kArguments = 30;

  Result<double> value(double number) const;
  Result<double> value(const std::string& name) const;
  bool exists(double number) const;  ///< whether it has been set
  bool exists(const std::string& name) const;

  Result<void> set(double number, double value);
  Result<void> set(const std::string& name, double value);

  /// A subprogram begins, with its arguments by number, and ends.
  void enter(std::map<int, double> arguments);
  void leave() { frames_.pop_back(); }

 private:
  struct Frame {
    std::map<int, double> numbered;
    std::map<std::string, double> named;
  };
  const std::map<std::string, double>& namesOf(const std::string& name) const;

  Control control_;
  std::vector<Frame> frames_;
  std::unordered_map<int, double> numbered_;
  std::map<std::string, double> global_;
};

}  // namespace t4d::formats
