#pragma once

#include <string>

#include "formats/input_file.h"
#include "t4d/motion.h"

namespace t4d::formats {

/// Reads poses from a table (docs/motion.md; number_table.h says how it may be written): the time
/// (time_column.h), a position, and a rotation as a quaternion, angles of roll, pitch and yaw, or a
/// rotation vector; or a matrix. A table without names has the columns of TUM, or those that
/// `options` say. Poses are joined by screws (model::joinPoses). A row that repeats the time and
/// the pose of the row before is left out.
///
/// Fails, with the line, on a missing or unknown column, a line of another length, a field that is
/// no number, a quaternion that is not about of length 1, a matrix that is not rigid, times that do
/// not increase, angles and quaternions of which neither the names nor `options` say what they are,
/// and on what joinPoses refuses. `form` is set to what is unusual about the table, for a note:
/// empty, or "columns are separated by blanks, ...".
Result<model::Motion> readMotionCsv(const InputFile& file, std::string* form = nullptr,
                                    const MotionTableOptions& options = {});

}  // namespace t4d::formats
