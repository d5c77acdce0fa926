#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "t4d/file.h"

/// Data in the details of bodies about a mechanism that they are part of.
namespace t4d::formats {

/// The rigid link that the body is a part of, beside others perhaps; by default the body itself.
std::string linkOf(const BodyInfo& body);
void setLink(BodyInfo& body, const std::string& link);

/// A bound on the distance of slices from the true solid at their time, and the other way round, in
/// length units, for poses between which the motion is not a screw. Nothing if it is not stated.
std::optional<double> chordBoundOf(const BodyInfo& body);
void setChordBound(BodyInfo& body, double bound);

/// The values of a joint over time, between which they go evenly.
struct JointCourse {
  std::string name = {};
  std::string unit = {};  ///< "" if unknown
  std::vector<double> times = {};
  std::vector<double> values = {};  ///< one for each time, at least one

  /// The value at a time; before the first and after the last that of these.
  double at(double time) const;
};

/// The joints that the details of a file (Metadata::detailsJson) have; none of others.
std::vector<JointCourse> jointsOf(const std::string& detailsJson);
/// The member `joints` of these details, as JSON.
std::string jointsJson(const std::vector<JointCourse>& joints);

/// The changes that mending made to the solid before it was swept.
struct MendedInfo {
  std::optional<double> volumeBefore = {};  ///< nothing if the surface was open
  double volumeAfter = 0;
  double hausdorff = 0;             ///< between the surfaces before and after, in length units
  std::uint64_t lostTriangles = 0;  ///< dropped outside of the mended solid
  double lostDistance = 0;          ///< how far they were outside of it, in length units
  bool hull = false;                ///< it became its convex hull
};

/// The data about mending; nothing if the solid was not mended, or had nothing to mend.
std::optional<MendedInfo> mendedInfoOf(const BodyInfo& body);
void setMendedInfo(BodyInfo& body, const MendedInfo& info);

}  // namespace t4d::formats
