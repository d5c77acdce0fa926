#pragma once

#include <string>
#include <vector>

#include "t4d/measure/solid_measures.h"
#include "t4d/model/part.h"
#include "t4d/verbs/input.h"
#include "t4d/verbs/observer.h"

namespace t4d::verbs {

struct MeasureOptions {
  std::vector<double> times = {};  ///< in any order; none for 60, evenly spaced over the whole time
  model::Part part = {};           ///< the share of the times that is measured
};

struct MeasureReport {
  std::vector<measure::SolidMeasures> samples;  ///< of all bodies together, in the order of times
};

/// Measures the solid of all bodies at times (measure::measuresAt): volume, area, centroid,
/// components, cavities, genus and bounds. Fails for a time before the first body or after the
/// last.
Result<MeasureReport> measure(const Input& input, const MeasureOptions& options = {},
                              Observer& observer = nobody());

/// A table with the columns time,volume,area,cx,cy,cz,components,genus,cavities,min_x,min_y,min_z,
/// max_x,max_y,max_z. Where there is no solid, places are empty.
std::string measuresCsv(const MeasureReport& report);

/// The report as JSON (docs/schemas/measure.schema.json).
std::string jsonOf(const MeasureReport& report);

}  // namespace t4d::verbs
