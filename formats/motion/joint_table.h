#pragma once

#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include "formats/input_file.h"
#include "t4d/error.h"

namespace t4d::formats {

/// Values of joints over time.
struct JointTable {
  struct Column {
    std::string name;       ///< as the table names the joint
    std::string unitless;   ///< the same without what may be a unit
    std::string unit = {};  ///< what that is; "" for none
    std::vector<double> values = {};
  };
  /// The column of a joint: of that name, or else of that name without a unit.
  struct Found {
    const Column* column = nullptr;  ///< null if there is none
    std::string unit = {};           ///< "" if the table does not say
  };
  Found find(const std::string& joint) const;
  std::vector<double> times;
  std::vector<Column> columns;
  std::string timeUnit;              ///< "" if unknown
  std::vector<std::string> notices;  ///< what is unusual about the table, one phrase each
};

/// Reads a table whose columns are the time (time_column.h) and joints, by their names: `shoulder`,
/// `shoulder_deg`, `shoulder [rad]`, or `/joint_states/shoulder/position`. Of a joint state as ROS
/// prints it, `name0` and `position0` and so on. Other columns with dots or slashes in their names
/// are skipped, with a notice, unless they are one of `joints`. Other forms of logs become such a
/// table first (joint_log.h). A row that repeats the time and the values of the row before is left
/// out, with a notice.
///
/// `timeUnit` is the unit that times are to have, "" for that of the table. Fails, with the line,
/// on what NumberTable refuses, without a time or a joint, on times that do not increase, and where
/// the joints of a ROS message change their order.
Result<JointTable> readJointTable(const InputFile& file, const std::string& timeUnit,
                                  const std::set<std::string>& joints = {});

}  // namespace t4d::formats
