#pragma once

#include <string>

#include "t4d/formats/input_file.h"
#include "t4d/model/motion.h"

namespace t4d::formats {

/// Reads poses from a table (docs/motion.md): a line with the names of the columns, and a line for
/// each pose; or a comment with these names before the first pose. Columns are separated by commas,
/// semicolons, tabs or blanks, and may come in any order. Where no commas separate them, numbers
/// may have decimal commas. They are the time, and a position and a quaternion, or a matrix. Poses
/// are joined by screws (model::joinPoses).
///
/// Fails, with the line, on a missing or unknown column, a line of another length, a field that is
/// no number, a quaternion that is not about of length 1, a matrix that is not rigid, and on what
/// joinPoses refuses; and on commas that may be decimal or stand between thousands. `form` is set
/// to what is unusual about the table, for a note: empty, or "columns are separated by blanks,
/// ...".
Result<model::Motion> readMotionCsv(const InputFile& file, std::string* form = nullptr);

}  // namespace t4d::formats
