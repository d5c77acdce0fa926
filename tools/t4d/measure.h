#pragma once

#include <optional>
#include <string>
#include <vector>

#include "t4d/check.h"
#include "t4d/mesh.h"
#include "tools/t4d/input.h"
#include "tools/t4d/observer.h"

namespace t4d::tools {

class Members;

struct MeasureOptions {
  std::vector<double> times = {};  ///< in any order; none for 60, evenly spaced over the whole time
  model::Part part = {};           ///< the share of the times that is measured
  bool eachBody = true;            ///< of several bodies each, too
  bool thickness = false;          ///< the mean thickness of walls, too
  bool normalSpeed = false;        ///< the mean normal speed, too
};

/// Measures that are made if they are asked for, as means over the area.
struct WallMeasures {
  std::optional<double> thickness;    ///< wallThickness
  std::optional<double> normalSpeed;  ///< meanNormalSpeed
};

/// One of several bodies.
struct BodyMeasures {
  std::string name;
  std::vector<measure::SolidMeasures> samples;  ///< at the same times
  std::vector<WallMeasures> walls;
};

struct MeasureReport {
  std::vector<measure::SolidMeasures> samples;  ///< of all bodies together, in the order of times
  std::vector<WallMeasures> walls;              ///< of all bodies together
  std::vector<BodyMeasures> bodies;             ///< each of several; none of one
  std::string lengthUnit;                       ///< "" if unknown
  std::string timeUnit;
};

/// Measures bodies, and the solid of all of them, at times (measure::measuresOfEach): volume, area,
/// centroid, components, cavities, genus and bounds. Fails for a time before the first body or
/// after the last.
Result<MeasureReport> measure(const Input& input, const MeasureOptions& options = {},
                              Observer& observer = nobody());

/// A table with the columns time,volume,area,cx,cy,cz,components,genus,cavities,min_x,min_y,min_z,
/// max_x,max_y,max_z,length_unit,time_unit, the units the same in all rows, and before them
/// wall_thickness and normal_speed if they were asked for. Of several bodies it has a row for each
/// at each time, and a column `body` behind the time. Where there is no solid, places are empty.
std::string measuresCsv(const MeasureReport& report);

void describe(Members& members, const MeasureReport& report);

}  // namespace t4d::tools
