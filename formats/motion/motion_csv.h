#pragma once

#include <string>

#include "model/motion.h"

namespace t4d::formats {

struct InputFile;

/// What the names of the columns of a table of poses may leave open.
struct MotionTableOptions {
  /// What the angles are: "rpy:deg", "rpy:rad", "rotvec:deg" or "rotvec:rad"; "" if names say it.
  std::string angles = {};
  /// The order of the four numbers of a quaternion: "xyzw" or "wxyz"; "" if names say it.
  std::string quaternion = {};
  /// The units of positions and times. Columns that name another unit are converted to these.
  std::string lengthUnit = {};
  std::string timeUnit = {};

  bool empty() const {
    return angles.empty() && quaternion.empty() && lengthUnit.empty() && timeUnit.empty();
  }
};

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
