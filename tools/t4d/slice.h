#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "slice/velocity.h"
#include "t4d/slice.h"
#include "t4d/surface.h"
#include "tools/t4d/input.h"
#include "tools/t4d/observer.h"
#include "tools/t4d/slice_write_options.h"

namespace t4d::tools {

class Members;

struct SliceOptions {
  /// Slice at this time: the solid as it is then, in x, y and z.
  std::optional<double> time = {};
  /// The hyperplane to slice by without a time, in the coordinates of slice::basisOf.
  slice::Hyperplane hyperplane = {};
  bool light = false;          ///< as slice::SliceDetail::Light; needs a time
  bool mergeCoplanar = false;  ///< as slice::mergeCoplanar
  /// Velocities and colours by time or speed need a time.
  SliceWriteOptions write = {};
  /// A file to write, in any of formats::writableTriangleMeshExtensions; "" for none.
  std::string output = {};
};

struct SliceMerge {
  std::uint64_t trianglesBefore = 0;
  double distance = 0;  ///< as slice::CoplanarMerge::distance, of all bodies
};

struct SliceReport {
  /// The section of each body, for a time of those that exist then; a section may have no
  /// triangles. They are coloured, but not centered. Attributes, if they are asked for, are as
  /// they were cut, with points and directions in x, y and z.
  std::vector<formats::NamedMesh> sections;
  std::uint64_t vertices = 0;
  std::uint64_t triangles = 0;
  bool closed = true;
  double volume = 0;  ///< enclosed, positive if triangles face outward
  double area = 0;
  std::uint64_t slabsRead = 0;
  std::uint64_t slabsSkipped = 0;
  std::uint64_t blocksRead = 0;
  std::uint64_t bytesRead = 0;  ///< of the file; 0 for a mesh in memory
  std::uint64_t requests = 0;   ///< to a web server
  bool light = false;           ///< whether all sections are light
  double distance = 0;          ///< as slice::LightSlice::distance, of all bodies
  std::optional<slice::VelocityReport> velocity = {};  ///< of all bodies; `ofPoints` if all are
  /// The smallest and largest value of what gives colours, if they come from numbers.
  std::optional<std::array<double, 2>> colorRange = {};
  std::optional<double> quantizationError = {};  ///< how far a coordinate may be from its place
  std::optional<SliceMerge> merge = {};
  std::vector<std::string> losses = {};  ///< of attributes, and of what the format cannot hold
};

/// Cuts a 4D mesh by a hyperplane (slice::slice, slice::LightSlicer), and writes the file. The
/// observer gets a notice of each body whose slice is not light as asked. Fails if no body exists
/// at the time, for an attribute that no body has, and if slicing or writing does.
Result<SliceReport> sliceMesh(const Input& input, const SliceOptions& options,
                              Observer& observer = nobody());

void describe(Members& members, const SliceReport& report);

}  // namespace t4d::tools
