#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "formats/triangle/rounding_loss.h"
#include "t4d/surface.h"

namespace t4d::formats {

/// The name of the vertex attribute that is written as `velocities`: three components, in length
/// units per second of playback.
inline constexpr std::string_view kUsdVelocity = "velocity";

/// A property of a USD prim with a value.
struct UsdValue {
  std::string type;  ///< "point3f[]"
  std::string name;
  std::string metadata = {};  ///< `interpolation = "vertex"`, or ""
  /// Players interpolate between samples: so they do with floating-point numbers, and not with
  /// integers and tokens.
  bool interpolated = true;
  std::function<std::string()> text;  ///< makes the value
};

/// What a Mesh prim has of a mesh, which must outlive these: its triangles, its points less
/// `center`, their extent, and normals, colours, velocities and attributes where the mesh has them
/// or the options ask for them. Fails as checkWritable, and for what int and float do not hold.
Result<std::vector<UsdValue>> usdMeshValues(const NamedMesh& named, const model::Point3& center,
                                            const MeshWriteOptions& options, RoundingLoss& rounding,
                                            std::vector<std::string>& lost);

/// The shortest text that reads back as the number.
std::string usdNumber(double number);
/// "(x,y,z)"
std::string usdTuple(std::initializer_list<double> numbers);
/// The text in quotes, with escapes.
std::string usdString(std::string_view text);
/// The name with everything but ASCII letters, digits and `_` replaced by `_`, and `_` before a
/// digit: what USD allows in every version.
std::string usdName(std::string_view name);

}  // namespace t4d::formats
