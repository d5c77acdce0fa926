#pragma once

#include <optional>
#include <string>

#include "formats/input_file.h"
#include "t4d/error.h"

namespace t4d::formats {

/// The table (joint_table.h) of a log of joints in another form; nothing of what is a table by
/// itself:
/// * JSON with one trajectory of ROS (trajectory_msgs: `joint_names` and `points`, also of poses,
///   which become `NAME.x` to `NAME.qw`) or states of
///   joints (sensor_msgs: `name` and `position`), at any depth, or a message on each line;
/// * the lines of `ros2 topic echo --csv` of states, which have no names of columns;
/// * a table with arrays in cells: `[0.1, 0.2]` in a column `q` become columns `q_0` and `q_1`, or
///   those of the joints that an array in a column `name` has.
/// Fails for JSON without joints or with several trajectories, and where joints change.
Result<std::optional<std::string>> tableOfLog(const InputFile& file);

}  // namespace t4d::formats
